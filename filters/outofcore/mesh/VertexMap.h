// SPDX-License-Identifier: BSD-3-Clause
// Maps from vertex numbers to vertex numbers (ids after welding, places in the tree) that do not
// fit in memory, and their application to triangles: the join of building out of core
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

// A triangle with its number in the input; later steps use it to restore that order.
struct NumberedTriangle
{
  Triangle corners;
  std::uint32_t number = 0;
  bool operator==(const NumberedTriangle&) const = default;
};

// Maps the vertex numbers 0 … count - 1 to other numbers: 4 bytes each, in a file.
struct VertexMap
{
  SpillFile file;
  std::uint32_t count = 0;
};

// Divides vertex numbers into sections of equal size, each of which fits in memory.
struct MapSections
{
  std::uint32_t count = 0;
  std::uint32_t entries = 1; // in each section but the last

  // memory: bytes that the entries of one section may take.
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

// Replaces each corner of the triangles by its entry in the map, and passes the triangles to
// `visit` in blocks, never two at the same time. Their order is arbitrary, but the same for the
// same input and memory. If the map fits in half of the memory, this takes one pass over the
// triangles. Otherwise the triangles are sorted into buckets by one corner after the other: three
// more passes of writing and reading. Peak memory: `memory` and two blocks. Errors: InputOutput;
// Cancelled; those of `visit`. REQUIRES: every corner < map.count.
Status MapTriangles(SpillFolder& folder, const SpillFile& triangles, std::uint64_t count,
  const VertexMap& map, std::uint64_t memory, const Execution& execution,
  const std::function<Status(std::span<const NumberedTriangle>)>& visit);

}
