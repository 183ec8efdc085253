// SPDX-License-Identifier: BSD-3-Clause
// Checks that the triangles around each single vertex fit in memory: smaller blocks do not help if
// there are too many. Step "faces" of building out of core.
#pragma once

#include "filters/outofcore/mesh/MeshBlocks.h"

#include <cstdint>

namespace kdstream
{

// limit: bytes that the build may take. A block holds all triangles of its vertices, and their
// other corners. So a block with the hub of a fan holds the whole fan. Looks only at blocks that
// may have too many triangles; memory: 4 bytes for each vertex of such a block. Errors:
// LimitExceeded, naming the vertex's coordinates, its number of triangles and the memory that would
// be enough; InputOutput.
Status CheckHubs(
  const MeshBlocks& mesh, const RecordBuckets<NumberedTriangle>& triangles, std::uint64_t limit);

}
