#include "filters/codec/PositionStream.h"

#include <bit>

namespace kdstream
{
namespace
{

// Bits of the differences by table, in sixteenths of a bit: what is raw, and the symbols' entropy.
class CostOfTables
{
public:
  void Add(std::size_t axis, std::int64_t difference)
  {
    const auto bits = static_cast<std::uint64_t>(difference);
    const std::uint64_t value = (bits << 1) ^ (std::uint64_t{ 0 } - (bits >> 63));
    const auto size = static_cast<std::size_t>(std::bit_width(value));
    this->Raw += 16 * (size > 1 ? size - 1 : 0);
    ++this->Sizes[axis][size];
  }
  std::uint64_t Shared() const
  {
    std::array<std::uint64_t, 65> all{};
    for (std::size_t s = 0; s < all.size(); ++s)
    {
      all[s] = this->Sizes[0][s] + this->Sizes[1][s] + this->Sizes[2][s];
    }
    return this->Raw + Entropy(all);
  }
  // every: of so many differences one was added.
  std::uint64_t Apart(std::uint64_t every) const
  {
    const std::uint64_t twoTables = 16 * 2 * 80 / every;
    return this->Raw + Entropy(this->Sizes[0]) + Entropy(this->Sizes[1]) + Entropy(this->Sizes[2]) +
           twoTables;
  }

private:
  // Sixteenths of log2, linear between powers of two: no two machines must differ.
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

}

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
        const auto foretold = Foretold(predictor, vertices, v, points);
        for (std::size_t k = 0; k < 3; ++k)
        {
          cost.Add(k, predictor.DifferenceOf(points[v], foretold, k));
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

template PositionMode ChoosePositionMode<GridPredictor>(
  const CoordinateGrid&, std::span<const WalkVertex>, const GridPredictor::Point*);
template PositionMode ChoosePositionMode<ExactPredictor>(
  const CoordinateGrid&, std::span<const WalkVertex>, const ExactPredictor::Point*);

}
