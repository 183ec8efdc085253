// SPDX-License-Identifier: BSD-3-Clause
#include "filters/core/levels/SimplifyByClusters.h"

#include "filters/core/TriangleBuckets.h"
#include "filters/core/levels/LevelAttributes.h"
#include "filters/core/tree/KdTree.h"

#include <algorithm>
#include <string>
#include <utility>

namespace kdstream
{

Result<ClusterLevel> SimplifyByClusters(const Mesh& mesh, const Clustering& clustering,
  const ClusterOptions& options, const Execution& execution, std::vector<VertexId>* clusterOf)
{
  if (clustering.clusterOf.size() != mesh.points.size())
  {
    return Error{ ErrorCode::InvalidArgument, std::to_string(clustering.clusterOf.size()) +
                                                " cluster ids for " +
                                                std::to_string(mesh.points.size()) + " vertices" };
  }
  const auto beyond = std::find_if(clustering.clusterOf.begin(), clustering.clusterOf.end(),
    [&](std::uint32_t c) { return c >= clustering.clusters; });
  if (beyond != clustering.clusterOf.end())
  {
    return Error{ ErrorCode::InvalidArgument,
      "vertex " + std::to_string(beyond - clustering.clusterOf.begin()) + " is in cluster " +
        std::to_string(*beyond) + " of " + std::to_string(clustering.clusters) };
  }
  if (mesh.points.empty())
  {
    return ClusterLevel{};
  }
  const KdTree tree = TreeOfClustering(mesh.points, clustering);
  const TriangleBuckets buckets = BucketTriangles(mesh.triangles,
    std::size_t{ 1 } << tree.depths.partition, [&](VertexId v) { return clustering.clusterOf[v]; });
  ClusterOptions finestOnly = options;
  finestOnly.coarsestDepth = tree.depths.finest;
  Result<ClusterLevels> levels =
    BuildClusterLevels(mesh.points, mesh.triangles, tree, buckets, finestOnly, execution);
  KDSTREAM_TRY(levels);
  AddLevelAttributes(mesh, *levels);
  if (clusterOf)
  {
    *clusterOf = std::move(levels->finest);
  }
  return std::move(levels->levels.back());
}

}
