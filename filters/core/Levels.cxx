#include "filters/core/Levels.h"

namespace kdstream
{

Result<ClusterLevels> BuildLevels(const Mesh& mesh, const KdTree& tree,
  const TriangleBuckets& partitionTriangles, const LevelOptions& options,
  const Execution& execution)
{
  return BuildClusterLevels(
    mesh.points, mesh.triangles, tree, partitionTriangles, options, execution);
}

}
