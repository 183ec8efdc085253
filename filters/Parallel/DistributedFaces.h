// SPDX-License-Identifier: BSD-3-Clause
// Step "faces" of a parallel build: brings the triangles and attributes that each rank has read to
// the ranks in whose cells they lie. For DistributedBuilder.
#pragma once

#include "filters/Parallel/DistributedWeld.h"
#include "filters/Parallel/MpiGroup.h"
#include "filters/core/Execution.h"
#include "filters/outofcore/mesh/MeshBlocks.h"
#include "filters/outofcore/mesh/MeshSpill.h"

#include <cstdint>

namespace kdstream
{

// Sends every triangle to the ranks whose blocks it touches, and vertices' and triangles' tuples to
// where they are needed; fills mesh.triangles, triangleCount, pointTuples, cellTuples and foreign,
// and fetches the foreign vertices' records. A distributed list turns the corners of triangles into
// leaf positions in the tree: each rank has the part for the vertices that it has read (4 bytes a
// vertex; in memory where this fits a quarter of `memory`). It is asked in batches of up to 2^18
// triangles. Memory: `memory`, and twice 4 bytes for each foreign vertex. vertices: their tuples
// and numbers are moved from. REQUIRES: a tree (BuildTreeCollectively), mesh.blockDepth not above
// the group's nodes. Errors: LimitExceeded for more than 2^32 - 2 triangles; InputOutput;
// Cancelled; MpiGroup's.
Status ScatterFaces(MpiGroup& group, SpillFolder& folder, const SpilledMesh& share,
  DistributedVertices& vertices, std::uint64_t memory, MeshBlocks& mesh,
  const Execution& execution);

}
