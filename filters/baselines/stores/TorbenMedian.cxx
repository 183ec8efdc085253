// SPDX-License-Identifier: BSD-3-Clause
// The median by Torben's method (Baselines.h; paper 4.2.1), on the total order. Steps:
//   a. Put the pivot halfway between the smallest and the largest candidate: of their coordinates,
//      or of their ids if the coordinates are equal.
//   b. In one pass count the keys up to the pivot, and find the largest of them and the smallest
//      key after it.
//   c. If neither of these two is the wanted key, repeat for the part that contains it.
#include "filters/baselines/stores/Baselines.h"

#include <algorithm>
#include <vector>

namespace kdstream
{
namespace
{

struct Counted
{
  std::uint64_t upToPivot = 0;
  OrderKey greatestUpTo{ 0, 0 };
  OrderKey leastBehind{ ~std::uint64_t{ 0 }, greatestId };

  void Add(const Counted& other)
  {
    this->upToPivot += other.upToPivot;
    this->greatestUpTo = std::max(this->greatestUpTo, other.greatestUpTo);
    this->leastBehind = std::min(this->leastBehind, other.leastBehind);
  }
};

OrderKey HalfWay(const OrderKey& first, const OrderKey& last)
{
  if (first.coordinate == last.coordinate)
  {
    return { first.coordinate, first.id + (last.id - first.id) / 2 };
  }
  const double half =
    ValueOfOrderedBits(first.coordinate) / 2 + ValueOfOrderedBits(last.coordinate) / 2;
  // The mean of two neighbouring doubles is one of them. Take the lower one; otherwise no key would
  // come after it.
  return { std::clamp(OrderedBits(half), first.coordinate, last.coordinate - 1), greatestId };
}

}

Result<KeyRange> FindMedianByTorben(KeySource& keys, const MedianSearch& search, SpillFolder&)
{
  KeyRange range = search.known;
  std::vector<Counted> ofSlot(keys.Slots());
  while (range.first != range.last)
  {
    const OrderKey pivot = HalfWay(range.first, range.last);
    std::fill(ofSlot.begin(), ofSlot.end(), Counted{});
    KDSTREAM_TRY(keys.Pass(
      [&](std::size_t slot, std::span<OrderKey> block)
      {
        Counted counted = ofSlot[slot];
        for (const OrderKey& key : block)
        {
          if (key < range.first || range.last < key)
          {
            continue;
          }
          const bool isUpTo = key <= pivot;
          counted.upToPivot += isUpTo ? 1 : 0;
          OrderKey& bound = isUpTo ? counted.greatestUpTo : counted.leastBehind;
          bound = isUpTo ? std::max(bound, key) : std::min(bound, key);
        }
        ofSlot[slot] = counted;
        return std::size_t{ 0 };
      },
      [](std::span<const OrderKey>) { return Status{}; }));
    Counted all;
    for (const Counted& counted : ofSlot)
    {
      all.Add(counted);
    }
    if (search.rank < range.below + all.upToPivot)
    {
      range.last = all.greatestUpTo;
      range.inside = all.upToPivot;
      if (search.rank + 1 == range.below + range.inside)
      {
        range.first = range.last;
      }
    }
    else
    {
      range.first = all.leastBehind;
      range.below += all.upToPivot;
      range.inside -= all.upToPivot;
      if (search.rank == range.below)
      {
        range.last = range.first;
      }
    }
  }
  return KeyRange{ range.first, range.last, search.rank, 1 };
}

}
