// SPDX-License-Identifier: BSD-3-Clause
// Whether the triangles around each single vertex fit the memory: what no smaller blocks help
// against. Step "faces" of building out of core.
#pragma once

#include "filters/outofcore/mesh/MeshBlocks.h"

#include <cstdint>

namespace kdstream
{

// limit: bytes that the build may take. A block holds all triangles of its vertices and their other
// ends: the hub of a fan brings all of it. Looks only at blocks whose triangles might be too many;
// memory 4 bytes a vertex of one. Errors: LimitExceeded, naming the vertex by its place, its
// triangles and what memory would do; InputOutput.
Status CheckHubs(
  const MeshBlocks& mesh, const RecordBuckets<NumberedTriangle>& triangles, std::uint64_t limit);

}
