// SPDX-License-Identifier: BSD-3-Clause
// Maps from vertex numbers to vertex numbers that do not fit the memory (ids after welding, places
// in the tree), and applying them to triangles: the join of building out of core
// (doc/design.md#faces).
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/Types.h"
#include "filters/outofcore/files/RecordFile.h"
#include "filters/outofcore/files/SpillFile.h"

#include <cstdint>
#include <functional>
#include <span>

namespace kdstream
{

// A triangle that knows its place in the input: later steps come back to that order.
struct NumberedTriangle
{
  Triangle corners;
  std::uint32_t number = 0;
  bool operator==(const NumberedTriangle&) const = default;
};

// For each vertex number 0 … count - 1 another one: 4 bytes each, in a file.
struct VertexMap
{
  SpillFile file;
  std::uint32_t count = 0;
};

// The numbers in parts of equal size, each of which fits the memory.
struct MapSections
{
  std::uint32_t count = 0;
  std::uint32_t entries = 1; // of each but the last

  // memory: bytes that the entries of one may take.
  static MapSections Over(std::uint32_t count, std::uint64_t memory, std::size_t entryBytes);

  std::size_t Number() const
  {
    return (static_cast<std::size_t>(this->count) + this->entries - 1) / this->entries;
  }
  std::size_t Of(VertexId v) const { return v / this->entries; }
  VertexId Begin(std::size_t section) const
  {
    return static_cast<VertexId>(section * this->entries);
  }
  VertexId End(std::size_t section) const
  {
    return section + 1 == this->Number() ? this->count : this->Begin(section + 1);
  }
};

// Replaces each corner of the triangles by its entry of the map, and gives the triangles to `visit`
// in blocks, never two at once. Their order is arbitrary, but the same for the same input and
// memory. If the map fits half of the memory: one pass over the triangles. Else the triangles are
// sorted into buckets by one corner after the other: three more passes of writing and reading. Peak
// memory: `memory` and two blocks. Errors: InputOutput; Cancelled; those of `visit`. REQUIRES:
// every corner < map.count.
Status MapTriangles(SpillFolder& folder, const SpillFile& triangles, std::uint64_t count,
  const VertexMap& map, std::uint64_t memory, const Execution& execution,
  const std::function<Status(std::span<const NumberedTriangle>)>& visit);

}
