// SPDX-License-Identifier: BSD-3-Clause
// Levels by edge collapse: see CollapseLevels.h.
//   1. The finest level (FinestClusters.h), and the means of its vertex colours and normals.
//   2. For each coarser level: collapse in parts (CollapseRound.h), or freely for the coarsest
//      levels (FreeCollapse.h).
//   3. Group clusters without triangles, and the clusters of nodes that are too full (Merging.h).
//   4. Number the new clusters, sum up their children (CoarserState.h), and make the image of the
//      triangles.
#include "filters/core/levels/CollapseLevels.h"

#include "filters/core/levels/CoarserState.h"
#include "filters/core/levels/CollapseRound.h"
#include "filters/core/levels/FinestClusters.h"
#include "filters/core/levels/FoldOverRepair.h"
#include "filters/core/levels/FreeCollapse.h"
#include "filters/core/levels/LevelProgress.h"

#include <algorithm>
#include <numeric>

namespace kdstream
{
namespace
{

// A level in memory: one block, without ghosts.
class WholeLevel : public LevelBlocks
{
public:
  explicit WholeLevel(const CollapseState& state)
    : State(state)
    , Area(AddAreas(0, state.clusters) / double(state.clusters.size()))
  {
  }

  std::size_t Count() const override { return 1; }
  double AreaPerCluster() const override { return this->Area; }
  Result<const CollapseState*> Load(std::size_t) override { return &this->State; }
  Status KeepLists(std::size_t, std::vector<MergeList>&& lists) override
  {
    this->Kept = std::move(lists);
    return {};
  }
  Result<std::vector<MergeList>*> Lists(std::size_t) override { return &this->Kept; }
  Status KeepTargets(std::size_t, TargetStage, std::span<const VertexId>) override { return {}; }
  Result<std::vector<VertexId>> GhostTargets(TargetStage) override
  {
    return std::vector<VertexId>{};
  }
  Status KeepCoarser(std::size_t, CollapseState&& coarser, std::vector<VertexId>&& parents) override
  {
    this->Coarser = std::move(coarser);
    this->Parents = std::move(parents);
    return {};
  }

  CollapseState Coarser;
  std::vector<VertexId> Parents;

private:
  const CollapseState& State;
  double Area;
  std::vector<MergeList> Kept;
};

// Reports that all levels down to `depth` are made; a fraction of `depth` counts part of the next
// level.
Status ReportDepth(const Execution& execution, double depth, unsigned finest)
{
  return execution.Report(
    "levels", finestMadePart + (1 - finestMadePart) * CoarserPart(depth, finest));
}

// Makes levels one after the other, each from the state of the one below.
class CollapseBuilder
{
public:
  CollapseBuilder(const TreeDepths& depths, const Box& box, const LevelOptions& options,
    SumsAside& aside, const Execution& execution)
    : Depths(depths)
    , Options(options)
    , Aside(aside)
    , Exec(execution)
    , Space{ CentreOf(box), box }
  {
  }

  // Makes the state of level L. clusterOf: gets the cluster of each original vertex.
  Result<CollapseState> BuildFinest(const Mesh& mesh, const KdTree& tree,
    const TriangleBuckets& partitionTriangles, std::vector<VertexId>& clusterOf)
  {
    LevelOptions joined = this->Options;
    joined.joinCoincident = true;
    Result<FinestClusters> finest =
      BuildFinestClusters({ mesh.points, mesh.triangles, tree, partitionTriangles,
                            this->Space.origin, joined.ids, FindVertexColors(mesh.attributes) },
        joined, this->Exec);
    KDSTREAM_TRY(finest);
    CollapseState state;
    state.ownEnd = static_cast<VertexId>(finest->clusters.size());
    state.attributes =
      MeanAttributes(mesh, finest->clusterOf, finest->clusters, DiagonalOf(this->Space.box));
    state.level = std::move(finest->level);
    state.level.vertexColors = MeanVertexColors(mesh, finest->clusterOf, finest->clusters.size());
    state.level.triangles = ImageInPartitions(
      mesh.triangles, partitionTriangles, finest->clusterOf, finest->partitionBegin, this->Exec);
    state.clusters = std::move(finest->clusters);
    state.cellOf = std::move(finest->cellOf);
    clusterOf = std::move(finest->clusterOf);
    this->Repair(state, this->Depths.finest);
    return state;
  }

  // Makes level `depth` from the level below it, whose parents it fills in.
  Result<CollapseState> BuildCoarser(CollapseState& below, unsigned depth) const
  {
    if (!CollapsesInParts(this->Depths, depth, below.clusters.size(), below.level.triangles.size()))
    {
      const Result<Merging> merging = CollapseFreely(below, this->Space, this->Depths, depth,
        SurfaceWanted(depth), this->Options.byComponents, this->Aside);
      KDSTREAM_TRY(merging);
      return this->Finish(below, *merging, depth);
    }
    WholeLevel level(below);
    const std::function<Status(double)> report = [&](double done)
    { return ReportDepth(this->Exec, depth + 1 - done, this->Depths.finest); };
    KDSTREAM_TRY(CollapseRound(level, this->Depths, depth, this->Space,
      this->Options.representative, this->Options.byComponents, this->Exec, report)
                   .Run());
    return this->AddTriangles(below, std::move(level.Coarser), std::move(level.Parents), depth);
  }

  // Makes the levels `depth` … coarsestDepth from the state of level `depth`.
  Result<std::vector<ClusterLevel>> BuildAllCoarser(CollapseState state, unsigned depth) const
  {
    std::vector<ClusterLevel> levels(depth + 1);
    while (depth > this->Options.coarsestDepth)
    {
      KDSTREAM_TRY(ReportDepth(this->Exec, depth, this->Depths.finest));
      Result<CollapseState> coarser = this->BuildCoarser(state, depth - 1);
      KDSTREAM_TRY(coarser);
      levels[depth--] = std::move(state.level);
      state = std::move(*coarser);
    }
    levels[depth] = std::move(state.level);
    return levels;
  }

  // Makes a state that meets the target from the finer one: collapses freely, and groups by the
  // cells of `depth` if edges are not enough. The caller tries smaller and smaller depths.
  CollapseState CollapseTo(
    CollapseState& below, const CollapseTarget& target, unsigned depth, bool byComponents) const
  {
    const std::size_t most = target.points == 0 ? EdgeCollapse::any : target.points;
    const std::size_t loose = this->LooseCells(below, depth);
    FreeCollapse collapse(PartOfWholeLevel(below, this->Space));
    const bool done = collapse.Run(most == EdgeCollapse::any ? most : most - std::min(most, loose),
      target.triangles == 0 ? EdgeCollapse::any : target.triangles);
    Merging merging(below, this->Depths, depth);
    collapse.Apply(merging);
    merging.GroupLoose();
    if (!done)
    {
      merging.GroupNodes(std::vector<std::uint8_t>(merging.NodeCount(), 1), byComponents);
    }
    return this->Finish(below, merging, depth);
  }

private:
  // The number of cells of `depth` that hold clusters without triangles.
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

  CollapseState Finish(CollapseState& below, const Merging& merging, unsigned depth) const
  {
    std::vector<VertexId> parents;
    CollapseState coarser =
      MakeCoarser(below, merging, this->Space, this->Options.representative, parents, this->Exec);
    return this->AddTriangles(below, std::move(coarser), std::move(parents), depth);
  }

  CollapseState AddTriangles(CollapseState& below, CollapseState&& coarser,
    std::vector<VertexId>&& parents, unsigned depth) const
  {
    below.level.parents = std::move(parents);
    coarser.level.triangles =
      ImageOfTriangles(below.level.triangles, below.level.parents, this->Exec);
    this->Repair(coarser, depth);
    return std::move(coarser);
  }

  // Moves clusters in places where triangles face the wrong way (FoldOverRepair.h). depth: of the
  // level.
  void Repair(CollapseState& state, unsigned depth) const
  {
    const BlockParts parts = PartsOfLevel(this->Depths, depth, 0, 0);
    for (const MovedCluster& moved : RepairFoldOvers(state, this->Space, depth, parts, this->Exec))
    {
      state.clusters[moved.cluster].geometricError = moved.geometricError;
      state.level.positions[moved.cluster] = moved.position;
      state.level.geometricErrors[moved.cluster] = moved.geometricError;
    }
  }

  TreeDepths Depths;
  const LevelOptions& Options;
  SumsAside& Aside;
  const Execution& Exec;
  CollapseSpace Space;
};

bool Meets(const ClusterLevel& level, const CollapseTarget& target)
{
  return (target.triangles == 0 || level.triangles.size() <= target.triangles) &&
         (target.points == 0 || level.positions.size() <= target.points);
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
  SumsAside stay;
  CollapseBuilder builder(tree.depths, tree.boxes[1], options, stay, execution);
  ClusterLevels levels;
  Result<CollapseState> finest = builder.BuildFinest(mesh, tree, partitionTriangles, levels.finest);
  KDSTREAM_TRY(finest);
  Result<std::vector<ClusterLevel>> all =
    builder.BuildAllCoarser(std::move(*finest), tree.depths.finest);
  KDSTREAM_TRY(all);
  levels.levels = std::move(*all);
  return levels;
}

Result<std::vector<ClusterLevel>> BuildCoarserLevels(CollapseState state, unsigned depth,
  const TreeDepths& depths, const Box& box, const LevelOptions& options, SumsAside& aside,
  const Execution& execution)
{
  return CollapseBuilder(depths, box, options, aside, execution)
    .BuildAllCoarser(std::move(state), depth);
}

Result<CollapsedMesh> CollapseTo(const Mesh& mesh, const KdTree& tree,
  const TriangleBuckets& partitionTriangles, const LevelOptions& options,
  const CollapseTarget& target, const Execution& execution)
{
  if (target.triangles == 0 && target.points == 0)
  {
    return Error{ ErrorCode::InvalidArgument,
      "the target has 0 triangles and 0 points: one of them must be at least 1" };
  }
  SumsAside stay;
  CollapseBuilder builder(tree.depths, tree.boxes[1], options, stay, execution);
  CollapsedMesh collapsed;
  Result<CollapseState> finest =
    builder.BuildFinest(mesh, tree, partitionTriangles, collapsed.clusterOf);
  KDSTREAM_TRY(finest);
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
    KDSTREAM_TRY(ReportDepth(execution, depth, tree.depths.finest));
    Result<CollapseState> coarser = builder.BuildCoarser(state, depth - 1);
    KDSTREAM_TRY(coarser);
    if (Meets(coarser->level, target))
    {
      break;
    }
    descend(state.level.parents);
    state = std::move(*coarser);
    --depth;
  }
  if (!Meets(state.level, target))
  {
    CollapseState last = builder.CollapseTo(state, target, depth, options.byComponents);
    for (; !Meets(last.level, target) && depth > 0; --depth)
    {
      last = builder.CollapseTo(state, target, depth - 1, options.byComponents);
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
