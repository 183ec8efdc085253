// SPDX-License-Identifier: BSD-3-Clause
// Welding of vertices that do not fit in memory: step "weld" of the pipeline picture, out of core.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/Types.h"
#include "filters/outofcore/files/SpillFile.h"
#include "filters/outofcore/mesh/VertexMap.h"

#include <cstddef>
#include <cstdint>
#include <optional>

namespace kdstream
{

// Vertices in files, by id: coordinates, and for each vertex the bytes of its tuples of all point
// arrays, one after the other.
struct VertexFiles
{
  std::uint32_t count = 0;
  SpillFile points; // Vec3
  SpillFile tuples; // tupleBytes each; closed if there are no point arrays
  std::size_t tupleBytes = 0;
};

struct ExternalWeld
{
  VertexFiles vertices;         // the vertices that stay, in input order
  std::uint64_t welded = 0;     // how many vertices were removed
  std::optional<VertexMap> map; // new id of each input vertex; nothing if no vertex was merged
};

// Joins vertices with bit-equal coordinates and bit-equal tuples to the one with the lowest id, and
// renumbers the rest in their order: to the bit what core's WeldVertices does (Weld.h). Expected
// O(n). If the vertices do not fit in memory, they are written and read once as buckets by hash,
// and the matches in passes over the ids. Peak memory: `memory` and a few blocks, whichever
// vertices are equal. Errors: InputOutput; Cancelled.
Result<ExternalWeld> WeldExternally(
  SpillFolder& folder, VertexFiles input, std::uint64_t memory, const Execution& execution = {});

}
