// SPDX-License-Identifier: BSD-3-Clause
// Reorders a mesh so that data which later steps use together are next to each other in memory:
// part of step "faces" of the pipeline picture.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/TriangleBuckets.h"
#include "filters/core/Types.h"
#include "filters/core/tree/KdTree.h"

#include <cstdint>
#include <span>
#include <vector>

namespace kdstream
{

struct GatheredMesh
{
  std::vector<VertexId> ids; // the earlier number of each vertex
  TriangleBuckets buckets;   // by partition; inside each, triangles keep their order
};

// Whether consecutive triangles, or consecutive vertices, mostly lie in different partitions. If
// so, a pass over the mesh partition by partition waits for memory. Looks only at a sample: O(1).
// partitionOf: the partition of each vertex.
bool IsScattered(std::span<const Triangle> triangles, std::span<const std::uint32_t> partitionOf);

// Renumbers the vertices partition by partition; inside a partition they keep their order. Groups
// the triangles by their lowest partition; inside a group they keep their order. Points, corners,
// all attributes and the tree's order are changed accordingly. Decisions and sums inside a
// partition that follow the order of the vertex numbers give the same bits as before. Code that
// compares vertices of different partitions must compare their `ids`. The result does not depend on
// the number of threads. O(n log(partition) + t); memory beside the result: 24 bytes a vertex, 16 a
// triangle, or one array, whichever is most. REQUIRES: every vertex is in the tree.
GatheredMesh GatherMesh(Mesh& mesh, KdTree& tree, const Execution& execution = {});

}
