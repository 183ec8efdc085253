// SPDX-License-Identifier: BSD-3-Clause
// The numbers of a mesh in blocks: see ExternalNumbers.h, and VertexNumbers.h for the order of the
// computation.
#include "filters/outofcore/pieces/ExternalNumbers.h"

#include "filters/core/pieces/VertexNumbers.h"
#include "filters/core/tree/PointRecord.h"
#include "filters/outofcore/files/RecordFile.h"
#include "filters/outofcore/pieces/ClusterLinks.h"
#include "filters/outofcore/pieces/CoarseNumbers.h"

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <span>
#include <string>
#include <utility>

namespace kdstream
{
namespace
{

// The points of consecutive ranks; in the order of ids if `byId`, else in the order of ranks.
struct RankedPoints
{
  std::vector<Vec3> points;
  std::vector<VertexId> ranks; // of each point, minus the first rank
};

template <class Scalar>
Result<RankedPoints> ReadPoints(const SpillFile& records, const CellRange& range, bool byId)
{
  std::vector<PointRecord<Scalar>> all(static_cast<std::size_t>(range.size));
  KDSTREAM_TRY(
    ReadRecords<PointRecord<Scalar>>(records, range.begin, std::span<PointRecord<Scalar>>(all)));
  RankedPoints result;
  result.ranks.resize(all.size());
  std::iota(result.ranks.begin(), result.ranks.end(), VertexId{ 0 });
  if (byId)
  {
    std::sort(result.ranks.begin(), result.ranks.end(),
      [&](VertexId a, VertexId b) { return all[a].id < all[b].id; });
  }
  result.points.reserve(all.size());
  for (const VertexId rank : result.ranks)
  {
    result.points.push_back({ all[rank].p[0], all[rank].p[1], all[rank].p[2] });
  }
  return result;
}

class ExternalNumbering
{
public:
  ExternalNumbering(SpillFolder& folder, const MeshBlocks& mesh, const ExternalLevels& levels,
    const Execution& execution, BlockGroup* group)
    : Folder(folder)
    , Input(mesh)
    , Levels(levels)
    , Exec(execution)
    , Group(group ? *group : this->Alone)
  {
  }

  Result<ExternalNumbers> Number()
  {
    const unsigned stitch = this->Input.depths.stitch, finest = this->Input.depths.finest;
    this->Numbers.first.resize(finest + 1);
    KDSTREAM_TRY(
      NumberCoarseLevels(this->Folder, this->Input, this->Levels, this->Numbers, this->Group));
    this->BlocksInAll = this->BlocksHere(this->Input.blockDepth);
    for (unsigned d = stitch + 1; d <= finest; ++d)
    {
      this->BlocksInAll += this->BlocksHere(this->Levels.files[d].blockDepth);
    }
    for (unsigned d = stitch + 1; d <= finest; ++d)
    {
      KDSTREAM_TRY(this->NumberLevel(d));
    }
    KDSTREAM_TRY(this->NumberOriginal());
    return std::move(this->Numbers);
  }

private:
  Result<SpillFile> CreateFile(std::string_view purpose, std::uint64_t numbers)
  {
    return this->Folder.CreateFile(purpose, numbers * sizeof(VertexId));
  }

  // Whether the blocks are all that there are; then nothing has to be fetched.
  static bool IsAll(const BlockRange& blocks, unsigned depth)
  {
    return blocks.begin == 0 && blocks.end == std::size_t{ 1 } << depth;
  }

  std::size_t BlocksHere(unsigned depth) const
  {
    const BlockRange here = this->Group.Here(depth);
    return here.end - here.begin;
  }

  // Fetches the lowest numbered vertices of those clusters of a level >= S that are stored in the
  // file `clusters` at the places [begin, end) and that other processes have. Fetches a few MiB at
  // a time.
  Status FetchFirst(
    unsigned depth, const SpillFile& clusters, std::uint64_t begin, std::uint64_t end)
  {
    if (depth == this->Input.depths.stitch)
    {
      return {};
    }
    constexpr std::uint64_t atOnce = std::uint64_t{ 1 } << 20;
    const LevelFile& level = this->Levels.files[depth];
    const BlockRange here = this->Group.Here(level.blockDepth);
    const VertexId own = level.begin[here.begin], ownEnd = level.begin[here.end];
    const Result<std::uint64_t> rounds = this->Group.Most((end - begin + atOnce - 1) / atOnce);
    KDSTREAM_TRY(rounds);
    for (std::uint64_t round = 0; round < *rounds; ++round)
    {
      const std::uint64_t from = std::min(begin + round * atOnce, end);
      std::vector<VertexId> wanted(static_cast<std::size_t>(std::min(atOnce, end - from)));
      KDSTREAM_TRY(ReadRecords<VertexId>(clusters, from, std::span<VertexId>(wanted)));
      std::erase_if(wanted, [&](VertexId cluster) { return cluster >= own && cluster < ownEnd; });
      KDSTREAM_TRY(this->Group.Fetch(
        this->Numbers.first[depth], sizeof(VertexId), level.begin, level.blockDepth, wanted));
    }
    return {};
  }

  // Parents of this process's clusters may be in other processes, because blocks of coarser levels
  // are larger.
  Status FetchFirstOfParents(const LevelFile& level)
  {
    const BlockRange here = this->Group.Here(level.blockDepth);
    const VertexId begin = level.begin[here.begin];
    return this->FetchFirst(level.depth - 1, level.parents, begin,
      IsAll(here, level.blockDepth) ? begin : level.begin[here.end]);
  }

  // Calls work(block) -> Status for each block of this process, a few of them in parallel:
  // numbering takes a tenth of the memory that a block may take.
  template <class Work>
  Status ForEachBlock(unsigned depth, const Work& work)
  {
    constexpr std::size_t atOnce = 4;
    const BlockRange here = this->Group.Here(depth);
    for (std::size_t first = here.begin; first < here.end; first += atOnce)
    {
      std::vector<Status> statuses(std::min(atOnce, here.end - first));
      this->Exec.parallelFor(statuses.size(), 1,
        [&](std::size_t begin, std::size_t end)
        {
          for (std::size_t i = begin; i < end; ++i)
          {
            statuses[i] = work(first + i);
          }
        });
      for (const Status& status : statuses)
      {
        KDSTREAM_TRY(status);
      }
      this->BlocksDone += statuses.size();
      KDSTREAM_TRY(
        this->Exec.Report("levels", double(this->BlocksDone) / double(this->BlocksInAll)));
    }
    return {};
  }

  Status NumberLevel(unsigned depth)
  {
    const LevelFile& level = this->Levels.files[depth];
    Result<SpillFile> file = this->CreateFile("numbers of a level", level.ClusterCount());
    KDSTREAM_TRY(file);
    KDSTREAM_TRY(this->FetchFirstOfParents(level));
    KDSTREAM_TRY(this->ForEachBlock(level.blockDepth,
      [&](std::size_t block) { return this->NumberClusters(depth, block, *file); }));
    this->Numbers.first[depth] = std::move(*file);
    return this->Group.Fetch(
      this->Numbers.first[depth], sizeof(VertexId), level.begin, level.blockDepth, level.foreign);
  }

  // Numbers the clusters of a block. All siblings of a cluster are in the same block.
  Status NumberClusters(unsigned depth, std::size_t block, SpillFile& file) const
  {
    const Result<ClusterLinks> links = ReadLinks(this->Levels, depth, block);
    KDSTREAM_TRY(links);
    // The parents are the clusters of the same cell of the tree, so their numbers are an interval
    // too.
    const Result<std::vector<VertexId>> above =
      ReadInterval<VertexId>(this->Numbers.first[depth - 1], links->above.begin, links->above.end);
    KDSTREAM_TRY(above);
    const std::vector<VertexId> first =
      FirstOfChildren(links->Links(), links->counts, *above, this->Exec);
    return WriteRecords<VertexId>(
      file, this->Levels.files[depth].begin[block], std::span<const VertexId>(first));
  }

  Status NumberOriginal()
  {
    Result<SpillFile> file = this->CreateFile("numbers of the vertices", this->Input.vertexCount);
    KDSTREAM_TRY(file);
    KDSTREAM_TRY(this->FetchFirstOfFinest());
    KDSTREAM_TRY(this->ForEachBlock(this->Input.blockDepth,
      [&](std::size_t block) { return this->NumberBlock(this->Input.RangeOf(block), *file); }));
    this->Numbers.numberOfRank = std::move(*file);
    return this->Group.Fetch(this->Numbers.numberOfRank, sizeof(VertexId),
      this->Input.BlockBegins(), this->Input.blockDepth, this->Input.foreign);
  }

  Status FetchFirstOfFinest()
  {
    const BlockRange here = this->Group.Here(this->Input.blockDepth);
    const std::vector<VertexId> begins = this->Input.BlockBegins();
    const VertexId begin = begins[here.begin];
    return this->FetchFirst(this->Input.depths.finest, this->Levels.clusterOfRank, begin,
      IsAll(here, this->Input.blockDepth) ? begin : begins[here.end]);
  }

  // Numbers the vertices of a block. Their ranks and their numbers are the same interval. Within a
  // finest cluster the order of ids matters only for vertices in the same place.
  Status NumberBlock(const CellRange& range, SpillFile& file) const
  {
    if (range.size == 0)
    {
      return {};
    }
    const bool byId = this->Input.mayCoincide;
    const Result<RankedPoints> points = this->Input.floats
                                          ? ReadPoints<float>(this->Input.records, range, byId)
                                          : ReadPoints<double>(this->Input.records, range, byId);
    KDSTREAM_TRY(points);
    std::vector<VertexId> clusterOfRank(points->ranks.size());
    KDSTREAM_TRY(ReadRecords<VertexId>(
      this->Levels.clusterOfRank, range.begin, std::span<VertexId>(clusterOfRank)));
    const VertexId beginCluster = *std::min_element(clusterOfRank.begin(), clusterOfRank.end());
    const Result<std::vector<VertexId>> first =
      this->FirstOfFinest(range, beginCluster, clusterOfRank);
    KDSTREAM_TRY(first);
    std::vector<VertexId> clusterOf(clusterOfRank.size());
    for (std::size_t i = 0; i < clusterOf.size(); ++i)
    {
      clusterOf[i] = clusterOfRank[points->ranks[i]] - beginCluster;
    }
    const auto begin = static_cast<VertexId>(range.begin);
    const std::vector<VertexId> order =
      OrderVertices(clusterOf, *first, begin, points->points, this->Exec);
    std::vector<VertexId> numbers = std::move(clusterOfRank);
    for (std::size_t i = 0; i < order.size(); ++i)
    {
      numbers[points->ranks[order[i]]] = static_cast<VertexId>(begin + i);
    }
    return WriteRecords<VertexId>(file, range.begin, std::span<const VertexId>(numbers));
  }

  // The lowest numbered vertices of the finest clusters of a block, beginning with cluster `begin`.
  // Checks that after its lowest number each cluster has room for its vertices. clusterOf: of each
  // vertex of the block.
  Result<std::vector<VertexId>> FirstOfFinest(
    const CellRange& range, VertexId begin, std::span<const VertexId> clusterOf) const
  {
    const unsigned finest = this->Input.depths.finest;
    const VertexId all = ClusterCount(this->Levels, finest);
    const VertexId last = *std::max_element(clusterOf.begin(), clusterOf.end());
    if (last >= all)
    {
      return Error{ ErrorCode::Damaged, "level " + std::to_string(finest) +
                                          ": vertices of cluster " + std::to_string(last) + " of " +
                                          std::to_string(all) };
    }
    Result<std::vector<VertexId>> first =
      ReadInterval<VertexId>(this->Numbers.first[finest], begin, std::uint64_t{ last } + 1);
    KDSTREAM_TRY(first);
    std::vector<VertexId> counts(first->size(), 0);
    for (const VertexId cluster : clusterOf)
    {
      ++counts[cluster - begin];
    }
    std::vector<bool> taken(clusterOf.size(), false); // for each number of the block
    for (std::size_t i = 0; i < counts.size(); ++i)
    {
      // Wraps around to a large number if the number is below the block.
      const std::uint64_t from = (*first)[i] - range.begin;
      bool fits = from <= range.size && counts[i] <= range.size - from;
      for (std::uint64_t at = from; fits && at < from + counts[i]; ++at)
      {
        fits = !taken[at];
        taken[at] = true;
      }
      if (!fits)
      {
        return Error{ ErrorCode::Damaged,
          "level " + std::to_string(finest) + ": cluster " + std::to_string(begin + i) +
            " has a wrong count of vertices, which should be " + std::to_string(counts[i]) };
      }
    }
    return first;
  }

  SpillFolder& Folder;
  const MeshBlocks& Input;
  const ExternalLevels& Levels;
  const Execution& Exec;
  BlockGroup Alone;
  BlockGroup& Group;
  ExternalNumbers Numbers;
  std::size_t BlocksDone = 0, BlocksInAll = 0;
};

}

Result<ExternalNumbers> NumberExternally(SpillFolder& folder, const MeshBlocks& mesh,
  const ExternalLevels& levels, const Execution& execution, BlockGroup* group)
{
  return ExternalNumbering(folder, mesh, levels, execution, group).Number();
}

}
