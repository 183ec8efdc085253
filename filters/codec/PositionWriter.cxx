// SPDX-License-Identifier: BSD-3-Clause
#include "filters/codec/PositionWriter.h"

#include <algorithm>
#include <array>
#include <bit>

namespace kdstream
{
namespace
{

// About how many bits the differences take, in sixteenths of a bit: the raw ones, and the entropy
// of the symbols.
class CostOfTables
{
public:
  void Add(std::size_t axis, std::int64_t difference)
  {
    const auto size = static_cast<std::size_t>(std::bit_width(Zigzag(difference)));
    this->Raw += 16 * (size > 1 ? size - 1 : 0);
    ++this->Sizes[axis][size];
  }
  // All axes under one table.
  std::uint64_t Shared() const
  {
    std::array<std::uint64_t, 65> all{};
    for (std::size_t s = 0; s < all.size(); ++s)
    {
      all[s] = this->Sizes[0][s] + this->Sizes[1][s] + this->Sizes[2][s];
    }
    return this->Raw + Entropy(all);
  }
  // Each axis under a table of its own. every: one of so many differences was added.
  std::uint64_t Apart(std::uint64_t every) const
  {
    const std::uint64_t twoTables = 16 * 2 * 80 / every;
    return this->Raw + Entropy(this->Sizes[0]) + Entropy(this->Sizes[1]) + Entropy(this->Sizes[2]) +
           twoTables;
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

// Tries each reach on some of the vertices and takes the cheapest mode.
template <class Predictor>
PositionMode ChoosePositionMode(const CoordinateGrid& grid, std::span<const WalkVertex> vertices,
  const typename Predictor::Point* points)
{
  constexpr unsigned reaches[] = { 8, 6, 4 };
  constexpr std::size_t enough = 512; // vertices to look at, evenly spread
  const std::size_t every = vertices.size() / enough + 1;
  PositionMode best;
  std::uint64_t least = ~std::uint64_t{ 0 };
  for (const unsigned reach : reaches)
  {
    const Predictor predictor(grid, reach);
    CostOfTables cost;
    for (std::size_t v = 0; v < vertices.size(); v += every)
    {
      if (vertices[v].guided != 0)
      {
        const auto predicted = Predicted(predictor, vertices, v, points);
        for (std::size_t k = 0; k < 3; ++k)
        {
          cost.Add(k, predictor.DifferenceOf(points[v], predicted, k));
        }
      }
    }
    const std::uint64_t shared = cost.Shared(), apart = cost.Apart(every);
    if (std::min(shared, apart) < least)
    {
      least = std::min(shared, apart);
      best = { reach, apart < shared };
    }
  }
  return best;
}

}

template <class Predictor>
void WritePositions(SymbolWriter& symbols, const CoordinateGrid& grid,
  std::span<const WalkVertex> vertices, const typename Predictor::Point* points)
{
  const PositionMode mode = ChoosePositionMode<Predictor>(grid, vertices, points);
  symbols.Number(contexts::single, mode.reach);
  symbols.Number(contexts::single, mode.tableAnAxis);
  const Predictor predictor(grid, mode.reach);
  for (std::size_t v = 0; v < vertices.size(); ++v)
  {
    const auto predicted = Predicted(predictor, vertices, v, points);
    for (std::size_t k = 0; k < 3; ++k)
    {
      symbols.Signed(PositionContext(mode, vertices[v].guided != 0, k),
        predictor.DifferenceOf(points[v], predicted, k));
    }
  }
}

template void WritePositions<GridPredictor>(
  SymbolWriter&, const CoordinateGrid&, std::span<const WalkVertex>, const GridPredictor::Point*);
template void WritePositions<ExactPredictor>(
  SymbolWriter&, const CoordinateGrid&, std::span<const WalkVertex>, const ExactPredictor::Point*);

}
