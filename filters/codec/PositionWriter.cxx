// SPDX-License-Identifier: BSD-3-Clause
#include "filters/codec/PieceWriter.h"

#include <algorithm>
#include <array>
#include <bit>

namespace kdstream
{
namespace
{

// Estimates the number of bits that differences take, in sixteenths of a bit: their raw bits, and
// the entropy of their symbols.
class CostOfTables
{
public:
  // table: 0, 1 or 2.
  void Add(std::size_t table, std::int64_t difference)
  {
    const auto size = static_cast<std::size_t>(std::bit_width(Zigzag(difference)));
    this->Raw += 16 * (size > 1 ? size - 1 : 0);
    ++this->Sizes[table][size];
  }
  // The cost with one table for all axes.
  std::uint64_t Shared() const
  {
    std::array<std::uint64_t, 65> all{};
    for (std::size_t s = 0; s < all.size(); ++s)
    {
      all[s] = this->Sizes[0][s] + this->Sizes[1][s] + this->Sizes[2][s];
    }
    return this->Raw + Entropy(all);
  }
  // The cost with a table of its own for each. more: the number of tables beyond one. every: only
  // one in this number of differences was added.
  std::uint64_t Apart(std::uint64_t every, std::uint64_t more) const
  {
    return this->Raw + Entropy(this->Sizes[0]) + Entropy(this->Sizes[1]) + Entropy(this->Sizes[2]) +
           16 * more * 80 / every;
  }

private:
  // log2 in sixteenths, linear between powers of two: in integers, so that all machines agree.
  static std::uint64_t Log(std::uint64_t value)
  {
    const unsigned low = static_cast<unsigned>(std::bit_width(value)) - 1;
    return 16 * low + ((value << 4 >> low) & 15);
  }
  static std::uint64_t Entropy(const std::array<std::uint64_t, 65>& counts)
  {
    std::uint64_t sum = 0, bits = 0;
    for (const std::uint64_t count : counts)
    {
      sum += count;
    }
    for (const std::uint64_t count : counts)
    {
      bits += count == 0 ? 0 : count * (Log(sum) - Log(count));
    }
    return bits;
  }

  std::array<std::array<std::uint64_t, 65>, 3> Sizes{};
  std::uint64_t Raw = 0;
};

// The differences that are stored for a vertex: from the prediction, or with the plane
// (SurfacePlane).
template <class Predictor>
std::array<std::int64_t, 3> Differences(const Predictor& predictor, AxisTables tables,
  std::span<const WalkVertex> vertices, std::size_t v, const typename Predictor::Point* points)
{
  const auto predicted = Predicted(predictor, vertices, v, points);
  if constexpr (Predictor::hasPlanes)
  {
    if (tables == AxisTables::Plane && vertices[v].guided != 0)
    {
      const auto coded = SurfacePlane(vertices[v], points).Coded(points[v] - predicted);
      const auto at = [&](std::size_t k)
      { return std::int64_t{ static_cast<std::int32_t>(coded[k]) }; };
      return { at(0), at(1), at(2) };
    }
  }
  return { predictor.DifferenceOf(points[v], predicted, 0),
    predictor.DifferenceOf(points[v], predicted, 1),
    predictor.DifferenceOf(points[v], predicted, 2) };
}

// Tries each reach on some of the vertices, and returns the cheapest mode.
template <class Predictor>
PositionMode ChoosePositionMode(const CoordinateGrid& grid, std::span<const WalkVertex> vertices,
  const typename Predictor::Point* points, bool planes)
{
  constexpr unsigned reaches[] = { 8, 6, 4 };
  constexpr std::size_t enough = 512; // vertices to try, evenly spread
  const std::size_t every = vertices.size() / enough + 1;
  PositionMode best;
  std::uint64_t least = ~std::uint64_t{ 0 };
  const auto consider = [&](unsigned reach, AxisTables tables, std::uint64_t cost)
  {
    if (cost < least)
    {
      least = cost;
      best = { reach, tables };
    }
  };
  for (const unsigned reach : reaches)
  {
    const Predictor predictor(grid, reach);
    CostOfTables ofAxes, ofPlanes;
    for (std::size_t v = 0; v < vertices.size(); v += every)
    {
      if (vertices[v].guided == 0)
      {
        continue;
      }
      const auto along = Differences(predictor, AxisTables::Each, vertices, v, points);
      const auto off = planes ? Differences(predictor, AxisTables::Plane, vertices, v, points)
                              : std::array<std::int64_t, 3>{};
      for (std::size_t k = 0; k < 3; ++k)
      {
        ofAxes.Add(k, along[k]);
        ofPlanes.Add(k / 2, off[k]);
      }
    }
    consider(reach, AxisTables::Shared, ofAxes.Shared());
    consider(reach, AxisTables::Each, ofAxes.Apart(every, 2));
    if (planes)
    {
      consider(reach, AxisTables::Plane, ofPlanes.Apart(every, 1));
    }
  }
  return best;
}

}

template <class Predictor>
void WritePositions(SymbolWriter& symbols, const CoordinateGrid& grid,
  std::span<const WalkVertex> vertices, const typename Predictor::Point* points, bool mayUsePlanes)
{
  const bool planes = mayUsePlanes && Predictor::hasPlanes;
  const PositionMode mode = ChoosePositionMode<Predictor>(grid, vertices, points, planes);
  symbols.Number(contexts::single, mode.reach);
  symbols.Number(contexts::single, static_cast<std::uint64_t>(mode.tables));
  const Predictor predictor(grid, mode.reach);
  for (std::size_t v = 0; v < vertices.size(); ++v)
  {
    const auto differences = Differences(predictor, mode.tables, vertices, v, points);
    for (std::size_t k = 0; k < 3; ++k)
    {
      symbols.Signed(PositionContext(mode, vertices[v].guided != 0, k), differences[k]);
    }
  }
}

template void WritePositions<GridPredictor>(SymbolWriter&, const CoordinateGrid&,
  std::span<const WalkVertex>, const GridPredictor::Point*, bool);
template void WritePositions<ExactPredictor>(SymbolWriter&, const CoordinateGrid&,
  std::span<const WalkVertex>, const ExactPredictor::Point*, bool);

}
