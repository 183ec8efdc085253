// SPDX-License-Identifier: BSD-3-Clause
// The median by counting (MedianSearch.h). Steps, for the range that contains the wanted key:
//   a. Divide the range into 2^16 bins of the ordered bits, or of the ids if all coordinates are
//      equal.
//   b. Count the keys in each bin in one pass.
//   c. Repeat with the bin that contains the wanted rank, until the bin's keys fit in memory.
// Each pass resolves 16 of 64 + 32 bits, for any distribution.
#include "filters/outofcore/tree/MedianSearch.h"

#include <algorithm>
#include <bit>
#include <vector>

namespace kdstream
{
namespace
{

constexpr unsigned mostBits = 16;

// The interval that is divided into bins: `low` to `high` of the coordinates, or of the ids at one
// coordinate.
struct Digits
{
  explicit Digits(const KeyRange& range, unsigned bits)
    : byId(range.first.coordinate == range.last.coordinate)
    , coordinate(range.first.coordinate)
    , low(this->byId ? range.first.id : range.first.coordinate)
    , high(this->byId ? range.last.id : range.last.coordinate)
  {
    const auto width = static_cast<unsigned>(std::bit_width(this->high - this->low));
    this->shift = width > bits ? width - bits : 0;
  }

  // Adds the keys in the range to the bins.
  void Count(std::span<const OrderKey> keys, std::vector<std::uint32_t>& bins) const
  {
    const std::uint64_t extent = this->high - this->low;
    for (const OrderKey& key : keys)
    {
      const std::uint64_t place = (this->byId ? key.id : key.coordinate) - this->low;
      if (place <= extent && (!this->byId || key.coordinate == this->coordinate))
      {
        ++bins[place >> this->shift];
      }
    }
  }

  // The keys of one bin. before: how many keys of the range lie below the bin; inside: how many lie
  // in it.
  KeyRange Narrowed(
    const KeyRange& range, std::uint64_t bin, std::uint64_t before, std::uint64_t inside) const
  {
    const std::uint64_t first = this->low + (bin << this->shift);
    const std::uint64_t last =
      std::min(this->high - first, (std::uint64_t{ 1 } << this->shift) - 1) + first;
    KeyRange narrow{ { first, 0 }, { last, greatestId }, range.below + before, inside };
    if (this->byId)
    {
      narrow.first = { this->coordinate, first };
      narrow.last = { this->coordinate, last };
    }
    return narrow;
  }

  bool byId;
  std::uint64_t coordinate;
  std::uint64_t low, high;
  unsigned shift = 0;
};

}

Result<KeyRange> FindMedianByHistogram(KeySource& keys, const MedianSearch& search, SpillFolder&)
{
  const std::uint64_t binsOfSlot =
    std::max<std::uint64_t>(16, search.memory / keys.Slots() / sizeof(std::uint32_t));
  const unsigned bits = std::min(mostBits, static_cast<unsigned>(std::bit_width(binsOfSlot)) - 1);
  std::vector<std::vector<std::uint32_t>> bins(keys.Slots());
  KeyRange range = search.known;
  while (range.inside > search.keepable && range.first != range.last)
  {
    const Digits digits(range, bits);
    for (std::vector<std::uint32_t>& some : bins)
    {
      some.assign(((digits.high - digits.low) >> digits.shift) + 1, 0);
    }
    KDSTREAM_TRY(keys.Pass(
      [&](std::size_t slot, std::span<OrderKey> block)
      {
        digits.Count(block, bins[slot]);
        return std::size_t{ 0 };
      },
      [](std::span<const OrderKey>) { return Status{}; }));
    std::uint64_t before = 0, inside = 0;
    std::size_t bin = 0;
    for (;; ++bin)
    {
      inside = 0;
      for (const std::vector<std::uint32_t>& some : bins)
      {
        inside += some[bin];
      }
      if (range.below + before + inside > search.rank)
      {
        break;
      }
      before += inside;
    }
    range = digits.Narrowed(range, bin, before, inside);
  }
  return range;
}

}
