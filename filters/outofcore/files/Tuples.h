// SPDX-License-Identifier: BSD-3-Clause
// How attributes lie in files: of each vertex or triangle the values of all arrays together (its
// tuple), so that one element is read at once. For whatever spills attributes (MeshSpill,
// MeshBlocks, LevelStates, the phase "faces").
#pragma once

#include "filters/core/Attribute.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace kdstream
{

// Of `count` elements the tuples of all arrays, one element after the other. REQUIRES: each array
// has as many.
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

}
