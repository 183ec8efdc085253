// The clusters of the finest level, where every maker of levels starts. For the makers of levels
// alone.
#pragma once

#include "filters/core/ClusterSum.h"
#include "filters/core/KdTree.h"
#include "filters/core/TriangleBuckets.h"

#include <span>
#include <vector>

namespace kdstream
{

struct FinestClusters
{
  Vec3 origin{};                     // of the sums: the centre of the model's box
  std::vector<VertexId> clusterOf;   // of each original vertex
  std::vector<ClusterSum> clusters;  // ordered by (cell, lowest original vertex)
  std::vector<std::uint32_t> cellOf; // of each cluster
  std::vector<Link> coincident;      // vertices in the same place but not in the same cell
  ClusterLevel level;                // its parents are left empty
};

// Fills a level's positions, deviations and lowest vertices from its clusters, and raises the
// clusters' deviations to their own where the children's are below it.
void RepresentClusters(std::vector<ClusterSum>& clusters, Representative representative,
  const Vec3& origin, ClusterLevel& level, const Execution& execution);

// Makes the clusters of level L of the tree. Input, sums, complexity and errors: see
// BuildClusterLevels, whose first half of the progress it reports.
Result<FinestClusters> BuildFinestClusters(std::span<const Vec3> points,
  std::span<const Triangle> triangles, const KdTree& tree,
  const TriangleBuckets& partitionTriangles, const ClusterOptions& options,
  const Execution& execution);

}
