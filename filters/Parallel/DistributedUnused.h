// SPDX-License-Identifier: BSD-3-Clause
// The end of step "weld" of a parallel build: removes the vertices that no triangle uses, and sends
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

// The count is that of all ranks. The files are only on rank 0, in the order of the input.
struct DistributedUnused
{
  std::uint64_t count = 0;
  VertexFiles vertices;
};

// Removes the vertices that no triangle of any rank uses from `vertices`, and renumbers the rest in
// the same order.
// - Each rank sends each other rank the numbers of the vertices that its triangles use and that the
//   other rank has read (4 bytes each, once in a round). For a welded vertex, the number of the
//   lowest equal vertex is sent to the rank that has that one.
// - There is one pass for each section of marks; only a huge number of vertices needs more than one
//   section.
//
// share: the corners of its triangles are numbers in the file. Memory: `memory` and the bytes of a
// round. Errors: InputOutput; Cancelled; those of MpiGroup.
Result<DistributedUnused> SetUnusedAside(MpiGroup& group, SpillFolder& folder,
  const SpilledMesh& share, DistributedVertices& vertices, std::uint64_t memory,
  const Execution& execution);

}
