// SPDX-License-Identifier: BSD-3-Clause
// The sums from which levels get their numbers and classes: the sum of a cluster's values, and the
// votes for its class. Trivially copyable, because AttributeSums keeps them as bytes in records.
// Only for LevelAttributes.cxx and CarriedArrays.cxx.
#pragma once

#include "filters/core/Attribute.h"
#include "filters/core/Types.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>

namespace kdstream
{

// The mean of one component of an array. Values that are not finite are left out; if none is left
// the mean is NaN, or 0 in arrays of integers.
class ScalarSum
{
public:
  void Add(const Attribute& array, std::size_t tuple, std::size_t component = 0)
  {
    const double value = array.Get(tuple, component);
    if (std::isfinite(value))
    {
      this->Sum += value * scale;
      ++this->Count;
    }
  }
  void Add(const ScalarSum& child)
  {
    this->Sum += child.Sum;
    this->Count += child.Count;
  }
  bool IsPossible() const { return this->Count < noVertex && std::isfinite(this->Sum); }
  double Mean() const
  {
    return this->Count == 0 ? std::numeric_limits<double>::quiet_NaN()
                            : this->Sum / static_cast<double>(this->Count) / scale;
  }
  // Only for arrays of one component.
  void AppendMean(Attribute& means) const
  {
    const std::size_t tuple = means.TupleCount();
    means.values.resize(means.values.size() + means.TupleSize());
    means.Set(tuple, 0, this->Mean());
  }

private:
  // Scales values so that no sum of doubles becomes infinite.
  static constexpr double scale = 0x1p-64;

  double Sum = 0; // times scale
  std::uint64_t Count = 0;
};

// The most frequent value of an array that holds classes (HoldsClasses). Counts votes for four
// values at a time. If a cluster has at most four different values, the winner is the most frequent
// one. If it has more, the most frequent value can have more votes than the winner, but at most by
// a fifth of all votes. If all votes cancel each other, the value of the lowest original vertex
// wins.
//
// Source: Misra, Gries, "Finding repeated elements", 1982; merging two summaries: Agarwal et al.,
// "Mergeable summaries", 2012.
class ClassVotes
{
public:
  void Add(const Attribute& array, std::size_t tuple, std::size_t = 0)
  {
    if (std::isfinite(array.Get(tuple, 0)))
    {
      ClassVotes one;
      std::memcpy(&one.First, &array.values[tuple * array.TupleSize()], array.TupleSize());
      one.Values[0] = one.First;
      one.Counts[0] = 1;
      one.All = 1;
      this->Add(one);
    }
  }
  void Add(const ClassVotes& child)
  {
    std::array<std::uint64_t, 2 * places> values{};
    std::array<std::uint32_t, 2 * places> counts{};
    std::copy(this->Values.begin(), this->Values.end(), values.begin());
    std::copy(this->Counts.begin(), this->Counts.end(), counts.begin());
    for (std::size_t i = 0; i < places && child.Counts[i] > 0; ++i)
    {
      std::size_t k = 0;
      while (counts[k] > 0 && values[k] != child.Values[i])
      {
        ++k;
      }
      values[k] = child.Values[i];
      counts[k] += child.Counts[i];
    }
    this->First = this->All == 0 ? child.First : this->First;
    this->All += child.All;
    this->Take(values, counts);
  }
  bool IsPossible() const
  {
    std::uint64_t counted = 0;
    bool ended = false;
    for (const std::uint32_t count : this->Counts)
    {
      if (ended && count > 0)
      {
        return false;
      }
      ended = count == 0;
      counted += count;
    }
    return this->All < noVertex && counted <= this->All;
  }
  // Appends the winner; of several with the same votes, the lowest value. If there are no votes,
  // appends 0, or NaN to an array of floating-point numbers.
  void AppendMean(Attribute& winners) const
  {
    std::size_t best = 0;
    for (std::size_t i = 1; i < places; ++i)
    {
      if (this->Counts[i] > this->Counts[best] ||
          (this->Counts[i] == this->Counts[best] && this->Counts[i] > 0 &&
            this->Values[i] < this->Values[best]))
      {
        best = i;
      }
    }
    const std::size_t tuple = winners.TupleCount();
    winners.values.resize(winners.values.size() + winners.TupleSize());
    if (this->All > 0)
    {
      std::memcpy(&winners.values[tuple * winners.TupleSize()],
        this->Counts[best] > 0 ? &this->Values[best] : &this->First, winners.TupleSize());
    }
    else
    {
      winners.Set(tuple, 0, std::numeric_limits<double>::quiet_NaN());
    }
  }

private:
  static constexpr std::size_t places = 4;

  // Keeps the four of up to eight values that have the most votes, and subtracts the votes of the
  // fifth from each.
  void Take(const std::array<std::uint64_t, 2 * places>& values,
    const std::array<std::uint32_t, 2 * places>& counts)
  {
    std::array<std::uint32_t, 2 * places> sorted = counts;
    std::sort(sorted.rbegin(), sorted.rend());
    const std::uint32_t off = sorted[places];
    this->Values = {};
    this->Counts = {};
    std::size_t kept = 0;
    for (std::size_t k = 0; k < values.size(); ++k)
    {
      if (counts[k] > off)
      {
        this->Values[kept] = values[k];
        this->Counts[kept++] = counts[k] - off;
      }
    }
  }

  std::array<std::uint64_t, places> Values{}; // their bytes, then zeros
  std::array<std::uint32_t, places> Counts{}; // votes; zeros last
  std::uint64_t First = 0;                    // value of the lowest original vertex, as in Values
  std::uint64_t All = 0;                      // votes
};

}
