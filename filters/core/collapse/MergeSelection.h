// SPDX-License-Identifier: BSD-3-Clause
// Selects the cheapest of many merges in passes over them; the merges need not be in memory. Only
// for the makers of levels.
#pragma once

#include "filters/core/BitCast.h"
#include "filters/core/Result.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace kdstream
{

// Stands for all errors below `error`, and the first `ties` of those equal to it, in the order of
// the passes.
struct CheapestErrors
{
  double error = -1;
  std::uint64_t ties = 0;

  // How many entries of a sorted list, from `first` on, belong to them. Subtracts those equal to
  // `error` from `ties`.
  template <class Errors, class ErrorOf>
  std::size_t Take(const Errors& sorted, std::size_t first, const ErrorOf& errorOf)
  {
    std::size_t end = first;
    while (end < sorted.size() && errorOf(sorted[end]) < this->error)
    {
      ++end;
    }
    while (end < sorted.size() && this->ties > 0 && errorOf(sorted[end]) == this->error)
    {
      ++end;
      --this->ties;
    }
    return end - first;
  }
};

// Finds the `count` cheapest of a sequence of errors; the result is that of sorting by (error,
// position). forEach(visit) -> Status calls visit(error) for each error, always in the same order.
// It is called twice, or up to four times if very many errors are nearly equal. sum(bins) adds the
// counts of other processes, which visit errors of their own; `count` is the total over all
// processes. REQUIRES: 1 <= count <= number of errors; no error is negative or NaN. O(errors);
// memory 1 MiB.
template <class ForEach, class Sum>
Result<CheapestErrors> FindCheapest(const ForEach& forEach, std::uint64_t count, const Sum& sum)
{
  constexpr unsigned digits = 16; // bits
  constexpr std::uint64_t mostKept = std::uint64_t{ 1 } << digits;
  std::uint64_t known = 0;         // the upper bits of the error sought
  std::uint64_t rest = count;      // rank of the wanted error among errors with these bits, from 1
  std::vector<std::uint64_t> kept; // all errors with these bits, once there are few
  bool few = false, areKept = false;
  std::vector<std::uint64_t> bins;
  for (unsigned shift = 64; shift > 0;)
  {
    const unsigned before = shift;
    shift -= digits;
    bins.assign(std::size_t{ 1 } << digits, 0);
    const auto begins = [&](std::uint64_t bits) { return before == 64 || bits >> before == known; };
    const auto add = [&](std::uint64_t bits) { ++bins[(bits >> shift) & (bins.size() - 1)]; };
    if (areKept)
    {
      std::erase_if(kept, [&](std::uint64_t bits) { return !begins(bits); });
      std::for_each(kept.begin(), kept.end(), add);
    }
    else
    {
      KDSTREAM_TRY(forEach(
        [&](double error)
        {
          const auto bits = BitCast<std::uint64_t>(error + 0.0); // no -0.0
          if (begins(bits))
          {
            add(bits);
            if (few)
            {
              kept.push_back(bits);
            }
          }
        }));
      areKept = few;
    }
    KDSTREAM_TRY(sum(std::span<std::uint64_t>(bins)));
    std::size_t bin = 0;
    while (rest > bins[bin])
    {
      rest -= bins[bin++];
    }
    known = known << digits | bin;
    few = bins[bin] <= mostKept;
  }
  return CheapestErrors{ BitCast<double>(known), rest };
}

template <class ForEach>
Result<CheapestErrors> FindCheapest(const ForEach& forEach, std::uint64_t count)
{
  return FindCheapest(forEach, count, [](std::span<std::uint64_t>) { return Status{}; });
}

}
