// Positions of a piece's vertices in the order of the walk: differences to where parallelograms of
// earlier vertices say that they should be. Layout: doc/formats.md, "Positions".
//
// A coordinate is a number of the grid, 0 … 2^bits - 1, foretold in integers; or in lossless the
// exact one, foretold in doubles, whose few operations give the same bits everywhere: differences
// are then those of the ordered bits of the coordinate and of what was foretold.
#pragma once

#include "filters/codec/ByteStream.h"
#include "filters/codec/CoordinateGrid.h"
#include "filters/codec/PieceContexts.h"
#include "filters/codec/TriangleWalk.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <span>
#include <type_traits>

namespace kdstream
{

// How a piece's positions are coded; chosen by the writer.
struct PositionMode
{
  // Eighths by which a vertex lies as far beyond the edge as the one behind it: 8 is the
  // parallelogram, less suits noisy surfaces.
  unsigned reach = 8;
  bool tableAnAxis = false;
};
inline constexpr unsigned mostReach = 8;

// A number n as the signed one that it stands for, and back: small ones of either sign are small.
constexpr std::int64_t SignedOf(std::uint64_t number)
{
  return static_cast<std::int64_t>((number >> 1) ^ (std::uint64_t{ 0 } - (number & 1)));
}

// Foretells grid coordinates, which are below 2^24; half-way is up. Works on all axes at once, and
// modulo 2^32: where what is read is no coordinates, it is refused once all is.
class GridPredictor
{
public:
  using Point = std::uint32_t __attribute__((vector_size(16))); // x, y, z, and one that is unused
  using Differences = Point;
  static constexpr unsigned differenceBits = 26; // of a difference, as a number

  GridPredictor(const CoordinateGrid& grid, unsigned reach)
    : Most(Point{} + ((1U << grid.bits) - 1))
    , EdgeWeight(Point{} + (8 + reach))
    , ApexWeight(Point{} + 2 * reach)
  {
  }

  // Of sums over two parallelograms: of the vertices on their edges, and of those behind.
  KDSTREAM_IN_LOOPS Point Foretell(const Point& edges, const Point& apexes) const
  {
    using Signed = std::int32_t __attribute__((vector_size(16)));
    const auto sum = Signed(this->EdgeWeight * edges - this->ApexWeight * apexes + 16);
    const Point steps = Point(sum & (sum > 0)) >> 5;
    const auto isLess = Point(steps < this->Most);
    return (steps & isLess) | (this->Most & ~isLess);
  }
  std::int64_t DifferenceOf(const Point& point, const Point& foretold, std::size_t axis) const
  {
    return std::int64_t{ point[axis] } - std::int64_t{ foretold[axis] };
  }
  KDSTREAM_IN_LOOPS Point At(const Point& foretold, const Differences& differences) const
  {
    return foretold + differences;
  }
  // Any bit that is set: a point that was put in is none. REQUIRES: `outside` is zero at first.
  KDSTREAM_IN_LOOPS void Check(const Point& point, Point& outside) const
  {
    outside |= Point(point > this->Most);
  }
  static bool IsAny(const Point& outside) { return (outside[0] | outside[1] | outside[2]) != 0; }

private:
  Point Most, EdgeWeight, ApexWeight;
};

// The same for exact coordinates.
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

  Point Foretell(const Point& edges, const Point& apexes) const
  {
    const double most = this->IsFloat ? double(std::numeric_limits<float>::max())
                                      : std::numeric_limits<double>::max();
    Point foretold;
    for (std::size_t k = 0; k < 3; ++k)
    {
      const double value =
        (this->EdgeWeight * edges[k] - this->ApexWeight * apexes[k]) * (1.0 / 32);
      foretold[k] = std::abs(value) <= most ? (this->IsFloat ? double(float(value)) : value) : 0;
    }
    return foretold;
  }
  std::int64_t DifferenceOf(const Point& point, const Point& foretold, std::size_t axis) const
  {
    if (this->IsFloat)
    {
      return static_cast<std::int32_t>(OrderedBits(static_cast<float>(point[axis])) -
                                       OrderedBits(static_cast<float>(foretold[axis])));
    }
    return static_cast<std::int64_t>(OrderedBits(point[axis]) - OrderedBits(foretold[axis]));
  }
  // Modulo the width of the type.
  Point At(const Point& foretold, const Differences& differences) const
  {
    Point point;
    for (std::size_t k = 0; k < 3; ++k)
    {
      point[k] = this->IsFloat ? FloatOfOrderedBits(OrderedBits(static_cast<float>(foretold[k])) +
                                                    static_cast<std::uint32_t>(differences[k]))
                               : DoubleOfOrderedBits(OrderedBits(foretold[k]) +
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

// Where `vertex` should be. REQUIRES: it is guided, those before it are known.
template <class Predictor>
KDSTREAM_IN_LOOPS typename Predictor::Point Foretold(
  const Predictor& predictor, const WalkVertex& vertex, const typename Predictor::Point* known)
{
  const auto& [a, b, c] = vertex.gate;
  const auto& [d, e, f] = vertex.second;
  return predictor.Foretell((known[a] + known[b]) + (known[d] + known[e]), known[c] + known[f]);
}

// The same of any vertex.
template <class Predictor>
KDSTREAM_IN_LOOPS typename Predictor::Point Foretold(const Predictor& predictor,
  std::span<const WalkVertex> vertices, std::size_t v, const typename Predictor::Point* known)
{
  if (vertices[v].guided != 0)
  {
    return Foretold(predictor, vertices[v], known);
  }
  return v > 0 ? known[vertices[v].gate[0]] : typename Predictor::Point{};
}

// Chooses the mode by trial on some of the vertices: sums of the sizes of differences.
// Deterministic.
template <class Predictor>
PositionMode ChoosePositionMode(const CoordinateGrid& grid, std::span<const WalkVertex> vertices,
  const typename Predictor::Point* points);

// False where what is read is none.
template <class Coder>
bool CodePositionMode(Coder& coder, PositionMode& mode)
{
  mode.reach = static_cast<unsigned>(coder.Number(contexts::single, mode.reach));
  mode.tableAnAxis = coder.Number(contexts::single, mode.tableAnAxis) != 0;
  return mode.reach <= mostReach;
}

// The context of a vertex's differences along an axis.
inline std::size_t PositionContext(const PositionMode& mode, bool guided, std::size_t axis)
{
  return guided ? contexts::position + (mode.tableAnAxis ? axis : 0) : contexts::unguidedPosition;
}

template <class Predictor>
void WritePositions(SymbolWriter& coder, const CoordinateGrid& grid,
  std::span<const WalkVertex> vertices, const typename Predictor::Point* points)
{
  PositionMode mode = ChoosePositionMode<Predictor>(grid, vertices, points);
  (void)CodePositionMode(coder, mode);
  const Predictor predictor(grid, mode.reach);
  for (std::size_t v = 0; v < vertices.size(); ++v)
  {
    const auto foretold = Foretold(predictor, vertices, v, points);
    for (std::size_t k = 0; k < 3; ++k)
    {
      coder.Signed(PositionContext(mode, vertices[v].guided != 0, k),
        predictor.DifferenceOf(points[v], foretold, k));
    }
  }
}

// All differences, three a vertex, before any position is foretold: the symbols of one do not wait
// for the other then. False where one has too many bits.
template <class Predictor>
bool ReadDifferences(SymbolReader& coder, const PositionMode& mode,
  std::span<const WalkVertex> vertices, typename Predictor::Differences* differences)
{
  std::array<const std::uint32_t*, 6> tables; // of a vertex without and with a parallelogram
  for (std::size_t i = 0; i < tables.size(); ++i)
  {
    tables[i] = coder.TableFor(PositionContext(mode, i > 2, i % 3));
  }
  SymbolCursor cursor = coder;
  std::uint64_t numbers = 0;
  for (const WalkVertex& vertex : vertices)
  {
    typename Predictor::Differences difference{};
    const std::uint32_t* const* table = tables.data() + 3 * vertex.guided;
    for (std::size_t k = 0; k < 3; ++k)
    {
      const std::uint64_t number =
        Predictor::differenceBits > 48 ? cursor.NumberUnder(table[k]) : cursor.SmallUnder(table[k]);
      numbers |= number;
      difference[k] =
        static_cast<std::remove_reference_t<decltype(difference[k])>>(SignedOf(number));
    }
    *differences++ = difference;
  }
  coder.Continue(cursor);
  return Predictor::differenceBits == 64 || numbers >> (Predictor::differenceBits % 64) == 0;
}

}
