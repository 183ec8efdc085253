// SPDX-License-Identifier: BSD-3-Clause
// The median of what does not fit the memory, on the total order (coordinate, id): four exact
// methods behind one interface. Paper sections 4.2.1-4.2.3.
#pragma once

#include "filters/core/Result.h"
#include "filters/outofcore/files/SpillFile.h"
#include "filters/core/tree/OrderKey.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string_view>

namespace kdstream
{

enum class MedianMethod
{
  Automatic, // the fastest that was measured: Histogram (Testing/Benchmarks, table3)
  Heaps,     // 4.2.2-4.2.3: the mean as pivot, the keys nearest to it in two heaps
  Torben,    // 4.2.1, the paper's baseline: bisects between the least and the greatest
  Sort,      // external merge sort, the other baseline
  Histogram  // counts in bins of the ordered bits: a fixed number of passes for any distribution
};

// "auto", "heaps", "torben", "sort", "histogram".
std::string_view NameOfMedianMethod(MedianMethod method);
std::optional<MedianMethod> MedianMethodOfName(std::string_view name);

// The keys of one cell along one axis, read from the first to the last as often as a method likes.
class KeySource
{
public:
  // Called for each block, blocks of several slots at once, a slot's one after the other. Moves the
  // keys that it is interested in to the front, and returns their number.
  using Filter = std::function<std::size_t(std::size_t slot, std::span<OrderKey> keys)>;
  // Called with those of each block in the order of the blocks, from the calling thread, while no
  // filter runs.
  using Take = std::function<Status(std::span<const OrderKey>)>;

  virtual ~KeySource() = default;
  virtual std::size_t Slots() const = 0;
  // One pass. Blocks are given to slots by a rule that does not depend on the number of threads.
  virtual Status Pass(const Filter& filter, const Take& take) = 0;
  // Counts a pass over the same keys that a method makes in files of its own, and tells whether to
  // go on.
  virtual Status OwnPass() = 0;
  virtual Status GoOn() const = 0;
};

// A part of the order that holds the wanted key: [first, last], both included.
struct KeyRange
{
  OrderKey first, last;
  std::uint64_t below = 0;  // keys of the cell before `first`
  std::uint64_t inside = 0; // keys of the cell in the range
};

struct MedianSearch
{
  std::uint64_t rank = 0;     // of the wanted key, 0 = the least
  KeyRange known;             // where it must be
  double mean = 0;            // of the coordinates of all keys: the first pivot of Heaps
  std::uint64_t keepable = 1; // a range with at most so many keys need not be narrowed any more
  std::uint64_t memory = 0;   // bytes that a method may take, beside the blocks of a pass
  double heapShare = 0; // the keys in both heaps as a share of all, 0 = as many as the memory holds
};

// A range that holds the key of the wanted rank: only that key for Heaps, Torben and Sort; one of
// at most `keepable` keys for Histogram. Passes over the n keys, a heap of h of them: Heaps 1 where
// the wanted key is among the h / 2 on its side of the mean, n / (h / 2) at worst; Torben at most
// the bits of the ratio between the extent and the least difference, 2,000 for doubles at worst;
// Sort 1 + log of the number of runs to the base of the fan-in; Histogram at most (64 + 32) / 16,
// the bins as fine as the memory allows. Errors: those of the source and of spill files (Sort).
Result<KeyRange> FindMedian(
  MedianMethod method, KeySource& keys, const MedianSearch& search, SpillFolder& folder);

// One method each, for FindMedian.
Result<KeyRange> FindMedianByHeaps(KeySource& keys, const MedianSearch& search);
Result<KeyRange> FindMedianByTorben(KeySource& keys, const MedianSearch& search);
Result<KeyRange> FindMedianBySort(KeySource& keys, const MedianSearch& search, SpillFolder& folder);
Result<KeyRange> FindMedianByHistogram(KeySource& keys, const MedianSearch& search);

}
