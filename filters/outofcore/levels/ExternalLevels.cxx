// SPDX-License-Identifier: BSD-3-Clause
// The levels out of core: see ExternalLevels.h. The steps that levels of several ranks share are in
// LevelSteps.h.
//   1. Build the finest level block by block (FinestClusters.h), and store the cluster of each
//      vertex by rank.
//   2. Go from level to level in rounds (CollapseRound.h, ClusterRound.h) on files.
//   3. Build the coarse levels in memory.
#include "filters/outofcore/levels/ExternalLevels.h"

#include "filters/core/TakeResult.h"
#include "filters/outofcore/files/LoadAhead.h"
#include "filters/outofcore/files/ReturnFreeMemory.h"
#include "filters/outofcore/levels/LevelSteps.h"
#include "filters/outofcore/mesh/CellTriangles.h"
#include "filters/outofcore/mesh/CoincidentRanks.h"

#include <algorithm>
#include <optional>

namespace kdstream
{
namespace
{

// Memory for finding coincident vertices, per vertex of a block: no more than other steps take.
constexpr std::uint64_t coincidentBytes = 200;
constexpr std::uint64_t leastCoincidentMemory = std::uint64_t{ 1 } << 20;
// The number of clusters allowed in a block of a level, per vertex of a block of the mesh. It is
// below 1 because clusters take more memory (ExternalLevels.h), and two blocks of them are in
// memory.
constexpr double clustersOfBlock = 0.62;
// Memory of each triangle beyond two per vertex, as a share of a vertex's memory.
constexpr double triangleShare = 1.0 / 6;
// How many blocks have their triangles mapped at the same time. Mapping takes a tenth of the memory
// that the vertices of a block do.
constexpr std::size_t imagesAtOnce = 4;

// Rotates each triangle to begin with its lowest corner, sorts the triangles, and removes
// duplicates. Triangles that have become points are dropped; those that have become edges too,
// unless links are wanted.
void SortImage(std::vector<Triangle>& triangles, bool links)
{
  std::erase_if(triangles,
    [&](const Triangle& t)
    {
      const bool ab = t[0] == t[1], bc = t[1] == t[2];
      return links ? ab && bc : ab || bc || t[2] == t[0];
    });
  std::transform(triangles.begin(), triangles.end(), triangles.begin(), RotateLowestFirst);
  std::sort(triangles.begin(), triangles.end());
  triangles.erase(std::unique(triangles.begin(), triangles.end()), triangles.end());
}

// Merges sorted triangles into other sorted ones.
void MergeSorted(const std::vector<Triangle>& added, std::vector<Triangle>& triangles)
{
  const auto middle = static_cast<std::ptrdiff_t>(triangles.size());
  triangles.insert(triangles.end(), added.begin(), added.end());
  std::inplace_merge(triangles.begin(), triangles.begin() + middle, triangles.end());
}

class ExternalLevelsBuilder
{
public:
  ExternalLevelsBuilder(SpillFolder& folder, const MeshBlocks& mesh, const LevelOptions& options,
    const Execution& execution, const std::function<void(const TreeBlock&)>& seen)
    : Folder(folder)
    , Mesh(mesh)
    , Exec(execution)
    , Seen(seen)
    , Steps(mesh, options, execution)
  {
    this->Output.attributes = this->Steps.Arrays().attributes;
    this->Output.files.resize(mesh.depths.finest + 1);
  }

  Result<ExternalLevels> Build()
  {
    KDSTREAM_TRY(this->BuildFinest());
    LevelFile& finest = this->FileOf(this->Mesh.depths.finest);
    MergeBlocks(finest, this->BlockDepthOf(finest));
    KDSTREAM_TRY(this->FindCoincident());
    KDSTREAM_TRY(this->MapFinestTriangles());
    unsigned depth = finest.depth;
    while (this->Steps.IsCoarserInFiles(this->FileOf(depth), this->States))
    {
      KDSTREAM_TRY(this->BuildCoarser(--depth));
    }
    KDSTREAM_TRY(this->BuildCoarse(depth));
    return std::move(this->Output);
  }

private:
  LevelFile& FileOf(unsigned depth) { return this->Output.files[depth]; }

  Status BuildFinest()
  {
    const unsigned finest = this->Mesh.depths.finest;
    LevelFile& level = this->FileOf(finest);
    level.depth = finest;
    level.blockDepth = this->Mesh.blockDepth;
    LevelWriter writer(level, this->States, this->Steps.Arrays());
    KDSTREAM_TRY(writer.Begin(this->Folder, std::uint64_t{ 1 } << finest));
    KDSTREAM_TRY(Take(this->Folder.CreateFile("clusters of vertices",
                        this->Mesh.vertexCount * std::uint64_t{ sizeof(VertexId) }),
      this->Output.clusterOfRank));
    return ForEachLoaded(
      this->Mesh.BlockCount(), [&](std::size_t index) { return this->Mesh.Load(index); },
      [&](const TreeBlock& block)
      {
        if (this->Seen)
        {
          this->Seen(block);
        }
        const Status built = this->Steps.BuildFinestBlock(
          block, level.begin.back(), this->Output.clusterOfRank, writer);
        ReturnFreeMemory(this->Mesh.keptMemory);
        return built ? this->Steps.ReportFinest(
                         double(block.cell + 1) / double(this->Mesh.BlockCount()))
                     : built;
      },
      this->Exec);
  }

  // Links vertices in the same place that are in different cells: each to the next one in the order
  // of leaves.
  Status FindCoincident()
  {
    const LevelFile& level = this->FileOf(this->Mesh.depths.finest);
    if (!this->Steps.LinksCoincident())
    {
      return {};
    }
    const std::uint64_t memory = std::max(
      leastCoincidentMemory, coincidentBytes * (this->Mesh.vertexCount >> this->Mesh.blockDepth));
    Result<RecordBuckets<Triangle>> pairs = RecordBuckets<Triangle>::Create(
      this->Folder, "coincident vertices", level.BlockCount(), this->Mesh.vertexCount, memory / 4);
    KDSTREAM_TRY(pairs);
    const CellOfRank blockOf(this->Mesh.vertexCount, level.blockDepth);
    const auto add = [&](VertexId a, VertexId b) {
      return pairs->Add(blockOf(a), CollapsedTriangleOf({ a, b }));
    };
    KDSTREAM_TRY((this->Mesh.floats ? ForEachCoincidentPair<float>
                                    : ForEachCoincidentPair<double>)(this->Folder,
      this->Mesh.records, this->Mesh.vertexCount, memory, add));
    KDSTREAM_TRY(pairs->Finish());
    this->Coincident.emplace(std::move(*pairs));
    return {};
  }

  // The size of a block: its vertices or clusters, plus an equivalent number for the triangles
  // beyond those of a surface. over: how many vertices or clusters the triangles use.
  static double SizeOf(std::uint64_t elements, std::uint64_t triangles, std::uint64_t over)
  {
    return double(elements) + double(triangles - std::min(triangles, 2 * over)) * triangleShare;
  }

  // The smallest block depth at which the level's blocks take no more memory than those of the
  // mesh: larger blocks have fewer ghosts, and less is read twice. The level's triangles are not
  // known yet, so those of the finer level are counted instead. level: still divided into the
  // blocks of the finer level, or of the mesh.
  unsigned BlockDepthOf(const LevelFile& level)
  {
    const bool isFinest = level.depth == this->Mesh.depths.finest;
    const LevelFile* const below = isFinest ? nullptr : &this->FileOf(level.depth + 1);
    const auto most =
      clustersOfBlock *
      SizeOf(this->Mesh.vertexCount, this->Mesh.triangleCount, this->Mesh.vertexCount) /
      double(this->Mesh.BlockCount());
    const auto fits = [&](unsigned depth)
    {
      const std::size_t step = level.BlockCount() >> depth;
      for (std::size_t block = 0; block < level.BlockCount(); block += step)
      {
        const std::uint64_t clusters = level.begin[block + step] - level.begin[block];
        std::uint64_t triangles = 0, over = 0;
        for (std::size_t b = block; isFinest && b < block + step; ++b)
        {
          triangles += this->Mesh.triangleCount > 0 ? this->Mesh.triangles->Size(b) : 0;
          over += this->Mesh.RangeOf(b).size;
        }
        if (below)
        {
          triangles = below->triangleBegin[block + step] - below->triangleBegin[block];
          over = below->begin[block + step] - below->begin[block];
        }
        if (SizeOf(clusters, triangles, over) > most)
        {
          return false;
        }
      }
      return true;
    };
    unsigned depth = this->Steps.BlockDepthOf(level.depth, level.blockDepth);
    while (depth > 0 && fits(depth - 1))
    {
      --depth;
    }
    return depth;
  }

  // The source of a level's triangles: those of the finer level (of clusters) or of the mesh (of
  // vertices), in blocks.
  struct Finer
  {
    std::size_t blocks = 0;
    std::function<VertexId(std::size_t block)> begin; // the first cluster or vertex of a block
    std::function<Status(std::size_t block, std::vector<Triangle>& triangles)> load;
  };

  // Makes the triangles of the finest level from the mesh's.
  Status MapFinestTriangles()
  {
    const std::vector<VertexId> begin = this->Mesh.BlockBegins();
    KDSTREAM_TRY(
      this->WriteImages(this->FileOf(this->Mesh.depths.finest), this->Output.clusterOfRank,
        { this->Mesh.BlockCount(), [&](std::size_t block) { return begin[block]; },
          [&](std::size_t block, std::vector<Triangle>& triangles)
          {
            triangles.reserve(static_cast<std::size_t>(this->Mesh.triangles->Size(block)));
            return this->Mesh.triangles->ForEach(block,
              [&](const NumberedTriangle& t) -> Status
              {
                triangles.push_back(t.corners);
                return {};
              });
          } }));
    this->Coincident.reset();
    return {};
  }

  // Writes the triangles and links of all blocks of a level. map: the cluster of this level for
  // each finer vertex or cluster.
  Status WriteImages(LevelFile& level, const SpillFile& map, const Finer& finer)
  {
    ImageWriter writer(this->Folder, level);
    LevelLinks links;
    LinkWriter linkWriter(level, links);
    KDSTREAM_TRY(writer.Begin(0));
    if (this->Steps.ByClusters())
    {
      KDSTREAM_TRY(linkWriter.Begin(this->Folder));
    }
    const std::size_t step = finer.blocks / level.BlockCount();
    std::vector<std::vector<Triangle>> images;
    std::vector<Triangle> triangles; // of the level's block
    for (std::size_t block = 0; block < finer.blocks; ++block)
    {
      const std::size_t which = block % imagesAtOnce;
      if (which == 0)
      {
        KDSTREAM_TRY(this->MapBlocks(map, finer, block, images));
      }
      MergeSorted(images[which], triangles);
      if ((block + 1) % step == 0)
      {
        KDSTREAM_TRY(this->AddImage(block / step, finer, triangles, map, linkWriter, writer));
        triangles.clear();
      }
    }
    this->Links = std::move(links);
    this->States.triangles = writer.TriangleCount();
    return this->Steps.ByClusters()
             ? Status{}
             : this->Steps.RepairFoldOvers(this->Folder, level, this->States, level.AllBlocks());
  }

  // The images of up to imagesAtOnce finer blocks, beginning with block `first`.
  Status MapBlocks(const SpillFile& map, const Finer& finer, std::size_t first,
    std::vector<std::vector<Triangle>>& images)
  {
    const std::size_t count = std::min(imagesAtOnce, finer.blocks - first);
    images.resize(count);
    std::vector<Status> statuses(count);
    this->Exec.parallelFor(count, 1,
      [&](std::size_t begin, std::size_t end)
      {
        for (std::size_t i = begin; i < end; ++i)
        {
          const std::size_t block = first + i;
          images[i].clear();
          Status& status = statuses[i] = finer.load(block, images[i]);
          if (status)
          {
            status = MapCorners(images[i], map, finer.begin(block), finer.begin(block + 1));
            SortImage(images[i], this->Steps.ByClusters());
          }
        }
      });
    const auto failed =
      std::find_if(statuses.begin(), statuses.end(), [](const Status& status) { return !status; });
    return failed == statuses.end() ? Status{} : *failed;
  }

  Status AddImage(std::size_t block, const Finer& finer, std::vector<Triangle>& triangles,
    const SpillFile& map, LinkWriter& linkWriter, ImageWriter& writer)
  {
    if (this->Coincident)
    {
      const std::size_t step = finer.blocks / this->Coincident->BucketCount();
      std::vector<Triangle> links;
      KDSTREAM_TRY(this->Coincident->ForEach(block,
        [&](const Triangle& link) -> Status
        {
          links.push_back(link);
          return {};
        }));
      KDSTREAM_TRY(
        MapCorners(links, map, finer.begin(block * step), finer.begin((block + 1) * step)));
      triangles.insert(triangles.end(), links.begin(), links.end());
    }
    if (this->Steps.ByClusters())
    {
      KDSTREAM_TRY(linkWriter.Add(triangles));
    }
    return writer.Add(triangles);
  }

  // Builds level `depth` from the next finer level, in files.
  Status BuildCoarser(unsigned depth)
  {
    LevelFile& below = this->FileOf(depth + 1);
    LevelFile& level = this->FileOf(depth);
    level.depth = depth;
    LevelStates states;
    KDSTREAM_TRY(this->MakeClusters(below, depth, states));
    this->States = std::move(states);
    level.blockDepth = below.blockDepth;
    MergeBlocks(level, this->BlockDepthOf(level));
    return this->WriteImages(level, below.parents,
      { below.BlockCount(), [&](std::size_t block) { return below.begin[block]; },
        [&](std::size_t block, std::vector<Triangle>& triangles) -> Status
        {
          const std::uint64_t from = below.triangleBegin[block];
          triangles.resize(static_cast<std::size_t>(below.triangleBegin[block + 1] - from));
          KDSTREAM_TRY(
            ReadRecords<Triangle>(below.triangles, from, std::span<Triangle>(triangles)));
          return this->Steps.ByClusters() ? this->Links.Load(block, block + 1, triangles)
                                          : Status{};
        } });
  }

  // The clusters of level `depth` and their states.
  Status MakeClusters(LevelFile& below, unsigned depth, LevelStates& states)
  {
    LevelFile& level = this->FileOf(depth);
    const LevelArrays& arrays = this->Steps.Arrays();
    LevelWriter writer(level, states, arrays);
    KDSTREAM_TRY(writer.Begin(this->Folder, std::uint64_t{ 1 } << depth));
    if (this->Steps.ByClusters())
    {
      return this->Steps.Join(
        this->Folder, { below, this->States, this->Links, below.AllBlocks() }, depth, writer);
    }
    FileLevelBlocks blocks(this->Folder, below, this->States, arrays, level, writer);
    return this->Steps.Collapse(blocks, depth);
  }

  // Builds in memory all levels coarser than `depth`, which is the last level in files.
  Status BuildCoarse(unsigned depth)
  {
    this->Output.firstInFiles = depth;
    return Take(this->Steps.BuildCoarse(
                  this->Folder, this->FileOf(depth), std::move(this->States), this->Links),
      this->Output.coarse);
  }

  SpillFolder& Folder;
  const MeshBlocks& Mesh;
  const Execution& Exec;
  const std::function<void(const TreeBlock&)>& Seen;
  LevelSteps Steps;
  std::optional<RecordBuckets<Triangle>> Coincident; // links between ranks, by block of the finest
                                                     // level
  LevelStates States;                                // of the coarsest level so far
  LevelLinks Links;                                  // of the same level; only for levels by
                                                     // clusters
  ExternalLevels Output;
};

}

Result<ExternalLevels> BuildExternalLevels(SpillFolder& folder, const MeshBlocks& mesh,
  const LevelOptions& options, const Execution& execution,
  const std::function<void(const TreeBlock&)>& seen)
{
  return ExternalLevelsBuilder(folder, mesh, options, execution, seen).Build();
}

}
