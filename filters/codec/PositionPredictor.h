// SPDX-License-Identifier: BSD-3-Clause
// Predicts the positions of a piece's vertices, one after the other in the order of the walk, by
// parallelograms of earlier vertices. Only the difference from the prediction is coded
// (PositionReader.h, PositionWriter.cxx). Layout: doc/formats.md, "Positions".
//
// The position of a vertex along a surface is hard to predict, but it hardly lies off the surface:
// a smooth surface continues the plane of the triangles before it (SurfacePlane). So two
// coordinates can be stored first; from them the plane predicts the third, which then needs fewer
// bits.
//
// A coordinate on the grid is an integer, 0 … 2^bits - 1, and is predicted in integers. A lossless
// coordinate is predicted in doubles, by a few operations that give the same bits everywhere. The
// coded difference is that between the ordered bits of the coordinate and of the prediction.
#pragma once

#include "filters/codec/ByteStream.h"
#include "filters/codec/CoordinateGrid.h"
#include "filters/codec/PieceContexts.h"
#include "filters/codec/TriangleWalk.h"
#include "filters/core/BitCast.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>

namespace kdstream
{

// Which differences are stored, and under which tables. The enumerators' values are part of the
// format.
enum class AxisTables : std::uint8_t
{
  Shared = 0, // along x, y, z; one table
  Each = 1,   // one for each axis
  Plane = 2   // first along two axes, then the distance from the plane of the triangles before
};

// How a piece's positions are coded; chosen by the writer.
struct PositionMode
{
  // How far beyond an edge the prediction lies, in eighths of the distance of the apex on the other
  // side. 8 completes the parallelogram; less suits noisy surfaces.
  unsigned reach = 8;
  AxisTables tables = AxisTables::Shared;
};
inline constexpr unsigned mostReach = 8;

// Predicts coordinates on the grid, which are below 2^24; halves are rounded up. Works on all axes
// at once, modulo 2^32. A reader must call Check for every point, because a malformed blob can give
// points outside the grid.
class GridPredictor
{
public:
  static constexpr bool hasPlanes = true;
  using Point = std::uint32_t __attribute__((vector_size(16))); // x, y, z, unused
  using Differences = Point;
  static constexpr unsigned differenceBits = 27; // a difference as an unsigned number (Zigzag)

  GridPredictor(const CoordinateGrid& grid, unsigned reach)
    : Most(Point{} + grid.Most())
    , EdgeWeight(Point{} + (8 + reach))
    , ApexWeight(Point{} + 2 * reach)
  {
  }

  static Point PointOf(const Vec3& position, const CoordinateGrid& grid)
  {
    const auto [x, y, z] = grid.Quantize(position);
    return Point{ x, y, z, 0 };
  }
  static Vec3 PositionOf(const Point& point, const CoordinateGrid& grid)
  {
    return grid.At({ point[0], point[1], point[2] });
  }
  // A key that ascends with (x, y, z), as far as 64 bits can distinguish points.
  static std::uint64_t SortKeyOf(const Point& point)
  {
    return std::uint64_t{ point[0] } << 40 | std::uint64_t{ point[1] } << 16 | point[2] >> 8;
  }

  // The mean prediction of two parallelograms. edges: the sum of the four vertices on their edges;
  // apexes: the sum of the two apexes.
  KDSTREAM_IN_LOOPS Point Predict(const Point& edges, const Point& apexes) const
  {
    using Signed = std::int32_t __attribute__((vector_size(16)));
    const auto sum = Signed(this->EdgeWeight * edges - this->ApexWeight * apexes + 16);
    const Point steps = Point(sum & (sum > 0)) >> 5;
    const auto isLess = Point(steps < this->Most);
    return (steps & isLess) | (this->Most & ~isLess);
  }
  std::int64_t DifferenceOf(const Point& point, const Point& predicted, std::size_t axis) const
  {
    return std::int64_t{ point[axis] } - std::int64_t{ predicted[axis] };
  }
  KDSTREAM_IN_LOOPS Point At(const Point& predicted, const Differences& differences) const
  {
    return predicted + differences;
  }
  // Notes in `outside` if the point is outside the grid. Call it for all points with the same
  // `outside`, zero at first; then IsAny tells whether any point was outside.
  KDSTREAM_IN_LOOPS void Check(const Point& point, Point& outside) const
  {
    outside |= Point(point > this->Most);
  }
  static bool IsAny(const Point& outside) { return (outside[0] | outside[1] | outside[2]) != 0; }

private:
  Point Most, EdgeWeight, ApexWeight;
};

// The same for exact coordinates; those that are not finite count as outside.
class ExactPredictor
{
public:
  static constexpr bool hasPlanes = false;
  using Point = Vec3;
  using Differences = std::array<std::int64_t, 3>;
  static constexpr unsigned differenceBits = 64;

  ExactPredictor(const CoordinateGrid& grid, unsigned reach)
    : IsFloat(grid.scalarType == ScalarType::Float32)
    , EdgeWeight(8 + reach)
    , ApexWeight(2 * reach)
  {
  }

  static Point PointOf(const Vec3& position, const CoordinateGrid& grid)
  {
    return grid.Snap(position);
  }
  static Vec3 PositionOf(const Point& point, const CoordinateGrid&) { return point; }
  static std::uint64_t SortKeyOf(const Point& point)
  {
    return OrderedBits(point[0] + 0.0); // -0.0 becomes 0.0
  }

  Point Predict(const Point& edges, const Point& apexes) const
  {
    const double most = this->IsFloat ? double(std::numeric_limits<float>::max())
                                      : std::numeric_limits<double>::max();
    Point predicted;
    for (std::size_t k = 0; k < 3; ++k)
    {
      const double value =
        (this->EdgeWeight * edges[k] - this->ApexWeight * apexes[k]) * (1.0 / 32);
      predicted[k] = std::abs(value) <= most ? (this->IsFloat ? double(float(value)) : value) : 0;
    }
    return predicted;
  }
  std::int64_t DifferenceOf(const Point& point, const Point& predicted, std::size_t axis) const
  {
    if (this->IsFloat)
    {
      return static_cast<std::int32_t>(OrderedBits(static_cast<float>(point[axis])) -
                                       OrderedBits(static_cast<float>(predicted[axis])));
    }
    return static_cast<std::int64_t>(OrderedBits(point[axis]) - OrderedBits(predicted[axis]));
  }
  // Computes modulo the width of the type.
  Point At(const Point& predicted, const Differences& differences) const
  {
    Point point;
    for (std::size_t k = 0; k < 3; ++k)
    {
      point[k] = this->IsFloat ? FloatOfOrderedBits(OrderedBits(static_cast<float>(predicted[k])) +
                                                    static_cast<std::uint32_t>(differences[k]))
                               : DoubleOfOrderedBits(OrderedBits(predicted[k]) +
                                                     static_cast<std::uint64_t>(differences[k]));
    }
    return point;
  }
  void Check(const Point& point, Point& outside) const
  {
    for (std::size_t k = 0; k < 3; ++k)
    {
      outside[k] += std::abs(point[k]) <= std::numeric_limits<double>::max() ? 0 : 1;
    }
  }
  static bool IsAny(const Point& outside) { return outside[0] + outside[1] + outside[2] > 0; }

private:
  bool IsFloat;
  double EdgeWeight, ApexWeight;
};

inline Vec3 operator+(const Vec3& a, const Vec3& b)
{
  return { a[0] + b[0], a[1] + b[1], a[2] + b[2] };
}

// The predicted position of a guided vertex. REQUIRES: the points before it are set.
template <class Predictor>
KDSTREAM_IN_LOOPS typename Predictor::Point Predicted(
  const Predictor& predictor, const WalkVertex& vertex, const typename Predictor::Point* points)
{
  const auto& [a, b, c] = vertex.gate;
  const auto& [d, e, f] = vertex.second;
  return predictor.Predict(
    (points[a] + points[b]) + (points[d] + points[e]), points[c] + points[f]);
}

// The same for any vertex. A vertex without a parallelogram is predicted at the place of an earlier
// one.
template <class Predictor>
KDSTREAM_IN_LOOPS typename Predictor::Point Predicted(const Predictor& predictor,
  std::span<const WalkVertex> vertices, std::size_t v, const typename Predictor::Point* points)
{
  if (vertices[v].guided != 0)
  {
    return Predicted(predictor, vertices[v], points);
  }
  return v > 0 ? points[vertices[v].gate[0]] : typename Predictor::Point{};
}

// The plane of the triangle from which the walk reached a guided vertex. The normal is exact for
// points on the grid; everything computed from it is in doubles, and each operation rounds. (If the
// second triangle's plane were used too, weighted by area, a level would take 0.1 % fewer bytes,
// but decoding would take longer.)
class SurfacePlane
{
public:
  using Point = GridPredictor::Point;

  KDSTREAM_IN_LOOPS SurfacePlane(const WalkVertex& vertex, const Point* points)
  {
    const auto [x, y, z] = NormalOf(vertex.gate, points);
    const std::uint64_t sizeX = Size(x), sizeY = Size(y), sizeZ = Size(z);
    // Masks instead of branches, which processors would often predict wrongly.
    const std::uint64_t isZ = Mask(sizeZ > sizeX) & Mask(sizeZ > sizeY);
    const std::uint64_t isY = Mask(sizeY > sizeX) & ~isZ, isX = ~(isY | isZ);
    this->Across = static_cast<std::uint32_t>((isY & 1) | (isZ & 2));
    this->OfAcross = Value((x & isX) | (y & isY) | (z & isZ));
    this->Ahead = Value((y & isX) | (z & isY) | (x & isZ));
    this->Behind = Value((z & isX) | (x & isY) | (y & isZ));
  }

  // The differences along x, y and z in the order in which they are stored: first along the two
  // axes that lie most in the plane (those that follow the third axis cyclically), then the
  // distance of the vertex from the plane along the third.
  Point Coded(const Point& difference) const
  {
    const Point coded{ difference[(this->Across + 1) % 3], difference[(this->Across + 2) % 3] };
    return Point{ coded[0], coded[1], difference[this->Across] - this->OffPlane(coded) };
  }
  // The inverse of Coded.
  KDSTREAM_IN_LOOPS Point Decoded(const Point& coded) const
  {
    const Point axis = Point{} + this->Across;
    const auto isY = Point(axis == 1), isZ = Point(axis == 2);
    const Point ofX{ coded[2], coded[0], coded[1] }, ofY{ coded[1], coded[2], coded[0] };
    const Point turned = (ofX & ~(isY | isZ)) | (ofY & isY) | (coded & isZ);
    return turned + ((Point{} + this->OffPlane(coded)) & Point(axis == Point{ 0, 1, 2, 3 }));
  }

private:
  // Signed numbers modulo 2^64, because a malformed blob can give any points.
  KDSTREAM_IN_LOOPS static std::array<std::uint64_t, 3> NormalOf(
    const std::array<std::uint32_t, 3>& triangle, const Point* points)
  {
    const Point &a = points[triangle[0]], &b = points[triangle[1]], &c = points[triangle[2]];
    const auto side = [](std::uint32_t from, std::uint32_t to)
    { return std::uint64_t{ to } - std::uint64_t{ from }; };
    const std::uint64_t ux = side(a[0], b[0]), uy = side(a[1], b[1]), uz = side(a[2], b[2]);
    const std::uint64_t vx = side(a[0], c[0]), vy = side(a[1], c[1]), vz = side(a[2], c[2]);
    return { uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx };
  }
  static std::uint64_t Size(std::uint64_t number)
  {
    const std::uint64_t sign = 0 - (number >> 63);
    return (number ^ sign) - sign;
  }
  static std::uint64_t Mask(bool set) { return 0 - std::uint64_t{ set }; }
  static double Value(std::uint64_t number) { return double(static_cast<std::int64_t>(number)); }

  // The coordinate of the plane along the third axis, rounded to the nearest step (halves to even),
  // modulo 2^32. The plane rises by no more than the other two coordinates together, because its
  // normal is longest along the third axis.
  KDSTREAM_IN_LOOPS std::uint32_t OffPlane(const Point& coded) const
  {
    const double sum = this->Ahead * double(static_cast<std::int32_t>(coded[0])) +
                       this->Behind * double(static_cast<std::int32_t>(coded[1]));
    // A double of this size has no bits for fractions, and holds the integer in its lowest bits.
    constexpr double rounds = 6755399441055744.0; // 1.5 * 2^52
    // Without a normal the sum is 0.
    const double rise = sum / (this->OfAcross == 0 ? 1 : this->OfAcross);
    return static_cast<std::uint32_t>(BitCast<std::uint64_t>(rounds - rise));
  }

  std::uint32_t Across;           // an axis
  double OfAcross, Ahead, Behind; // normal along it and the next two
};

// The context of a vertex's k-th difference.
inline std::size_t PositionContext(const PositionMode& mode, bool guided, std::size_t k)
{
  constexpr std::size_t contextOf[3][3] = { { 0, 0, 0 }, { 0, 1, 2 }, { 0, 0, 1 } };
  return guided ? contexts::position + contextOf[static_cast<std::size_t>(mode.tables)][k]
                : contexts::unguidedPosition;
}

}
