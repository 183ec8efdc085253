// SPDX-License-Identifier: BSD-3-Clause
// Any clustering of a mesh's vertices: what partitioners other than the k-d tree give, and what
// cluster simplification (levels/SimplifyByClusters.h) takes.
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

// Numbers any labels 0, 1, 2 … in ascending order of the labels: what a caller's array of cluster
// ids becomes. O(n log n).
Clustering ClusteringOfLabels(std::span<const std::int64_t> labels);

// For each vertex its partition of the tree of BuildKdTree, and their number, 2^P: as CellOfVertex
// at P, in less time. A partition may be empty where there are more of them than vertices. options:
// cellVertices does not matter. Complexity: O(n P). Errors: those of BuildKdTree.
Result<Clustering> ClusterByKdTree(
  std::span<const Vec3> points, KdTreeOptions options, const Execution& execution = {});

// A tree whose partitions are the clusters: cluster c is the node 2^P + c, P = S = L the smallest
// depth with 2^P >= clusters. Nodes above have the boxes of all below them, nodes without a cluster
// empty ones. Nothing else of a k-d tree holds: cells are of any size, and boxes may overlap.
// O(n + 2^P). REQUIRES: one entry a point, at least one point.
KdTree TreeOfClustering(std::span<const Vec3> points, const Clustering& clustering);

// The parts of that tree that do not need the vertices: its depths, and the boxes of the nodes
// above the partitions from theirs. boxes: of nodes 1 … 2^(P+1) - 1, [0] is unused.
TreeDepths DepthsOfClusters(std::uint64_t clusters);
void AddBoxesAbove(std::span<Box> boxes);

}
