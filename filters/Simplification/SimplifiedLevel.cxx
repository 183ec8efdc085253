// SPDX-License-Identifier: BSD-3-Clause
#include "filters/Simplification/SimplifiedLevel.h"

#include "filters/core/levels/CollapseLevels.h"
#include "filters/core/levels/LevelAttributes.h"

#include <string>

namespace kdstream
{
namespace
{

// The depth of the level whose number of triangles (or of points, for a cloud) is nearest to the
// target.
std::size_t NearestLevel(const ClusterLevels& levels, std::size_t target, bool cloud)
{
  std::size_t best = 0;
  std::size_t least = 0;
  for (std::size_t d = 0; d < levels.levels.size(); ++d)
  {
    const ClusterLevel& level = levels.levels[d];
    const std::size_t count = cloud ? level.positions.size() : level.triangles.size();
    const std::size_t off = count > target ? count - target : target - count;
    if (d == 0 || off < least)
    {
      best = d;
      least = off;
    }
  }
  return best;
}

SimplifiedLevel TakeLevel(ClusterLevels&& levels, std::size_t depth)
{
  SimplifiedLevel taken{ {}, std::move(levels.finest) };
  for (std::size_t d = levels.levels.size() - 1; d > depth; --d)
  {
    for (VertexId& cluster : taken.clusterOf)
    {
      cluster = levels.levels[d].parents[cluster];
    }
  }
  taken.level = std::move(levels.levels[depth]);
  return taken;
}

Result<SimplifiedLevel> CollapseToTarget(const Mesh& mesh, const KdTree& tree,
  const TriangleBuckets& buckets, const SimplificationOptions& options, const Execution& execution)
{
  Result<CollapsedMesh> collapsed =
    CollapseTo(mesh, tree, buckets, options.levels, { options.target, 0 }, execution);
  KDSTREAM_TRY(collapsed);
  ClusterLevels one;
  one.finest = std::move(collapsed->clusterOf);
  one.levels.push_back(std::move(collapsed->level));
  AddLevelAttributes(mesh, one);
  return TakeLevel(std::move(one), 0);
}

Result<SimplifiedLevel> MakeLevel(const Mesh& mesh, const KdTree& tree,
  const TriangleBuckets& buckets, const SimplificationOptions& options, const Execution& execution)
{
  const bool cloud = mesh.triangles.empty();
  if (options.target > 0 && options.levels.maker == LevelMaker::Collapse && !cloud)
  {
    return CollapseToTarget(mesh, tree, buckets, options, execution);
  }
  LevelOptions levelOptions = options.levels;
  levelOptions.coarsestDepth = options.target > 0 ? 0 : options.depth.value_or(tree.depths.finest);
  Result<ClusterLevels> levels = BuildLevels(mesh, tree, buckets, levelOptions, execution);
  KDSTREAM_TRY(levels);
  const std::size_t depth =
    options.target > 0 ? NearestLevel(*levels, options.target, cloud) : levelOptions.coarsestDepth;
  return TakeLevel(std::move(*levels), depth);
}

}

Result<SimplifiedLevel> SimplifyMesh(
  const Mesh& mesh, const SimplificationOptions& options, const Execution& execution)
{
  const Result<TreeDepths> depths = ComputeDepths(mesh.points.size(), options.tree);
  KDSTREAM_TRY(depths);
  if (options.target == 0 && options.depth.value_or(0) > depths->finest)
  {
    return Error{ ErrorCode::InvalidArgument, "Depth " + std::to_string(*options.depth) +
                                                " is below the finest level of this input, at "
                                                "depth " +
                                                std::to_string(depths->finest) };
  }
  const Result<KdTree> tree = BuildKdTree(mesh.points, options.tree, execution);
  KDSTREAM_TRY(tree);
  const std::vector<std::uint32_t> partition = CellOfVertex(*tree, depths->partition);
  const TriangleBuckets buckets = BucketTriangles(mesh.triangles,
    std::size_t{ 1 } << depths->partition, [&](VertexId v) { return partition[v]; });
  Result<SimplifiedLevel> level = MakeLevel(mesh, *tree, buckets, options, execution);
  KDSTREAM_TRY(level);
  level->finestDepth = depths->finest;
  return level;
}

}
