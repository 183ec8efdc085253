// SPDX-License-Identifier: BSD-3-Clause
// Finds the median of keys that do not fit in memory, by the total order (coordinate, id). All
// methods are exact and have one interface. Paper sections 4.2.2-4.2.3; the methods that the paper
// compares with are in filters/baselines/stores.
#pragma once

#include "filters/core/Result.h"
#include "filters/core/tree/OrderKey.h"
#include "filters/outofcore/files/SpillFile.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>

namespace kdstream
{

// The keys of one cell along one axis. A method may read them, from first to last, as often as it
// likes.
class KeySource
{
public:
  // Called for each block: at the same time for blocks of different slots, one after the other for
  // those of one slot. Moves the wanted keys to the front, and returns their number.
  using Filter = std::function<std::size_t(std::size_t slot, std::span<OrderKey> keys)>;
  // Called with the wanted keys of each block, in the order of the blocks, on the calling thread,
  // while no filter runs.
  using Take = std::function<Status(std::span<const OrderKey>)>;

  virtual ~KeySource() = default;
  virtual std::size_t Slots() const = 0;
  // Makes one pass. How blocks are given to slots does not depend on the number of threads.
  virtual Status Pass(const Filter& filter, const Take& take) = 0;
  // Counts a pass over the same keys that a method makes in its own files. Returns whether to
  // continue.
  virtual Status OwnPass() = 0;
  virtual Status GoOn() const = 0;
};

// A range in the order that contains the wanted key: [first, last], both included.
struct KeyRange
{
  OrderKey first, last;
  std::uint64_t below = 0;  // keys of the cell before `first`
  std::uint64_t inside = 0; // keys of the cell in the range
};

struct MedianSearch
{
  std::uint64_t rank = 0;     // of the wanted key; 0: the smallest key
  KeyRange known;             // the range that contains the median
  double mean = 0;            // of the coordinates of all keys: the first pivot of Heaps
  std::uint64_t keepable = 1; // a range with at most this number of keys is narrow enough
  std::uint64_t memory = 0;   // bytes that a method may take besides the blocks of a pass
  double heapShare = 0; // the number of keys in both heaps as a share of all keys; 0 = as many as
                        // fit in memory
};

// A method. It finds a range of at most `keepable` keys that contains the key of the wanted rank,
// or exactly that key. Errors: those of the source and of spill files in `folder`.
using MedianMethod = Result<KeyRange> (*)(
  KeySource& keys, const MedianSearch& search, SpillFolder& folder);

// Paper 4.2.2-4.2.3: the mean as pivot, and the keys nearest to it in two heaps. Finds exactly the
// wanted key. Number of passes over n keys, with h keys in both heaps: 1 if the wanted key is among
// the h / 2 nearest on its side of the mean, n / (h / 2) at worst.
Result<KeyRange> FindMedianByHeaps(KeySource& keys, const MedianSearch& search, SpillFolder&);

// Counts keys in bins of the ordered bits: at most (64 + 32) / 16 passes for any distribution; the
// bins are as fine as the memory allows. The fastest method in our measurements
// (Testing/Benchmarks, table3).
Result<KeyRange> FindMedianByHistogram(KeySource& keys, const MedianSearch& search, SpillFolder&);

}
