// SPDX-License-Identifier: BSD-3-Clause
#include "filters/core/tree/Clustering.h"

#include <algorithm>
#include <numeric>
#include <string>

namespace kdstream
{

Status CheckClustering(std::size_t vertices, const Clustering& clustering)
{
  if (clustering.clusterOf.size() != vertices)
  {
    return Error{ ErrorCode::InvalidArgument, std::to_string(clustering.clusterOf.size()) +
                                                " cluster ids for " + std::to_string(vertices) +
                                                " vertices" };
  }
  const auto beyond = std::find_if(clustering.clusterOf.begin(), clustering.clusterOf.end(),
    [&](std::uint32_t c) { return c >= clustering.clusters; });
  if (beyond != clustering.clusterOf.end())
  {
    return Error{ ErrorCode::InvalidArgument,
      "vertex " + std::to_string(beyond - clustering.clusterOf.begin()) + " is in cluster " +
        std::to_string(*beyond) + " of " + std::to_string(clustering.clusters) };
  }
  return {};
}

Clustering ClusteringOfLabels(std::span<const std::int64_t> labels)
{
  std::vector<std::int64_t> distinct(labels.begin(), labels.end());
  std::sort(distinct.begin(), distinct.end());
  distinct.erase(std::unique(distinct.begin(), distinct.end()), distinct.end());
  Clustering clustering;
  clustering.clusters = static_cast<std::uint32_t>(distinct.size());
  clustering.clusterOf.reserve(labels.size());
  for (const std::int64_t label : labels)
  {
    const auto found = std::lower_bound(distinct.begin(), distinct.end(), label);
    clustering.clusterOf.push_back(static_cast<std::uint32_t>(found - distinct.begin()));
  }
  return clustering;
}

TreeDepths DepthsOfClusters(std::uint64_t clusters)
{
  unsigned depth = 0;
  while (std::uint64_t{ 1 } << depth < clusters)
  {
    ++depth;
  }
  return { depth, depth, depth };
}

void AddBoxesAbove(std::span<Box> boxes)
{
  for (std::size_t node = boxes.size() / 2; node-- > 1;)
  {
    boxes[node].Add(boxes[2 * node]);
    boxes[node].Add(boxes[2 * node + 1]);
  }
}

KdTree TreeOfClustering(std::span<const Vec3> points, const Clustering& clustering)
{
  KdTree tree;
  tree.depths = DepthsOfClusters(clustering.clusters);
  const std::size_t cells = std::size_t{ 1 } << tree.depths.partition;
  tree.cellBegin.assign(cells + 1, 0);
  for (const std::uint32_t c : clustering.clusterOf)
  {
    ++tree.cellBegin[c + 1];
  }
  std::partial_sum(tree.cellBegin.begin(), tree.cellBegin.end(), tree.cellBegin.begin());
  tree.order.resize(points.size());
  tree.boxes.resize(2 * cells);
  std::vector<VertexId> next = tree.cellBegin;
  for (std::size_t v = 0; v < points.size(); ++v)
  {
    const std::uint32_t c = clustering.clusterOf[v];
    tree.order[next[c]++] = static_cast<VertexId>(v);
    tree.boxes[cells + c].Add(points[v]);
  }
  AddBoxesAbove(tree.boxes);
  return tree;
}

}
