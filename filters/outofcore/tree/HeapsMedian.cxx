// SPDX-License-Identifier: BSD-3-Clause
// The median by selective sorting with two heaps (MedianSearch.h; paper 4.2.2-4.2.3). Steps:
//   1. Classify: keys up to the mean go left, later keys go right. The greatest keys on the left
//      stay in memory in a min heap, the least on the right in a max heap.
//   2. Find the interval: the counts tell on which side the wanted rank is, and how far it is from
//      the mean.
//   3. If this distance is less than the heap's size, the key is in the heap. Otherwise repeat for
//      the keys of that side that were not in the heap, with their own mean.
// The paper writes keys that leave the heaps to a left and a right file. Here the next pass reads
// the cell again and skips the other keys; the halves are written once, when the median is known.
// If all remaining coordinates are equal, the pivot is the mean of the ids.
#include "filters/outofcore/tree/MedianSearch.h"

#include <algorithm>
#include <vector>

namespace kdstream
{
namespace
{

struct Side
{
  std::uint64_t count = 0;
  double coordinates = 0, ids = 0; // sums, used only to choose pivots

  void Add(const OrderKey& key, double sign = 1)
  {
    this->coordinates += sign * ValueOfOrderedBits(key.coordinate);
    this->ids += sign * double(key.id);
  }
};

struct Sides
{
  Side left, right;
};

struct Greater
{
  bool operator()(const OrderKey& a, const OrderKey& b) const { return b < a; }
};

// The `most` greatest (or least) keys by the order `Compare`, the one nearest to leaving on top.
template <class Compare>
class BoundedHeap
{
public:
  explicit BoundedHeap(std::size_t most)
    : Most(most)
  {
    this->keys.reserve(most);
  }

  bool Wants(const OrderKey& key) const
  {
    return this->keys.size() < this->Most || Compare()(key, this->keys.front());
  }
  // REQUIRES: Wants(key).
  void Put(const OrderKey& key)
  {
    if (this->keys.size() == this->Most)
    {
      std::pop_heap(this->keys.begin(), this->keys.end(), Compare());
      this->keys.back() = key;
    }
    else
    {
      this->keys.push_back(key);
    }
    std::push_heap(this->keys.begin(), this->keys.end(), Compare());
  }

  std::vector<OrderKey> keys;

private:
  std::size_t Most;
};

// The min heap keeps the greatest keys, the max heap the least.
using MinHeap = BoundedHeap<Greater>;
using MaxHeap = BoundedHeap<std::less<OrderKey>>;

OrderKey Before(const OrderKey& key)
{
  return key.id > 0 ? OrderKey{ key.coordinate, key.id - 1 }
                    : OrderKey{ key.coordinate - 1, greatestId };
}

OrderKey Behind(const OrderKey& key)
{
  return key.id < greatestId ? OrderKey{ key.coordinate, key.id + 1 }
                             : OrderKey{ key.coordinate + 1, 0 };
}

// The mean of the remaining keys, as a key in the range.
OrderKey PivotOf(const KeyRange& range, double coordinates, double ids)
{
  const auto count = double(range.inside);
  if (range.first.coordinate == range.last.coordinate)
  {
    const double id = std::clamp(ids / count, double(range.first.id), double(range.last.id));
    return { range.first.coordinate, static_cast<std::uint64_t>(id) };
  }
  const double mean = std::clamp(coordinates / count, ValueOfOrderedBits(range.first.coordinate),
    ValueOfOrderedBits(range.last.coordinate));
  return { OrderedBits(mean), greatestId };
}

// Steps 1 and 2: fills the heaps, and counts the keys on both sides.
Status Classify(KeySource& keys, const KeyRange& range, const OrderKey& pivot, MinHeap& minHeap,
  MaxHeap& maxHeap, Sides& sides)
{
  std::vector<Sides> ofSlot(keys.Slots());
  KDSTREAM_TRY(keys.Pass(
    [&](std::size_t slot, std::span<OrderKey> block)
    {
      Sides counted = ofSlot[slot];
      std::size_t wanted = 0;
      for (const OrderKey key : block)
      {
        if (key < range.first || range.last < key)
        {
          continue;
        }
        const bool isLeft = key <= pivot;
        Side& side = isLeft ? counted.left : counted.right;
        ++side.count;
        side.Add(key);
        block[wanted] = key;
        wanted += (isLeft ? minHeap.Wants(key) : maxHeap.Wants(key)) ? 1 : 0;
      }
      ofSlot[slot] = counted;
      return wanted;
    },
    [&](std::span<const OrderKey> block)
    {
      for (const OrderKey& key : block)
      {
        if (key <= pivot)
        {
          if (minHeap.Wants(key))
          {
            minHeap.Put(key);
          }
        }
        else if (maxHeap.Wants(key))
        {
          maxHeap.Put(key);
        }
      }
      return Status{};
    }));
  for (const Sides& counted : ofSlot)
  {
    for (const auto side : { &Sides::left, &Sides::right })
    {
      (sides.*side).count += (counted.*side).count;
      (sides.*side).coordinates += (counted.*side).coordinates;
      (sides.*side).ids += (counted.*side).ids;
    }
  }
  return {};
}

// The sums and count of a side without the keys of its heap.
Side Without(Side side, const std::vector<OrderKey>& heap)
{
  for (const OrderKey& key : heap)
  {
    side.Add(key, -1);
  }
  side.count -= heap.size();
  return side;
}

}

Result<KeyRange> FindMedianByHeaps(KeySource& keys, const MedianSearch& search, SpillFolder&)
{
  std::uint64_t inHeaps = search.memory / sizeof(OrderKey);
  if (search.heapShare > 0)
  {
    inHeaps =
      std::min(inHeaps, static_cast<std::uint64_t>(search.heapShare * double(search.known.inside)));
  }
  const auto most =
    static_cast<std::size_t>(std::clamp<std::uint64_t>(inHeaps / 2, 1, search.known.inside));
  KeyRange range = search.known;
  OrderKey pivot = PivotOf(range, search.mean * double(range.inside), 0);
  if (range.first.coordinate == range.last.coordinate)
  {
    pivot.id = range.first.id + (range.last.id - range.first.id) / 2;
  }
  for (;;)
  {
    MinHeap minHeap(most);
    MaxHeap maxHeap(most);
    Sides sides;
    KDSTREAM_TRY(Classify(keys, range, pivot, minHeap, maxHeap, sides));
    const std::uint64_t rank = search.rank - range.below;
    const bool isLeft = rank < sides.left.count;
    // How many keys lie between the wanted one and the pivot.
    const std::uint64_t interval = isLeft ? sides.left.count - 1 - rank : rank - sides.left.count;
    std::vector<OrderKey>& heap = isLeft ? minHeap.keys : maxHeap.keys;
    if (interval < heap.size())
    {
      const auto nth = heap.begin() + std::ptrdiff_t(interval);
      isLeft ? std::nth_element(heap.begin(), nth, heap.end(), Greater())
             : std::nth_element(heap.begin(), nth, heap.end());
      return KeyRange{ *nth, *nth, search.rank, 1 };
    }
    const Side rest = Without(isLeft ? sides.left : sides.right, heap);
    if (isLeft)
    {
      range.last = Before(heap.front());
    }
    else
    {
      range.first = Behind(heap.front());
      range.below += sides.left.count + heap.size();
    }
    range.inside = rest.count;
    pivot = PivotOf(range, rest.coordinates, rest.ids);
  }
}

}
