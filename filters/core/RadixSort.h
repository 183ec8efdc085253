// SPDX-License-Identifier: BSD-3-Clause
// Sorting by whole numbers without comparing them.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace kdstream
{

// Sorts entries by their upper 32 bits; entries with equal upper bits keep their order. So the
// result is sorted by all 64 bits if the upper halves are all different, or if the lower halves
// were in ascending order before. Time: O(entries). Memory: a copy of the entries.
inline void SortByUpperHalf(std::vector<std::uint64_t>& entries)
{
  constexpr std::size_t fewest = 256;
  constexpr unsigned digitBits = 11;
  constexpr std::size_t digits = std::size_t{ 1 } << digitBits;
  const auto upper = [](std::uint64_t entry) { return entry >> 32; };
  std::uint64_t all = 0, previous = 0;
  bool sorted = true;
  for (const std::uint64_t entry : entries)
  {
    all |= upper(entry);
    sorted &= previous <= upper(entry);
    previous = upper(entry);
  }
  if (sorted)
  {
    return;
  }
  if (entries.size() < fewest)
  {
    std::stable_sort(entries.begin(), entries.end(),
      [&](std::uint64_t a, std::uint64_t b) { return upper(a) < upper(b); });
    return;
  }
  std::vector<std::uint64_t> moved(entries.size());
  for (unsigned shift = 32; shift < 32U + static_cast<unsigned>(std::bit_width(all));
       shift += digitBits)
  {
    std::array<std::size_t, digits> next{};
    for (const std::uint64_t entry : entries)
    {
      ++next[entry >> shift & (digits - 1)];
    }
    std::size_t sum = 0;
    for (std::size_t& count : next)
    {
      const std::size_t own = count;
      count = sum;
      sum += own;
    }
    for (const std::uint64_t entry : entries)
    {
      moved[next[entry >> shift & (digits - 1)]++] = entry;
    }
    entries.swap(moved);
  }
}

}
