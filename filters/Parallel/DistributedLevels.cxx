// SPDX-License-Identifier: BSD-3-Clause
// The levels on several ranks: see DistributedLevels.h. The steps that levels of one process share
// are in LevelSteps.h.
//   1. Build the finest level, each rank in its own blocks (FinestClusters.h).
//   2. Go from level to level in rounds (CollapseRound.h, ClusterRound.h). Between the passes of a
//      round the ranks exchange the costs in parts of the level, and the targets of clusters that
//      other ranks use.
//   3. Build the coarse levels on rank 0.
// Clusters of a level are numbered over all ranks. A rank's first number is known only when all
// ranks have made their clusters. Until then a rank counts from the number of its first finer
// element, which leaves enough room (DistributedLevelFiles::Settle).
#include "filters/Parallel/DistributedLevels.h"

#include "filters/Parallel/DistributedCoincidence.h"
#include "filters/Parallel/DistributedImages.h"
#include "filters/Parallel/DistributedLevelBlocks.h"
#include "filters/Parallel/DistributedLevelFiles.h"
#include "filters/core/TakeResult.h"
#include "filters/outofcore/files/LoadAhead.h"
#include "filters/outofcore/files/RecordFile.h"
#include "filters/outofcore/files/ReturnFreeMemory.h"
#include "filters/outofcore/levels/LevelSteps.h"

#include <algorithm>
#include <utility>

namespace kdstream
{
namespace
{

class DistributedLevelsBuilder
{
public:
  DistributedLevelsBuilder(MpiGroup& group, SpillFolder& folder, const MeshBlocks& mesh,
    const LevelOptions& options, std::uint64_t memory, const Execution& execution,
    const std::function<void(const TreeBlock&)>& seen)
    : Group(group)
    , Folder(folder)
    , Mesh(mesh)
    , Memory(memory)
    , Exec(execution)
    , Seen(seen)
    , Steps(mesh, options, execution)
    , Files(group, folder, this->Steps.Arrays(), this->Steps.ByClusters())
  {
    this->Output.attributes = this->Steps.Arrays().attributes;
    this->Output.files.resize(mesh.depths.finest + 1);
  }

  Result<ExternalLevels> Build()
  {
    KDSTREAM_TRY(this->BuildFinest());
    KDSTREAM_TRY(this->MapFinestTriangles());
    unsigned depth = this->Mesh.depths.finest;
    while (this->Steps.IsCoarserInFiles(this->FileOf(depth), this->States))
    {
      KDSTREAM_TRY(this->BuildCoarser(--depth));
    }
    // The parents of the last level are not known yet.
    LevelFile& last = this->FileOf(depth);
    KDSTREAM_TRY(this->Files.MoveToFirst(last, this->States, this->Links));
    this->Output.firstInFiles = depth;
    if (this->Group.IsFirst())
    {
      KDSTREAM_TRY(
        Take(this->Steps.BuildCoarse(this->Folder, last, std::move(this->States), this->Links),
          this->Output.coarse));
    }
    return std::move(this->Output);
  }

private:
  LevelFile& FileOf(unsigned depth) { return this->Output.files[depth]; }
  LevelLinks* LinksIfAny() { return this->Steps.ByClusters() ? &this->Links : nullptr; }

  // Builds the finest clusters, each rank in its blocks of the mesh; not yet their triangles.
  Status BuildFinest()
  {
    LevelFile& level = this->FileOf(this->Mesh.depths.finest);
    level.depth = this->Mesh.depths.finest;
    LevelWriter writer(level, this->States, this->Steps.Arrays());
    KDSTREAM_TRY(writer.Begin(this->Folder, 0));
    SpillFile& clusterOfRank = this->Output.clusterOfRank;
    KDSTREAM_TRY(Take(this->Folder.CreateFile("clusters of vertices", 0), clusterOfRank));
    const BlockRange here = this->Group.Here(this->Mesh.blockDepth);
    const CellRange vertices =
      this->Files.RangeHere(this->Mesh.BlockBegins(), this->Mesh.blockDepth);
    level.begin.assign(here.begin + 1, static_cast<VertexId>(vertices.begin));
    const double blocks = double(here.end - here.begin);
    const auto load = [&](std::size_t index) { return this->Mesh.Load(here.begin + index); };
    const auto build = [&](const TreeBlock& block) -> Status
    {
      this->Seen(block);
      const Status built =
        this->Steps.BuildFinestBlock(block, level.begin.back(), clusterOfRank, writer);
      ReturnFreeMemory(this->Mesh.keptMemory);
      KDSTREAM_TRY(built);
      return this->Steps.ReportFinest(double(block.cell + 1 - here.begin) / blocks);
    };
    KDSTREAM_TRY(ForEachLoaded(here.end - here.begin, load, build, this->Exec));
    level.blockDepth = this->Mesh.blockDepth;
    return this->Files.Settle(level, this->States, clusterOfRank, vertices);
  }

  // Makes the triangles of the finest level: the images of the mesh's triangles.
  Status MapFinestTriangles()
  {
    LevelFile& level = this->FileOf(this->Mesh.depths.finest);
    KDSTREAM_TRY(this->Files.MakeBlocks(
      level, this->States, this->Steps.BlockDepthOf(level.depth, this->Mesh.blockDepth)));
    DistributedCoincidence links;
    if (this->Steps.LinksCoincident())
    {
      KDSTREAM_TRY(Take(
        LinkCoincidentCollectively(this->Group, this->Folder, this->Mesh, this->Memory), links));
    }
    std::vector<VertexId> wanted = this->Mesh.foreign;
    wanted.insert(wanted.end(), links.foreign.begin(), links.foreign.end());
    const std::vector<VertexId> begins = this->Mesh.BlockBegins();
    KDSTREAM_TRY(this->Group.Fetch(
      this->Output.clusterOfRank, sizeof(VertexId), begins, this->Mesh.blockDepth, wanted));
    const auto load = [&](std::size_t block, std::vector<Triangle>& triangles) -> Status
    {
      KDSTREAM_TRY(this->Mesh.triangles->ForEach(block,
        [&](const NumberedTriangle& t) -> Status
        {
          triangles.push_back(t.corners);
          return {};
        }));
      return links.Load(block, triangles);
    };
    return this->WriteImages(
      { load, this->Output.clusterOfRank, begins, this->Mesh.blockDepth }, level);
  }

  Status WriteImages(const FinerTriangles& finer, LevelFile& level)
  {
    KDSTREAM_TRY(Take(WriteDistributedImages(
                        this->Group, this->Folder, finer, this->Memory, level, this->LinksIfAny()),
      this->States.triangles));
    KDSTREAM_TRY(FetchForeignClusters(
      this->Group, this->Steps.Arrays().TupleBytes(), level, this->LinksIfAny()));
    return this->Steps.ByClusters() ? Status{} : this->RepairFoldOvers(level);
  }

  // Each rank repairs its own clusters. Meanwhile clusters of other ranks stay at their original
  // places.
  Status RepairFoldOvers(LevelFile& level)
  {
    KDSTREAM_TRY(this->Steps.RepairFoldOvers(
      this->Folder, level, this->States, this->Group.Here(level.blockDepth)));
    return this->Group.Fetch(
      level.clusters, sizeof(ClusterRecord), level.begin, level.blockDepth, level.foreign);
  }

  // Builds level `depth` from the next finer one.
  Status BuildCoarser(unsigned depth)
  {
    LevelFile& below = this->FileOf(depth + 1);
    LevelFile& level = this->FileOf(depth);
    level.depth = depth;
    LevelStates states;
    const CellRange belowHere = this->Files.RangeHere(below.begin, below.blockDepth);
    KDSTREAM_TRY(this->MakeClusters(below, depth, states));
    level.blockDepth = below.blockDepth;
    KDSTREAM_TRY(this->Files.Settle(level, states, below.parents, belowHere));
    this->States = std::move(states);
    KDSTREAM_TRY(this->Files.MakeBlocks(
      level, this->States, std::min(below.blockDepth, this->Steps.BlockDepthOf(depth, 62))));
    KDSTREAM_TRY(this->MapTriangles(below, level));
    // No coarser level needs the finer level any more.
    return depth < this->Mesh.depths.stitch
             ? this->Files.MoveToFirst(below, this->States, this->Links)
             : Status{};
  }

  Status MakeClusters(LevelFile& below, unsigned depth, LevelStates& states)
  {
    LevelFile& level = this->FileOf(depth);
    const LevelArrays& arrays = this->Steps.Arrays();
    LevelWriter writer(level, states, arrays);
    KDSTREAM_TRY(writer.Begin(this->Folder, 0));
    const BlockRange here = this->Group.Here(below.blockDepth);
    level.begin.assign(here.begin + 1, below.begin[here.begin]);
    if (this->Steps.ByClusters())
    {
      return this->Steps.Join(
        this->Folder, { below, this->States, this->Links, here }, depth, writer);
    }
    DistributedLevelBlocks blocks(
      this->Group, this->Folder, below, this->States, arrays, level, writer);
    return this->Steps.Collapse(blocks, depth);
  }

  // Makes the triangles and links of a level: the images of those of the next finer level.
  Status MapTriangles(LevelFile& below, LevelFile& level)
  {
    KDSTREAM_TRY(this->Group.Fetch(
      below.parents, sizeof(VertexId), below.begin, below.blockDepth, below.foreign));
    const LevelLinks links = std::exchange(this->Links, {});
    const auto load = [&](std::size_t block, std::vector<Triangle>& triangles) -> Status
    {
      const std::uint64_t from = below.triangleBegin[block];
      triangles.resize(static_cast<std::size_t>(below.triangleBegin[block + 1] - from));
      KDSTREAM_TRY(ReadRecords<Triangle>(below.triangles, from, std::span<Triangle>(triangles)));
      return this->Steps.ByClusters() ? links.Load(block, block + 1, triangles) : Status{};
    };
    return this->WriteImages({ load, below.parents, below.begin, below.blockDepth }, level);
  }

  MpiGroup& Group;
  SpillFolder& Folder;
  const MeshBlocks& Mesh;
  const std::uint64_t Memory;
  const Execution& Exec;
  const std::function<void(const TreeBlock&)>& Seen;
  LevelSteps Steps;
  DistributedLevelFiles Files;
  LevelStates States; // of the coarsest level so far
  LevelLinks Links;   // of the same level; only for levels by clusters
  ExternalLevels Output;
};

}

Result<ExternalLevels> BuildLevelsCollectively(MpiGroup& group, SpillFolder& folder,
  const MeshBlocks& mesh, const LevelOptions& options, std::uint64_t memory,
  const Execution& execution, const std::function<void(const TreeBlock&)>& seen)
{
  return DistributedLevelsBuilder(group, folder, mesh, options, memory, execution, seen).Build();
}

}
