// SPDX-License-Identifier: BSD-3-Clause
// The tree that a store's partitions are the leaves of, by any of the partitioners. Step "tree" of
// the pipeline picture.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/Result.h"
#include "filters/core/Types.h"
#include "filters/core/tree/KdTree.h"

#include <string_view>

namespace kdstream
{

// What the mesh is cut by. The two others are the paper's baselines: partitions only, no levels.
enum class Partitioner
{
  KdTree,
  Octree,
  KMeans
};

// "kdtree", "octree", "kmeans": as the option of kdstream-build.
std::string_view NameOf(Partitioner partitioner);

struct PartitionTree
{
  KdTree tree;
  std::uint64_t partitions = 1; // nodes 2^P … 2^P + partitions - 1; 2^P of a k-d tree
};

// Of the options verticesPerPartition or partitions are used by all; an octree has about so many
// partitions, k-means exactly, and neither has cells below them (P = S = L, see TreeOfClustering).
// Errors and complexity: BuildKdTree, ClusterByOctree, ClusterByKMeans.
Result<PartitionTree> PartitionMesh(const Mesh& mesh, Partitioner partitioner,
  const KdTreeOptions& options, const Execution& execution);

}
