// SPDX-License-Identifier: BSD-3-Clause
// Predicts where a piece's vertices are, one after the other in the order of the walk: where
// parallelograms of earlier vertices put them. What is coded is the difference to that
// (PositionReader.h, PositionWriter.h). Layout: doc/formats.md, "Positions".
//
// A coordinate on the grid is an integer, 0 … 2^bits - 1, and is predicted in integers. A lossless
// one is predicted in doubles, by a few operations that give the same bits everywhere; what is
// coded then is the difference between the ordered bits of the coordinate and of the prediction.
#pragma once

#include "filters/codec/ByteStream.h"
#include "filters/codec/CoordinateGrid.h"
#include "filters/codec/PieceContexts.h"
#include "filters/codec/TriangleWalk.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>

namespace kdstream
{

// How a piece's positions are coded; chosen by the writer.
struct PositionMode
{
  // How far beyond an edge the prediction lies, in eighths of how far the apex lies before the
  // edge: 8 completes the parallelogram, less suits noisy surfaces.
  unsigned reach = 8;
  bool tableAnAxis = false; // each axis has a context of its own
};
inline constexpr unsigned mostReach = 8;

// Coordinates on the grid, which are below 2^24; half-way is rounded up. Works on all axes at once
// and modulo 2^32. A reader must Check every point: what it reads may be outside.
class GridPredictor
{
public:
  using Point = std::uint32_t __attribute__((vector_size(16))); // x, y, z, and one that is unused
  using Differences = Point;
  static constexpr unsigned differenceBits = 26; // a difference as an unsigned number (Zigzag)

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
  // Ascends with (x, y, z), as far as 64 bits tell points apart.
  static std::uint64_t SortKeyOf(const Point& point)
  {
    return std::uint64_t{ point[0] } << 40 | std::uint64_t{ point[1] } << 16 | point[2] >> 8;
  }

  // edges: the sum of the four vertices on the edges of two parallelograms; apexes: of the two
  // behind.
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
  // Notes in `outside` whether the point is outside the grid. Check all points, with one `outside`
  // that is zero at first, then ask IsAny.
  KDSTREAM_IN_LOOPS void Check(const Point& point, Point& outside) const
  {
    outside |= Point(point > this->Most);
  }
  static bool IsAny(const Point& outside) { return (outside[0] | outside[1] | outside[2]) != 0; }

private:
  Point Most, EdgeWeight, ApexWeight;
};

// The same for exact coordinates; outside are those that are not finite.
class ExactPredictor
{
public:
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
  // Modulo the width of the type.
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

// Where a guided vertex should be. REQUIRES: the points before it are set.
template <class Predictor>
KDSTREAM_IN_LOOPS typename Predictor::Point Predicted(
  const Predictor& predictor, const WalkVertex& vertex, const typename Predictor::Point* points)
{
  const auto& [a, b, c] = vertex.gate;
  const auto& [d, e, f] = vertex.second;
  return predictor.Predict(
    (points[a] + points[b]) + (points[d] + points[e]), points[c] + points[f]);
}

// The same for any vertex: without a parallelogram it should be where an earlier one is.
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

// The context of a vertex's differences along an axis.
inline std::size_t PositionContext(const PositionMode& mode, bool guided, std::size_t axis)
{
  return guided ? contexts::position + (mode.tableAnAxis ? axis : 0) : contexts::unguidedPosition;
}

}
