// SPDX-License-Identifier: BSD-3-Clause
// Any clustering of a mesh's vertices: the result of partitioners other than the k-d tree, and the
// input of cluster simplification (levels/SimplifyByClusters.h).
#pragma once

#include "filters/core/Types.h"
#include "filters/core/tree/KdTree.h"

#include <cstdint>
#include <span>
#include <vector>

namespace kdstream
{

// clusterOf: one entry a vertex, each below `clusters`. Every cluster has at least one vertex.
struct Clustering
{
  std::vector<std::uint32_t> clusterOf;
  std::uint32_t clusters = 0;
};

// Errors: InvalidArgument if there is not one entry for each vertex, or an entry is not below
// `clusters`; the message names it.
Status CheckClustering(std::size_t vertices, const Clustering& clustering);

// Replaces any labels by numbers 0, 1, 2 … in ascending order of the labels: for a caller's array
// of cluster ids. O(n log n).
Clustering ClusteringOfLabels(std::span<const std::int64_t> labels);

// The partition of each vertex in the tree of BuildKdTree, and the number of partitions, 2^P: the
// same as CellOfVertex at depth P, in less time. If there are more partitions than vertices, some
// are empty. options: cellVertices is not used. Complexity: O(n P). Errors: those of BuildKdTree.
Result<Clustering> ClusterByKdTree(
  std::span<const Vec3> points, KdTreeOptions options, const Execution& execution = {});

// A tree whose partitions are the clusters: cluster c is the node 2^P + c, where P = S = L is the
// smallest depth with 2^P >= clusters. The box of an inner node contains the boxes below it; a node
// without a cluster has an empty box. Other properties of a k-d tree do not hold: cells may have
// any size, and boxes may overlap. O(n + 2^P). REQUIRES: one entry for each point, at least one
// point.
KdTree TreeOfClustering(std::span<const Vec3> points, const Clustering& clustering);

// The parts of that tree that can be computed without the vertices: its depths, and the boxes of
// inner nodes, from the boxes of partitions. boxes: of nodes 1 … 2^(P+1) - 1; [0] is unused.
TreeDepths DepthsOfClusters(std::uint64_t clusters);
void AddBoxesAbove(std::span<Box> boxes);

}
