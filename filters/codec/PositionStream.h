// Positions of a piece's vertices in the order of the walk: differences to where parallelograms of
// earlier vertices say that they should be. Layout: doc/formats.md, "Positions".
//
// A coordinate is a number: of the grid, 0 … 2^bits - 1, or in lossless the exact one. Foretelling
// is done in doubles, whose few operations give the same bits everywhere; lossless differences are
// those of the ordered bits of the coordinate and of what was foretold.
#pragma once

#include "filters/codec/ByteStream.h"
#include "filters/codec/CoordinateGrid.h"
#include "filters/codec/PieceContexts.h"
#include "filters/codec/TriangleWalk.h"

#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

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

class PositionPredictor
{
public:
  PositionPredictor(const CoordinateGrid& grid, unsigned reach)
    : Grid(grid)
    , Most(grid.Lossless() ? 0 : double((std::uint64_t{ 1 } << grid.bits) - 1))
    , EdgeWeight(8 + reach)
    , ApexWeight(2 * reach)
  {
  }

  // What `vertex`, the `number`th of the walk, should be. REQUIRES: those before it are known.
  Vec3 Foretell(const WalkVertex& vertex, std::size_t number, std::span<const Vec3> known) const
  {
    Vec3 foretold{};
    if (vertex.parallelogramCount == 0)
    {
      return number == 0 ? foretold : known[vertex.gate[0]];
    }
    constexpr double shares[] = { 0, 1.0 / 16, 1.0 / 32, 1.0 / 48 };
    for (std::size_t i = 0; i < vertex.parallelogramCount; ++i)
    {
      const auto& [a, b, c] = vertex.parallelograms[i];
      for (std::size_t k = 0; k < 3; ++k)
      {
        foretold[k] +=
          this->EdgeWeight * (known[a][k] + known[b][k]) - this->ApexWeight * known[c][k];
      }
    }
    for (double& value : foretold)
    {
      value = this->Near(value * shares[vertex.parallelogramCount]);
    }
    return foretold;
  }

  std::int64_t Difference(double value, double foretold) const
  {
    if (!this->Grid.Lossless())
    {
      return static_cast<std::int64_t>(value - foretold);
    }
    if (this->Grid.scalarType == ScalarType::Float32)
    {
      return static_cast<std::int32_t>(
        OrderedBits(static_cast<float>(value)) - OrderedBits(static_cast<float>(foretold)));
    }
    return static_cast<std::int64_t>(OrderedBits(value) - OrderedBits(foretold));
  }

  // The coordinate that lies so far from what was foretold; NaN if there is none.
  double Value(double foretold, std::int64_t difference) const
  {
    if (!this->Grid.Lossless())
    {
      const double value = foretold + double(difference);
      return value >= 0 && value <= this->Most ? value : std::numeric_limits<double>::quiet_NaN();
    }
    if (this->Grid.scalarType == ScalarType::Float32)
    {
      return FloatOfOrderedBits(
        OrderedBits(static_cast<float>(foretold)) + static_cast<std::uint32_t>(difference));
    }
    return DoubleOfOrderedBits(OrderedBits(foretold) + static_cast<std::uint64_t>(difference));
  }

private:
  // A coordinate that may be, near `value`.
  double Near(double value) const
  {
    if (!this->Grid.Lossless())
    {
      // Beyond 0 cutting off is rounding down, and it needs no library.
      const double rounded = value > 0 ? double(static_cast<std::int32_t>(value + 0.5)) : 0;
      return std::min(rounded, this->Most);
    }
    if (this->Grid.scalarType == ScalarType::Float64)
    {
      return std::abs(value) <= std::numeric_limits<double>::max() ? value : 0;
    }
    return std::abs(value) <= std::numeric_limits<float>::max() ? double(float(value)) : 0;
  }

  const CoordinateGrid& Grid;
  double Most;
  double EdgeWeight, ApexWeight;
};

// Chooses the mode by trial: sums of the sizes of differences. Deterministic, O(vertices).
PositionMode ChoosePositionMode(const CoordinateGrid& grid, std::span<const WalkVertex> vertices,
  std::span<const Vec3> positions);

// positions: in the order of the walk; a reader fills them. False where what is read is none.
template <class Coder>
bool CodePositions(Coder& coder, const CoordinateGrid& grid, std::span<const WalkVertex> vertices,
  std::span<Vec3> positions)
{
  PositionMode mode;
  if constexpr (!Coder::reading)
  {
    mode = ChoosePositionMode(grid, vertices, positions);
  }
  mode.reach = static_cast<unsigned>(coder.Number(contexts::single, mode.reach));
  mode.tableAnAxis = coder.Number(contexts::single, mode.tableAnAxis) != 0;
  if (mode.reach > mostReach)
  {
    return false;
  }
  const PositionPredictor predictor(grid, mode.reach);
  for (std::size_t v = 0; v < vertices.size(); ++v)
  {
    const Vec3 foretold = predictor.Foretell(vertices[v], v, positions);
    const bool guided = vertices[v].parallelogramCount > 0;
    for (std::size_t k = 0; k < 3; ++k)
    {
      const std::size_t context =
        guided ? contexts::position + (mode.tableAnAxis ? k : 0) : contexts::unguidedPosition;
      if constexpr (Coder::reading)
      {
        const double value = predictor.Value(foretold[k], coder.Signed(context));
        if (!(std::abs(value) <= std::numeric_limits<double>::max()))
        {
          return false;
        }
        positions[v][k] = value;
      }
      else
      {
        coder.Signed(context, predictor.Difference(positions[v][k], foretold[k]));
      }
    }
  }
  return true;
}

}
