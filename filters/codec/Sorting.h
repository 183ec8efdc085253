// SPDX-License-Identifier: BSD-3-Clause
// Sorting functions that add little code to the web page and are fast for the data of pieces.
// std::sort is neither.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace kdstream
{

// Sorts few items by insertion, many by a heap. Its code is smaller than that of std::sort, so the
// web page is smaller.
template <class Item, class IsBefore>
void SortFew(Item* items, std::size_t count, const IsBefore& isBefore)
{
  constexpr std::size_t few = 16;
  if (count <= few)
  {
    for (std::size_t i = 1; i < count; ++i)
    {
      const Item moved = items[i];
      std::size_t place = i;
      for (; place > 0 && isBefore(moved, items[place - 1]); --place)
      {
        items[place] = items[place - 1];
      }
      items[place] = moved;
    }
    return;
  }
  // Puts items into heap order from the middle down, then takes out the last one repeatedly.
  for (std::size_t left = count / 2, size = count; size > 1;)
  {
    if (left > 0)
    {
      --left;
    }
    else
    {
      std::swap(items[0], items[--size]);
    }
    for (std::size_t parent = left, child = 0; (child = 2 * parent + 1) < size; parent = child)
    {
      child += child + 1 < size && isBefore(items[child], items[child + 1]);
      if (!isBefore(items[parent], items[child]))
      {
        break;
      }
      std::swap(items[parent], items[child]);
    }
  }
}

// A stable sort. `other` is scratch memory. Merges runs of one, two, four …, without branches that
// are hard to predict.
template <class Item, class IsBefore>
void SortByMerging(std::vector<Item>& items, std::vector<Item>& other, const IsBefore& isBefore)
{
  const std::size_t count = items.size();
  other.resize(count);
  for (std::size_t run = 1; run < count; run *= 2)
  {
    for (std::size_t begin = 0; begin < count; begin += 2 * run)
    {
      const std::size_t middle = std::min(begin + run, count), end = std::min(middle + run, count);
      std::size_t left = begin, right = middle, to = begin;
      while (left < middle && right < end)
      {
        const bool takesRight = isBefore(items[right], items[left]);
        other[to++] = items[takesRight ? right : left];
        right += takesRight;
        left += !takesRight;
      }
      std::copy(items.data() + left, items.data() + middle, other.data() + to);
      std::copy(items.data() + right, items.data() + end, other.data() + to + (middle - left));
    }
    items.swap(other);
  }
}

// Replaces each count by the sum of it and all counts before it.
inline void SumUp(std::vector<std::uint32_t>& counts)
{
  std::uint32_t sum = 0;
  for (std::uint32_t& count : counts)
  {
    sum += count;
    count = sum;
  }
}

}
