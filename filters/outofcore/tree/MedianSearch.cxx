// SPDX-License-Identifier: BSD-3-Clause
// The median of what does not fit the memory: see MedianSearch.h.
#include "filters/outofcore/tree/MedianSearch.h"

#include <array>
#include <utility>

namespace kdstream
{
namespace
{

constexpr std::array<std::pair<MedianMethod, std::string_view>, 5> names{ {
  { MedianMethod::Automatic, "auto" },
  { MedianMethod::Heaps, "heaps" },
  { MedianMethod::Torben, "torben" },
  { MedianMethod::Sort, "sort" },
  { MedianMethod::Histogram, "histogram" },
} };

}

std::string_view NameOfMedianMethod(MedianMethod method)
{
  for (const auto& [candidate, name] : names)
  {
    if (candidate == method)
    {
      return name;
    }
  }
  return "";
}

std::optional<MedianMethod> MedianMethodOfName(std::string_view name)
{
  for (const auto& [method, candidate] : names)
  {
    if (candidate == name)
    {
      return method;
    }
  }
  return {};
}

Result<KeyRange> FindMedian(
  MedianMethod method, KeySource& keys, const MedianSearch& search, SpillFolder& folder)
{
  switch (method)
  {
    case MedianMethod::Heaps:
      return FindMedianByHeaps(keys, search);
    case MedianMethod::Torben:
      return FindMedianByTorben(keys, search);
    case MedianMethod::Sort:
      return FindMedianBySort(keys, search, folder);
    case MedianMethod::Automatic:
    case MedianMethod::Histogram:
      break;
  }
  return FindMedianByHistogram(keys, search);
}

}
