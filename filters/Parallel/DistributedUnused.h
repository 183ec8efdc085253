// SPDX-License-Identifier: BSD-3-Clause
// Step "weld" of a parallel build, its end: takes out the vertices that no triangle uses, and sends
// them to rank 0, which writes the store. For DistributedBuilder.
#pragma once

#include "filters/Parallel/DistributedWeld.h"
#include "filters/Parallel/MpiGroup.h"
#include "filters/core/Execution.h"
#include "filters/outofcore/mesh/ExternalWeld.h"
#include "filters/outofcore/mesh/MeshSpill.h"

#include <cstdint>

namespace kdstream
{

// The counts of all ranks; files only on rank 0, in the order of the input.
struct DistributedUnused
{
  std::uint64_t count = 0;
  VertexFiles vertices;
};

// Takes the vertices that no rank's triangles use out of `vertices`, and numbers the rest anew, in
// the same order.
// - Each rank sends to each other rank the numbers of the vertices that its triangles use and the
//   other rank has read (4 bytes each, once in a round). Of welded vertices it sends the lowest
//   equal one, to the rank that has it.
// - One pass for each section of marks; only very many vertices need more than one.
//
// share: its triangles have the file's numbers in their corners. Memory: `memory` and the bytes of
// a round. Errors: InputOutput; Cancelled; MpiGroup's.
Result<DistributedUnused> SetUnusedAside(MpiGroup& group, SpillFolder& folder,
  const SpilledMesh& share, DistributedVertices& vertices, std::uint64_t memory,
  const Execution& execution);

}
