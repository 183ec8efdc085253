// SPDX-License-Identifier: BSD-3-Clause
// Makes a level by clusters from the next finer one: whole, or the part in some cells of the tree.
// Only for the makers of levels.
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

// Consecutive clusters of a level: all that some cells hold. Links between them, and to clusters of
// other cells, use numbers of the level.
struct ClusterPart
{
  std::span<const ClusterSum> clusters;
  std::span<const std::uint32_t> cellOf; // finest cell of each cluster's lowest original vertex
  VertexId first = 0;                    // the number of the first cluster
  // All triangles that touch one of the clusters, perhaps more.
  std::span<const Triangle> triangles;
  // Pairs of clusters that only collapsed triangles, or coincident vertices, tie together.
  std::span<const Link> links;
};

// How clusters of a level become clusters of coarser ones.
struct ClusterRules
{
  const ClusterOptions& options;
  unsigned finest = 0; // L
  Vec3 origin{};       // of the sums
};

// The clusters of level `depth`, without triangles, from those of level depth + 1: inside each cell
// the connected clusters join, so that at most four are left (CellComponents.h), or one without
// components. Numbered by (cell, lowest original vertex); sums go over children by lowest original
// vertex. parents: for each cluster its place among the coarser ones. REQUIRES: no cell of `depth`
// is cut. O(c log c + t).
CollapseState MakeCoarserClusters(const ClusterPart& below, unsigned depth,
  const ClusterRules& rules, std::vector<VertexId>& parents, const Execution& execution);

// Appends the link that remains of a triangle with exactly two different corners. A link is mapped
// like such a triangle.
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

// In order, each once. O(l log l).
void SortLinks(std::vector<Link>& links);

// The links between the images of the ends of triangles' edges and links. O(l log l).
std::vector<Link> ImageOfLinks(
  std::span<const Triangle> triangles, std::span<const Link> links, std::span<const VertexId> map);

// Makes the levels `depth` … coarsestDepth from level `depth`, of which all clusters, triangles and
// links are given. Returns them without attributes. Errors: Cancelled.
Result<std::vector<ClusterLevel>> BuildCoarserClusterLevels(CollapseState state,
  std::vector<Link> links, unsigned depth, const ClusterRules& rules, const Execution& execution);

}
