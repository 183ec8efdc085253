// SPDX-License-Identifier: BSD-3-Clause
// Step "faces" of a parallel build: sends the triangles and attributes that each rank has read to
// the ranks that have their cells. For DistributedBuilder.
#pragma once

#include "filters/Parallel/DistributedWeld.h"
#include "filters/Parallel/MpiGroup.h"
#include "filters/core/Execution.h"
#include "filters/outofcore/mesh/MeshBlocks.h"
#include "filters/outofcore/mesh/MeshSpill.h"

#include <cstdint>

namespace kdstream
{

// Sends every triangle to the ranks whose blocks it touches, and the tuples of vertices and
// triangles to where they are needed. Fills mesh.triangles, triangleCount, pointTuples, cellTuples
// and foreign, and fetches the records of the foreign vertices. A distributed list turns the
// corners of triangles into leaf positions in the tree. Each rank has the part for the vertices
// that it has read (4 bytes a vertex; in memory if this fits in a quarter of `memory`). Triangles
// are looked up in batches of up to 2^18. Memory: `memory`, and twice 4 bytes for each foreign
// vertex. vertices: their tuples and numbers are moved from. REQUIRES: a tree
// (BuildTreeCollectively), mesh.blockDepth not above the group's nodes. Errors: LimitExceeded for
// more than 2^32 - 2 triangles; InputOutput; Cancelled; those of MpiGroup.
Status ScatterFaces(MpiGroup& group, SpillFolder& folder, const SpilledMesh& share,
  DistributedVertices& vertices, std::uint64_t memory, MeshBlocks& mesh,
  const Execution& execution);

}
