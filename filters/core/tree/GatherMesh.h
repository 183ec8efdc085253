// SPDX-License-Identifier: BSD-3-Clause
// Reorders a mesh so that what later steps use together is together in memory: part of step "faces"
// of the pipeline picture.
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
  TriangleBuckets buckets;   // by partition; in each in the order that the triangles had before
};

// Whether consecutive triangles, or vertices, mostly lie in different partitions, by a sample: then
// a pass over the mesh partition by partition waits for memory. O(1). partitionOf: of each vertex.
bool IsScattered(std::span<const Triangle> triangles, std::span<const std::uint32_t> partitionOf);

// Gives the vertices new numbers, partition by partition and inside each in the order they had; the
// triangles are moved next to those of the same lowest partition, again in the order they had.
// Points, corners, all attributes and the tree's order are changed accordingly. Decisions and sums
// inside a partition, in the order of these numbers, give the same bits as before. Code that
// compares vertices of different partitions must compare their `ids`. The same for any number of
// threads. O(n log(partition) + t); memory beside the result: 24 bytes a vertex, or 16 a triangle,
// or one array. REQUIRES: every vertex is in the tree.
GatheredMesh GatherMesh(Mesh& mesh, KdTree& tree, const Execution& execution = {});

}
