// SPDX-License-Identifier: BSD-3-Clause
// A level by clusters from the next finer one: whole, or the part in some cells of the tree. For
// the makers of levels alone.
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

// All clusters of a level that some cells hold, consecutive ones. What ties them to each other and
// to the clusters of other cells is given in numbers of the level.
struct ClusterPart
{
  std::span<const ClusterSum> clusters;
  std::span<const std::uint32_t> cellOf; // finest cell of each cluster's lowest original vertex
  VertexId first = 0;                    // the number of the first cluster
  std::span<const Triangle> triangles;   // all that touch one of the clusters, others perhaps
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
// the connected ones join, at most four are left (CellComponents.h), or one without sheets.
// Numbered by (cell, lowest original vertex), added up over children by lowest original vertex.
// parents: of each cluster its place among the coarser ones. REQUIRES: no cell of `depth` is cut.
// O(c log c + t).
CollapseState MakeCoarserClusters(const ClusterPart& below, unsigned depth,
  const ClusterRules& rules, std::vector<VertexId>& parents, const Execution& execution);

// Appends the link that is left of a triangle with exactly two different corners. A link is mapped
// as such a triangle.
inline void AppendLinkOf(const Triangle& t, std::vector<Link>& links)
{
  const VertexId other = t[0] == t[1] ? t[2] : t[1];
  if (t[0] != other && (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]))
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

// What is linked where a map takes the corners of triangles and of links. O(l log l).
std::vector<Link> ImageOfLinks(
  std::span<const Triangle> triangles, std::span<const Link> links, std::span<const VertexId> map);

// The levels `depth` … coarsestDepth from the first of them: all of its clusters and triangles, and
// its links; [depth], without attributes. Errors: Cancelled.
Result<std::vector<ClusterLevel>> BuildCoarserClusterLevels(CollapseState state,
  std::vector<Link> links, unsigned depth, const ClusterRules& rules, const Execution& execution);

}
