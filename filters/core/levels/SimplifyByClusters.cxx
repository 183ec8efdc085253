// SPDX-License-Identifier: BSD-3-Clause
#include "filters/core/levels/SimplifyByClusters.h"

#include "filters/core/TriangleBuckets.h"
#include "filters/core/levels/LevelAttributes.h"
#include "filters/core/tree/KdTree.h"

#include <utility>

namespace kdstream
{

Result<ClusterLevel> SimplifyByClusters(const Mesh& mesh, const Clustering& clustering,
  const ClusterOptions& options, const Execution& execution, std::vector<VertexId>* clusterOf)
{
  KDSTREAM_TRY(CheckClustering(mesh.points.size(), clustering));
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
