// SPDX-License-Identifier: BSD-3-Clause
// Selects the k-th of some records in the total order (coordinate, id): paper 4.1 step c, in
// memory.
//
// Steps, after R. W. Floyd and R. L. Rivest, "Expected time bounds for selection" (CACM 18, 1975):
//   a. Choose a pivot by a sample: just beyond the wanted rank, on the side where more records are.
//   b. Partition the records around it, without a branch that could be mispredicted.
//   c. Repeat for the part that holds the rank, which is small after two rounds.
// The sample is drawn by a fixed rule; it affects the time, never the two halves.
#pragma once

#include "filters/core/tree/PointRecord.h"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>

namespace kdstream
{

// Whether a record comes before the pivot in the total order along an axis. 0.0 and -0.0 are equal.
template <class Scalar, std::size_t Axis>
struct BeforePivot
{
  Scalar coordinate;
  VertexId id;

  explicit BeforePivot(const PointRecord<Scalar>& record)
    : coordinate(record.p[Axis])
    , id(record.id)
  {
  }
  // Bit operations instead of && and ||, because a branch here could not be predicted.
  bool operator()(const PointRecord<Scalar>& record) const
  {
    const Scalar other = record.p[Axis];
    return (unsigned(other < this->coordinate) |
             (unsigned(other == this->coordinate) & unsigned(record.id < this->id))) != 0;
  }
};

template <class Scalar, std::size_t Axis>
class RecordSelection
{
public:
  using Record = PointRecord<Scalar>;
  using Before = BeforePivot<Scalar, Axis>;

  // Afterwards *nth is the record that belongs there in sorted order; smaller records are before
  // it, larger ones after it. Expected O(n), 1.5 n comparisons; O(n log n) at worst. REQUIRES:
  // first <= nth < last, ids that differ.
  static void Select(Record* first, Record* nth, Record* last)
  {
    constexpr unsigned mostRounds = 40;
    for (unsigned round = 0; last - first > fewRecords; ++round)
    {
      if (round == mostRounds)
      {
        // The records are in an order that defeats the choice of pivots.
        std::nth_element(
          first, nth, last, [](const Record& a, const Record& b) { return Before(b)(a); });
        return;
      }
      Record* const pivot =
        last - first > manyRecords ? PivotOfSample(first, nth, last) : PivotOfThree(first, last);
      std::swap(*first, *pivot);
      Record* const middle = Partition(first, last);
      if (middle == nth)
      {
        return;
      }
      (middle < nth ? first : last) = middle < nth ? middle + 1 : middle;
    }
    Sort(first, last);
  }

private:
  static constexpr std::ptrdiff_t fewRecords = 32;
  static constexpr std::ptrdiff_t manyRecords = 600;

  // Sorts a few records: counts for each record how many are smaller, and puts it at that place.
  // This compares more pairs than needed, but without branches and several at a time, so it is
  // faster.
  static void Sort(Record* first, Record* last)
  {
    constexpr std::size_t most = fewRecords;
    const auto count = static_cast<std::size_t>(last - first);
    const std::size_t padded = (count + 3) / 4 * 4;
    Scalar coordinates[most];
    VertexId ids[most];
    Record records[most];
    for (std::size_t i = 0; i < count; ++i)
    {
      records[i] = first[i];
      coordinates[i] = first[i].p[Axis];
      ids[i] = first[i].id;
    }
    for (std::size_t i = count; i < padded; ++i)
    {
      coordinates[i] = std::numeric_limits<Scalar>::infinity(); // sorts after all others
      ids[i] = 0;
    }
    for (std::size_t i = 0; i < count; ++i)
    {
      std::uint32_t rank = 0;
      for (std::size_t j = 0; j < padded; ++j)
      {
        rank += unsigned(coordinates[j] < coordinates[i]) |
                (unsigned(coordinates[j] == coordinates[i]) & unsigned(ids[j] < ids[i]));
      }
      first[rank] = records[i];
    }
  }

  static Record* PivotOfThree(Record* first, Record* last)
  {
    Record* a = first;
    Record* b = first + (last - first) / 2;
    Record* c = last - 1;
    if (Before(*a)(*b))
    {
      std::swap(a, b);
    }
    if (Before(*b)(*c))
    {
      std::swap(b, c);
      if (Before(*a)(*b))
      {
        std::swap(a, b);
      }
    }
    return b;
  }

  // The place of a record whose rank is probably just beyond nth's.
  static Record* PivotOfSample(Record* first, Record* nth, Record* last)
  {
    const auto size = static_cast<std::uint64_t>(last - first);
    const auto rank = static_cast<std::uint64_t>(nth - first);
    // About size^(2/3): balances the cost of the sample against that of a second round.
    const unsigned bits = static_cast<unsigned>(std::bit_width(size)) * 2 / 3;
    const std::uint64_t sample = std::max<std::uint64_t>(5, std::uint64_t{ 1 } << bits >> 1);
    const std::uint64_t stride = size / sample;
    std::uint32_t noise = 1;
    for (std::uint64_t i = 0; i < sample; ++i)
    {
      noise = noise * 1664525U + 1013904223U;
      const std::uint64_t within = (std::uint64_t{ noise } * stride) >> 32;
      std::swap(first[i], first[i * stride + within]);
    }
    // At most two standard deviations of a rank in the sample.
    const std::uint64_t margin = std::uint64_t{ 1 } << (bits / 2);
    const std::uint64_t scaled = rank * sample / size;
    const std::uint64_t wanted = 2 * rank < size ? std::min(scaled + margin, sample - 1)
                                                 : (scaled > margin ? scaled - margin : 0);
    Record* const pivot = first + wanted;
    Select(first, pivot, first + sample);
    return pivot;
  }

  // Moves all records smaller than *first to the front, and *first after them; returns its new
  // place. Moves every record, even where not needed: a check would cost more.
  static Record* Partition(Record* first, Record* last)
  {
    const Before before(*first);
    Record* const begin = first + 1;
    if (begin == last)
    {
      return first;
    }
    const Record kept = *begin; // its slot becomes the gap, which moves along
    Record* gap = begin;
    Record* end = begin; // end of the records before the pivot
    for (Record* next = begin + 1; next != last; ++next)
    {
      const bool isBefore = before(*next);
      *gap = *end;
      *end = *next;
      gap = next;
      end += isBefore;
    }
    const bool isBefore = before(kept);
    *gap = *end;
    *end = kept;
    end += isBefore;
    --end;
    std::swap(*first, *end);
    return end;
  }
};

}
