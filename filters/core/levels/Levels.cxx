// SPDX-License-Identifier: BSD-3-Clause
#include "filters/core/levels/Levels.h"

#include "filters/core/levels/CollapseLevels.h"
#include "filters/core/levels/LevelAttributes.h"

namespace kdstream
{

Result<ClusterLevels> BuildLevels(const Mesh& mesh, const KdTree& tree,
  const TriangleBuckets& partitionTriangles, const LevelOptions& options,
  const Execution& execution)
{
  Result<ClusterLevels> levels =
    options.maker == LevelMaker::Collapse
      ? BuildCollapseLevels(mesh, tree, partitionTriangles, options, execution)
      : BuildClusterLevels(
          mesh.points, mesh.triangles, tree, partitionTriangles, options, execution);
  if (levels)
  {
    AddLevelAttributes(mesh, *levels);
  }
  return levels;
}

}
