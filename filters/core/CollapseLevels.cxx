// Levels by edge collapse: see CollapseLevels.h.
//   1. The finest level (FinestClusters.h), and the means of its colours and normals.
//   2. For each coarser level: collapse in partitions down to S, freely below (CollapseRound.h).
//   3. Group what has no triangles, and the clusters of nodes that are too full (Merging.h).
//   4. Number the new clusters, add up what they are made of; the triangles' image.
#include "filters/core/CollapseLevels.h"

#include "filters/core/CollapseRound.h"
#include "filters/core/FinestClusters.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace kdstream
{
namespace
{

constexpr std::size_t grain = 1 << 14;
constexpr std::size_t mostExtra = 32; // clusters of coarse levels; measured

// Makes levels one after the other, each from the state of the one below.
class CollapseBuilder
{
public:
  CollapseBuilder(const KdTree& tree, const LevelOptions& options, const Execution& execution)
    : Depths(tree.depths)
    , Options(options)
    , Exec(execution)
  {
    this->Space.box = tree.boxes[1];
  }

  // The state of level L; for each original vertex its cluster.
  Result<CollapseState> BuildFinest(const Mesh& mesh, const KdTree& tree,
    const TriangleBuckets& partitionTriangles, std::vector<VertexId>& clusterOf)
  {
    Result<FinestClusters> finest = BuildFinestClusters(
      mesh.points, mesh.triangles, tree, partitionTriangles, this->Options, this->Exec);
    if (!finest)
    {
      return finest.GetError();
    }
    this->Space.origin = finest->origin;
    const Vec3 size{ this->Space.box.hi[0] - this->Space.box.lo[0],
      this->Space.box.hi[1] - this->Space.box.lo[1],
      this->Space.box.hi[2] - this->Space.box.lo[2] };
    const double diagonal = std::sqrt(size[0] * size[0] + size[1] * size[1] + size[2] * size[2]);
    CollapseState state;
    state.attributes = MeanAttributes(mesh, finest->clusterOf, finest->clusters, diagonal);
    state.level = std::move(finest->level);
    state.clusters = std::move(finest->clusters);
    state.cellOf = std::move(finest->cellOf);
    clusterOf = std::move(finest->clusterOf);
    return state;
  }

  // Level `depth` from the one below it, whose parents are filled.
  CollapseState BuildCoarser(CollapseState& below, unsigned depth) const
  {
    Merging merging = depth >= this->Depths.stitch ? this->CollapseInPartitions(below, depth)
                                                   : this->CollapseFreely(below, depth);
    const std::vector<std::size_t> excess = merging.ExcessOfNodes();
    std::vector<std::uint8_t> full(excess.size());
    std::transform(excess.begin(), excess.end(), full.begin(),
      [](std::size_t count) { return static_cast<std::uint8_t>(count > 0); });
    if (std::find(full.begin(), full.end(), 1) != full.end())
    {
      merging.GroupNodes(full, this->Options.sheets);
      merging.GroupLoose(); // what has lost its last triangles by that
    }
    return this->Finish(below, merging);
  }

  // A state from the one below it that meets the target, collapsed freely; grouped by the cells of
  // `depth` where edges do not do it. The caller tries ever smaller depths.
  CollapseState CollapseTo(
    CollapseState& below, const CollapseTarget& target, unsigned depth, bool sheets) const
  {
    const std::size_t most = target.points == 0 ? EdgeCollapse::any : target.points;
    const std::size_t loose = this->LooseCells(below, depth);
    FreeCollapse collapse(below, this->Space);
    const bool done = collapse.Run(most == EdgeCollapse::any ? most : most - std::min(most, loose),
      target.triangles == 0 ? EdgeCollapse::any : target.triangles);
    Merging merging(below, this->Depths, depth);
    collapse.Apply(merging);
    merging.GroupLoose();
    if (!done)
    {
      merging.GroupNodes(std::vector<std::uint8_t>(merging.NodeCount(), 1), sheets);
    }
    return this->Finish(below, merging);
  }

private:
  Merging CollapseInPartitions(const CollapseState& below, unsigned depth) const
  {
    std::vector<std::uint32_t> partitionOf(below.cellOf.size());
    std::transform(below.cellOf.begin(), below.cellOf.end(), partitionOf.begin(),
      [&](std::uint32_t cell) { return cell >> (this->Depths.finest - this->Depths.partition); });
    PartitionCollapse collapse(below, this->Space, partitionOf,
      std::size_t{ 1 } << this->Depths.partition, SurfaceWanted(depth), this->Exec);
    collapse.TakeUntil();
    const auto merge = [&]
    {
      Merging merging(below, this->Depths, depth);
      collapse.Apply(merging);
      merging.GroupLoose();
      return merging;
    };
    Merging merging = merge();
    // Nodes that would hold too much have a larger threshold of their own.
    const std::vector<std::size_t> excess = merging.ExcessOfNodes();
    const std::size_t partitions = (std::size_t{ 1 } << this->Depths.partition) / excess.size();
    bool more = false;
    for (std::size_t node = 0; node < excess.size(); ++node)
    {
      more |= excess[node] > 0 &&
              collapse.TakeMore(excess[node], node * partitions, (node + 1) * partitions);
    }
    return more ? merge() : merging;
  }

  Merging CollapseFreely(const CollapseState& below, unsigned depth) const
  {
    FreeCollapse collapse(below, this->Space);
    bool more = collapse.Run(SurfaceWanted(depth), EdgeCollapse::any);
    for (;;)
    {
      Merging merging(below, this->Depths, depth);
      collapse.Apply(merging);
      merging.GroupLoose();
      // Nodes that would hold too much go on alone.
      const std::vector<std::size_t> excess = merging.ExcessOfNodes();
      const std::size_t total = std::accumulate(excess.begin(), excess.end(), std::size_t{ 0 });
      if (total == 0 || !more || collapse.VertexCount() == 0)
      {
        return merging;
      }
      collapse.Restrict(
        [&](VertexId v) { return excess[merging.NodeOf(merging.StandsFor(v))] > 0; });
      more = collapse.Run(
        collapse.VertexCount() - std::min(collapse.VertexCount(), total), EdgeCollapse::any);
    }
  }

  // Cells of a depth that hold clusters which no triangle touches.
  std::size_t LooseCells(const CollapseState& below, unsigned depth) const
  {
    std::vector<std::uint8_t> touched(below.clusters.size(), 0);
    for (const Triangle& t : below.level.triangles)
    {
      touched[t[0]] = touched[t[1]] = touched[t[2]] = 1;
    }
    std::vector<std::uint32_t> cells;
    for (std::size_t c = 0; c < touched.size(); ++c)
    {
      if (!touched[c])
      {
        cells.push_back(below.cellOf[c] >> (this->Depths.finest - depth));
      }
    }
    std::sort(cells.begin(), cells.end());
    return static_cast<std::size_t>(std::unique(cells.begin(), cells.end()) - cells.begin());
  }

  // Clusters with triangles that level `depth` is to have: some more where they are few, or limbs
  // are lost. Those without triangles come on top of them.
  static std::size_t SurfaceWanted(unsigned depth)
  {
    const std::size_t all = std::size_t{ 1 } << depth;
    return all + std::min(all, mostExtra);
  }

  CollapseState Finish(CollapseState& below, const Merging& merging) const
  {
    CollapseState state;
    const std::vector<VertexId> standing = merging.Standing();
    std::vector<VertexId> number(below.clusters.size());
    for (std::size_t i = 0; i < standing.size(); ++i)
    {
      number[standing[i]] = static_cast<VertexId>(i);
      state.cellOf.push_back(merging.FinestCellOf(standing[i]));
    }
    std::vector<VertexId>& parents = below.level.parents;
    parents.resize(number.size());
    state.clusters.resize(standing.size());
    for (VertexId c = 0; c < parents.size(); ++c)
    {
      parents[c] = number[merging.StandsFor(c)];
      state.clusters[parents[c]].Add(below.clusters[c]);
    }
    this->Place(below, merging, standing, state);
    state.attributes =
      MeanOverChildren(below.attributes, below.clusters, parents, state.clusters.size());
    state.level.triangles = ImageOfTriangles(below.level.triangles, parents, this->Exec);
    return state;
  }

  // Positions, deviations and lowest vertices.
  void Place(const CollapseState& below, const Merging& merging,
    const std::vector<VertexId>& standing, CollapseState& state) const
  {
    ClusterLevel& level = state.level;
    level.positions.resize(standing.size());
    level.deviations.resize(standing.size());
    level.lowest.resize(standing.size());
    this->Exec.parallelFor(standing.size(), grain,
      [&](std::size_t begin, std::size_t end)
      {
        for (std::size_t i = begin; i < end; ++i)
        {
          ClusterSum& cluster = state.clusters[i];
          const VertexId c = standing[i];
          switch (merging.PositionOf(c))
          {
            case Merging::Position::Kept:
              level.positions[i] = below.level.positions[c];
              break;
            case Merging::Position::Moved:
              level.positions[i] = this->Space.Absolute(merging.MovedTo(c));
              break;
            case Merging::Position::Grouped:
              level.positions[i] =
                cluster.Represent(this->Options.representative, this->Space.origin);
              break;
          }
          cluster.deviation = std::max(
            cluster.deviation, cluster.DeviationAt(this->Space.Relative(level.positions[i])));
          level.deviations[i] = cluster.deviation;
          level.lowest[i] = cluster.lowest;
        }
      });
  }

  TreeDepths Depths;
  const LevelOptions& Options;
  const Execution& Exec;
  CollapseSpace Space;
};

bool Meets(const ClusterLevel& level, const CollapseTarget& target)
{
  return (target.triangles == 0 || level.triangles.size() <= target.triangles) &&
         (target.points == 0 || level.positions.size() <= target.points);
}

Status ReportDepth(const Execution& execution, unsigned depth, unsigned finest)
{
  const double done = 1.0 - double(depth + 1) / double(finest + 1);
  return execution.Report("levels", 0.5 + 0.5 * done);
}

}

Result<ClusterLevels> BuildCollapseLevels(const Mesh& mesh, const KdTree& tree,
  const TriangleBuckets& partitionTriangles, const LevelOptions& options,
  const Execution& execution)
{
  if (mesh.triangles.empty())
  {
    return BuildClusterLevels(
      mesh.points, mesh.triangles, tree, partitionTriangles, options, execution);
  }
  CollapseBuilder builder(tree, options, execution);
  ClusterLevels levels;
  Result<CollapseState> finest = builder.BuildFinest(mesh, tree, partitionTriangles, levels.finest);
  if (!finest)
  {
    return finest.GetError();
  }
  levels.levels.resize(tree.depths.finest + 1);
  CollapseState state = std::move(*finest);
  for (unsigned depth = tree.depths.finest; depth-- > options.coarsestDepth;)
  {
    if (Status status = ReportDepth(execution, depth, tree.depths.finest); !status)
    {
      return status.GetError();
    }
    CollapseState coarser = builder.BuildCoarser(state, depth);
    levels.levels[depth + 1] = std::move(state.level);
    state = std::move(coarser);
  }
  levels.levels[std::min(options.coarsestDepth, tree.depths.finest)] = std::move(state.level);
  return levels;
}

Result<CollapsedMesh> CollapseTo(const Mesh& mesh, const KdTree& tree,
  const TriangleBuckets& partitionTriangles, const LevelOptions& options,
  const CollapseTarget& target, const Execution& execution)
{
  if (target.triangles == 0 && target.points == 0)
  {
    return Error{ ErrorCode::InvalidArgument,
      "a target of 0 triangles and 0 points: one of them must be at least 1" };
  }
  CollapseBuilder builder(tree, options, execution);
  CollapsedMesh collapsed;
  Result<CollapseState> finest =
    builder.BuildFinest(mesh, tree, partitionTriangles, collapsed.clusterOf);
  if (!finest)
  {
    return finest.GetError();
  }
  const auto descend = [&](const std::vector<VertexId>& parents)
  {
    for (VertexId& cluster : collapsed.clusterOf)
    {
      cluster = parents[cluster];
    }
  };
  CollapseState state = std::move(*finest);
  unsigned depth = tree.depths.finest;
  while (depth > 0 && !Meets(state.level, target))
  {
    if (Status status = ReportDepth(execution, depth, tree.depths.finest); !status)
    {
      return status.GetError();
    }
    CollapseState coarser = builder.BuildCoarser(state, depth - 1);
    if (Meets(coarser.level, target))
    {
      break;
    }
    descend(state.level.parents);
    state = std::move(coarser);
    --depth;
  }
  if (!Meets(state.level, target))
  {
    CollapseState last = builder.CollapseTo(state, target, depth, options.sheets);
    for (; !Meets(last.level, target) && depth > 0; --depth)
    {
      last = builder.CollapseTo(state, target, depth - 1, options.sheets);
    }
    if (!Meets(last.level, target))
    {
      last = builder.CollapseTo(state, target, 0, false);
    }
    descend(state.level.parents);
    state = std::move(last);
  }
  state.level.parents.clear();
  collapsed.level = std::move(state.level);
  return collapsed;
}

}
