// SPDX-License-Identifier: BSD-3-Clause
// Vertices that no triangle uses, of a parallel build: after step "weld" they are set aside, and
// rank 0, which writes the store, gets them. For DistributedBuilder.
#pragma once

#include "filters/Parallel/DistributedWeld.h"
#include "filters/Parallel/MpiGroup.h"
#include "filters/core/Execution.h"
#include "filters/outofcore/mesh/ExternalWeld.h"
#include "filters/outofcore/mesh/MeshSpill.h"

#include <cstdint>

namespace kdstream
{

// Of all ranks; files only on rank 0, in the order of the file that was read.
struct DistributedUnused
{
  std::uint64_t count = 0;
  VertexFiles vertices;
};

// Takes the vertices out of `vertices` that no rank's triangles use, and numbers the rest anew, in
// their order.
// - A rank names to each other rank the vertices of its triangles that this other has read (4 bytes
//   each, once in a round). Of welded vertices that rank names the lowest equal to the rank that
//   has it.
// - One pass for each section of marks; only very many vertices need more than one.
//
// share: its triangles have the file's numbers in their corners. Memory: `memory` and the bytes of
// a round. Errors: InputOutput; Cancelled; MpiGroup's.
Result<DistributedUnused> SetUnusedAside(MpiGroup& group, SpillFolder& folder,
  const SpilledMesh& share, DistributedVertices& vertices, std::uint64_t memory,
  const Execution& execution);

}
