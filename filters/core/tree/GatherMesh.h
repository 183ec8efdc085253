// SPDX-License-Identifier: BSD-3-Clause
// A mesh in no order, moved so that what later steps use together lies together: part of step
// "faces" of the pipeline picture.
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
  std::vector<VertexId> ids; // of each vertex the number that it had before
  TriangleBuckets buckets;   // by partition; in each in the order that the triangles had before
};

// Whether triangles that follow each other, or vertices, mostly lie in different partitions, by a
// sample: whoever goes through the mesh partition by partition then waits for memory. O(1).
// partitionOf: of each vertex.
bool IsScattered(std::span<const Triangle> triangles, std::span<const std::uint32_t> partitionOf);

// Gives the vertices new numbers, partition by partition and inside each in the order they had; the
// triangles are moved next to those of the same lowest partition, again in the order they had.
// Points, corners, all attributes and the tree's order follow. What is decided or added up
// partition by partition in the order of these numbers comes to the same bits as before; whatever
// compares vertices of different partitions has to go by their `ids`. The same for any number of
// threads. O(n log(partition) + t); memory beside the result: 24 bytes a vertex, or 16 a triangle,
// or one array. REQUIRES: every vertex is in the tree.
GatheredMesh GatherMesh(Mesh& mesh, KdTree& tree, const Execution& execution = {});

}
