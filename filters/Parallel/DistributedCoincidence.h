// SPDX-License-Identifier: BSD-3-Clause
// Part of step "levels" on several processes: finds vertices in the same place that different
// processes have, and links them for the levels by clusters. For DistributedLevels.
#pragma once

#include "filters/Parallel/MpiGroup.h"
#include "filters/outofcore/files/BucketFile.h"
#include "filters/outofcore/mesh/MeshBlocks.h"

#include <cstdint>
#include <optional>
#include <vector>

namespace kdstream
{

struct DistributedCoincidence
{
  // For each block of the mesh, the links whose lower end is in the block, as CollapsedTriangleOf
  // makes them. No value: links were not looked for.
  std::optional<RecordBuckets<Triangle>> links;
  std::vector<VertexId> foreign; // upper ends in other processes, ascending

  // Appends the links of a block. Errors: InputOutput.
  Status Load(std::size_t block, std::vector<Triangle>& triangles) const;
};

// Finds the pairs of vertices that are in the same place and follow each other in the order of
// leaves: the pairs that ForEachCoincidentPair (CoincidentRanks.h) finds in the whole mesh. Every
// vertex is sent to the process given by the hash of its place (16 or 32 bytes), every pair to the
// process that has its lower end (8 bytes). Memory: `memory`, and the foreign ends. Errors:
// InputOutput; those of MpiGroup.
Result<DistributedCoincidence> LinkCoincidentCollectively(
  MpiGroup& group, SpillFolder& folder, const MeshBlocks& mesh, std::uint64_t memory);

}
