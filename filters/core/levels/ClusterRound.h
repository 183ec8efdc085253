// SPDX-License-Identifier: BSD-3-Clause
// Makes a level by clustering the next finer one: the whole level, or its part in some cells of the
// tree. Only for the makers of levels.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/Result.h"
#include "filters/core/levels/ClusterSum.h"
#include "filters/core/levels/CollapseState.h"
#include "filters/core/tree/KdTree.h"

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

namespace kdstream
{

// Consecutive clusters of a level: all clusters of some cells. Links between them, and to clusters
// of other cells, use the numbers that clusters have in the level.
struct ClusterPart
{
  std::span<const ClusterSum> clusters;
  std::span<const std::uint32_t> cellOf; // finest cell of each cluster's lowest original vertex
  VertexId first = 0;                    // the number of the first cluster
  // All triangles that touch one of the clusters, perhaps more.
  std::span<const Triangle> triangles;
  // Pairs of clusters that are connected only by collapsed triangles or coincident vertices.
  std::span<const Link> links;
};

// How clusters of a level become clusters of coarser ones.
struct ClusterRules
{
  const ClusterOptions& options;
  unsigned finest = 0; // L
  Vec3 origin{};       // of the sums
};

// Makes the clusters of level `depth`, without triangles, from those of level depth + 1. Inside
// each cell connected clusters are joined, and at most four clusters are left (CellComponents.h);
// one if rules.options.byComponents is false. Clusters are ordered by (cell, lowest original
// vertex); sums go over children by lowest original vertex. parents: for each cluster of `below`
// the place of its parent in the result. REQUIRES: `below` holds whole cells of `depth`. O(c log c
// + t).
CollapseState MakeCoarserClusters(const ClusterPart& below, unsigned depth,
  const ClusterRules& rules, std::vector<VertexId>& parents, const Execution& execution);

// If a triangle has exactly two different corners, appends the link between them, which is all that
// remains of it. A link is mapped like such a triangle.
inline void AppendLinkOf(const Triangle& t, std::vector<Link>& links)
{
  const VertexId other = t[0] == t[1] ? t[2] : t[1];
  if (t[0] != other && IsDegenerate(t))
  {
    links.emplace_back(std::min(t[0], other), std::max(t[0], other));
  }
}

inline Triangle CollapsedTriangleOf(const Link& link)
{
  return { link.first, link.first, link.second };
}

// Sorts links and removes duplicates. O(l log l).
void SortLinks(std::vector<Link>& links);

// The links at the next coarser level: those that remain of triangles whose image has exactly two
// different corners, and the images of links between two different clusters. O(l log l).
std::vector<Link> ImageOfLinks(
  std::span<const Triangle> triangles, std::span<const Link> links, std::span<const VertexId> map);

// Makes the levels `depth` … coarsestDepth from level `depth`, of which all clusters, triangles and
// links are given. Returns them without attributes. Errors: Cancelled.
Result<std::vector<ClusterLevel>> BuildCoarserClusterLevels(CollapseState state,
  std::vector<Link> links, unsigned depth, const ClusterRules& rules, const Execution& execution);

}
