// SPDX-License-Identifier: BSD-3-Clause
// How attributes are stored in files: the values of all arrays for one vertex or triangle (its
// tuple) are stored together, so that one read gets them all. For all code that spills attributes
// (MeshSpill, MeshBlocks, LevelStates, the phase "faces").
#pragma once

#include "filters/core/Attribute.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <span>
#include <vector>

namespace kdstream
{

// Joins the tuples of all arrays for `count` elements, one element after the other. REQUIRES: each
// array has `count` tuples.
inline std::vector<std::byte> InterleaveTuples(
  std::span<const Attribute* const> arrays, std::size_t count)
{
  std::size_t stride = 0;
  for (const Attribute* const array : arrays)
  {
    stride += array->TupleSize();
  }
  std::vector<std::byte> tuples(count * stride);
  std::size_t offset = 0;
  for (const Attribute* const array : arrays)
  {
    const std::size_t size = array->TupleSize();
    const auto values = std::as_bytes(std::span<const std::uint8_t>(array->values));
    for (std::size_t i = 0; i < count; ++i)
    {
      const auto tuple = values.subspan(i * size, size);
      std::copy(tuple.begin(), tuple.end(), tuples.begin() + std::ptrdiff_t(i * stride + offset));
    }
    offset += size;
  }
  return tuples;
}

// The inverse: appends the elements in `tuples` to the arrays.
inline void SplitTuples(std::span<const std::byte> tuples, std::span<Attribute> arrays)
{
  while (!tuples.empty())
  {
    for (Attribute& array : arrays)
    {
      const auto tuple = tuples.first(array.TupleSize());
      std::transform(tuple.begin(), tuple.end(), std::back_inserter(array.values),
        [](std::byte byte) { return std::to_integer<std::uint8_t>(byte); });
      tuples = tuples.subspan(tuple.size());
    }
  }
}

}
