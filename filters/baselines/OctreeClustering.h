// SPDX-License-Identifier: BSD-3-Clause
// Octree clustering of vertices, the paper's first baseline: partitions of equal cubes instead of
// equal counts. Step "tree" of the pipeline picture, in place of KdTree.
#pragma once

#include "filters/baselines/OctreeKey.h"
#include "filters/core/Execution.h"
#include "filters/core/Result.h"
#include "filters/core/Types.h"
#include "filters/core/tree/Clustering.h"

#include <cstdint>
#include <optional>
#include <span>

namespace kdstream
{

struct OctreeOptions
{
  // A cell of more vertices is split (N of the paper), at least 1. Ignored if `partitions` is
  // given.
  std::uint32_t verticesPerPartition = 2000;
  // The wanted number of clusters instead, 1 … n. An octree cannot give every number. So the N is
  // used that gives the nearest number (if two are as near, the one with fewer clusters).
  std::optional<std::uint32_t> partitions;
};

struct OctreeClustering : Clustering
{
  // The N of these clusters: that of the options, or the one that was found.
  std::uint32_t verticesPerPartition = 0;
  unsigned depth = 0; // of the deepest leaf; the root has depth 0
};

// Clusters vertices by the leaves of an octree. Input: n finite points. The root is a cube: it has
// the centre of the vertices' box, and its longest side. A cell of more than N vertices is split at
// its centre into eight equal cubes (a vertex on the plane goes to the upper side), down to depth
// octreeDeepest. The leaves that contain vertices are the clusters, in Morton order (x changes
// fastest, then y, then z).
// A wanted number is reached without trying different N: a smaller N only splits more cells. So the
// fullest cells are split, always all with the same count, until there are enough. Of the last two
// numbers the nearer one is taken.
// Complexity: O(n d) for leaves of depth d <= 21, and O(c log c) for the search among c cells;
// memory 32 bytes a vertex. Threads compute the keys, and subtrees if N is given; the result does
// not depend on them. Errors: InvalidArgument for no vertices, an N of 0, a number of partitions of
// 0 or above n; InvalidInput beyond mostExtent (Extent.h); LimitExceeded beyond 2^32 - 2 vertices;
// Cancelled. Source: paper 2.1 and 4.1.1, [22].
Result<OctreeClustering> ClusterByOctree(
  std::span<const Vec3> points, const OctreeOptions& options, const Execution& execution = {});

}
