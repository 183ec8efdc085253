// Numbers of a mesh in blocks: see ExternalNumbers.h, and VertexNumbers.h for what follows from
// what.
#include "filters/outofcore/ExternalNumbers.h"

#include "filters/core/PointRecord.h"
#include "filters/core/VertexNumbers.h"
#include "filters/outofcore/RecordFile.h"

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

// What numbering needs of clusters that follow each other in a level.
struct ClusterLinks
{
  std::vector<VertexId> parents; // none at level 0
  std::vector<VertexId> lowest;
  std::vector<VertexId> counts; // original vertices; none of a level that is in memory

  LevelLinks Links() const { return { this->parents, this->lowest }; }
};

VertexId ClusterCount(const ExternalLevels& levels, unsigned depth)
{
  return depth < levels.firstInFiles ? static_cast<VertexId>(levels.coarse[depth].lowest.size())
                                     : levels.files[depth].ClusterCount();
}

Status CheckParents(const ExternalLevels& levels, unsigned depth, VertexId firstCluster,
  std::span<const VertexId> parents)
{
  const VertexId count = ClusterCount(levels, depth - 1);
  for (std::size_t i = 0; i < parents.size(); ++i)
  {
    if (parents[i] >= count)
    {
      return Error{ ErrorCode::Damaged,
        "level " + std::to_string(depth) + ": the parent of cluster " +
          std::to_string(firstCluster + i) + " is " + std::to_string(parents[i]) + " of " +
          std::to_string(count) };
    }
  }
  return {};
}

// The links of the clusters [begin, end) of a level in files.
Result<ClusterLinks> ReadLinks(
  const ExternalLevels& levels, unsigned depth, VertexId begin, VertexId end)
{
  const LevelFile& level = levels.files[depth];
  ClusterLinks links;
  links.lowest.reserve(end - begin);
  links.counts.reserve(end - begin);
  RecordReader<ClusterRecord> reader(level.clusters, begin, end);
  while (links.lowest.size() < end - begin)
  {
    const Result<std::span<const ClusterRecord>> read = reader.Next();
    if (!read)
    {
      return read.GetError();
    }
    for (const ClusterRecord& cluster : *read)
    {
      links.lowest.push_back(cluster.lowest);
      links.counts.push_back(cluster.count);
    }
  }
  if (depth == 0)
  {
    return links;
  }
  links.parents.resize(end - begin);
  Status status = ReadRecords<VertexId>(level.parents, begin, std::span<VertexId>(links.parents));
  if (status)
  {
    status = CheckParents(levels, depth, begin, links.parents);
  }
  return status ? Result<ClusterLinks>(std::move(links)) : status.GetError();
}

// Fills in the `first` and `parents` of a level of the vertex tree, and gives the place of each
// cluster there.
std::vector<VertexId> PlaceClusters(std::span<const VertexId> first,
  std::span<const VertexId> parents, std::span<const VertexId> placesAbove, VertexTreeLevel& level)
{
  std::vector<std::pair<VertexId, VertexId>> sorted; // first, cluster
  sorted.reserve(first.size());
  for (const VertexId number : first)
  {
    sorted.emplace_back(number, static_cast<VertexId>(sorted.size()));
  }
  std::sort(sorted.begin(), sorted.end());
  std::vector<VertexId> places(first.size());
  for (const auto& [number, cluster] : sorted)
  {
    places[cluster] = static_cast<VertexId>(level.first.size());
    level.first.push_back(number);
    if (!placesAbove.empty())
    {
      level.parents.push_back(placesAbove[parents[cluster]]);
    }
  }
  return places;
}

// The points of ranks that follow each other; in the order of ids if `byId`, else of ranks.
struct RankedPoints
{
  std::vector<Vec3> points;
  std::vector<VertexId> ranks; // of each, from the first
};

template <class Scalar>
Result<RankedPoints> ReadPoints(const SpillFile& records, const CellRange& range, bool byId)
{
  std::vector<PointRecord<Scalar>> all(static_cast<std::size_t>(range.size));
  if (Status status =
        ReadRecords<PointRecord<Scalar>>(records, range.begin, std::span<PointRecord<Scalar>>(all));
      !status)
  {
    return status.GetError();
  }
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
    const Execution& execution, BlockTeam* team)
    : Folder(folder)
    , Input(mesh)
    , Levels(levels)
    , Exec(execution)
    , Team(team ? *team : this->Alone)
  {
  }

  Result<ExternalNumbers> Number()
  {
    const unsigned stitch = this->Input.depths.stitch, finest = this->Input.depths.finest;
    Result<CoarseNumbers> coarse = NumberCoarseLevels(this->Input, this->Levels, &this->Team);
    if (!coarse)
    {
      return coarse.GetError();
    }
    this->FirstOfStitch = std::move(coarse->first[stitch]);
    this->Numbers.first.resize(finest + 1);
    this->BlocksInAll = this->BlocksHere(this->Input.blockDepth);
    for (unsigned d = stitch + 1; d <= finest; ++d)
    {
      this->BlocksInAll += this->BlocksHere(this->Levels.files[d].blockDepth);
    }
    for (unsigned d = stitch + 1; d <= finest; ++d)
    {
      if (Status status = this->NumberLevel(d); !status)
      {
        return status.GetError();
      }
    }
    if (Status status = this->NumberOriginal(); !status)
    {
      return status.GetError();
    }
    return std::move(this->Numbers);
  }

private:
  Result<SpillFile> CreateFile(std::string_view purpose, std::uint64_t numbers)
  {
    return this->Folder.CreateFile(purpose, numbers * sizeof(VertexId));
  }

  // Whether these are all blocks: then nothing has to be fetched.
  static bool IsAll(const BlockRange& blocks, unsigned depth)
  {
    return blocks.begin == 0 && blocks.end == std::size_t{ 1 } << depth;
  }

  std::size_t BlocksHere(unsigned depth) const
  {
    const BlockRange here = this->Team.Here(depth);
    return here.end - here.begin;
  }

  // Fetches the numbers of clusters of a level >= S that other processes have.
  Status FetchFirst(unsigned depth, std::vector<VertexId> wanted)
  {
    if (depth == this->Input.depths.stitch)
    {
      return {};
    }
    std::sort(wanted.begin(), wanted.end());
    wanted.erase(std::unique(wanted.begin(), wanted.end()), wanted.end());
    const LevelFile& level = this->Levels.files[depth];
    return this->Team.Fetch(
      this->Numbers.first[depth], sizeof(VertexId), level.begin, level.blockDepth, wanted);
  }

  // The parents of the clusters that are here may be elsewhere: blocks of coarser levels are
  // larger.
  Status FetchFirstOfParents(const LevelFile& level)
  {
    const BlockRange here = this->Team.Here(level.blockDepth);
    std::vector<VertexId> parents;
    if (here.begin < here.end && !IsAll(here, level.blockDepth))
    {
      parents.resize(level.begin[here.end] - level.begin[here.begin]);
    }
    const Status status = parents.empty()
                            ? Status{}
                            : ReadRecords<VertexId>(level.parents, level.begin[here.begin],
                                std::span<VertexId>(parents));
    return status ? this->FetchFirst(level.depth - 1, std::move(parents)) : status;
  }

  // work(block) -> Status for each block that is here, some of them side by side: numbering takes a
  // tenth of the memory that a block may take.
  template <class Work>
  Status ForEachBlock(unsigned depth, const Work& work)
  {
    constexpr std::size_t atOnce = 4;
    const BlockRange here = this->Team.Here(depth);
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
        if (!status)
        {
          return status;
        }
      }
      this->BlocksDone += statuses.size();
      if (Status status =
            this->Exec.Report("levels", double(this->BlocksDone) / double(this->BlocksInAll));
          !status)
      {
        return status;
      }
    }
    return {};
  }

  // The lowest numbered vertices of clusters [begin, end) of a level >= S that is numbered already.
  Result<std::vector<VertexId>> FirstOf(unsigned depth, VertexId begin, VertexId end) const
  {
    std::vector<VertexId> first(end - begin);
    if (depth == this->Input.depths.stitch)
    {
      std::copy_n(this->FirstOfStitch.begin() + std::ptrdiff_t(begin), first.size(), first.begin());
      return first;
    }
    const Status status =
      ReadRecords<VertexId>(this->Numbers.first[depth], begin, std::span<VertexId>(first));
    return status ? Result<std::vector<VertexId>>(std::move(first)) : status.GetError();
  }

  Status NumberLevel(unsigned depth)
  {
    const LevelFile& level = this->Levels.files[depth];
    Result<SpillFile> file = this->CreateFile("numbers of a level", level.ClusterCount());
    if (!file)
    {
      return file.GetError();
    }
    if (Status status = this->FetchFirstOfParents(level); !status)
    {
      return status;
    }
    if (Status status = this->ForEachBlock(level.blockDepth,
          [&](std::size_t block) {
            return this->NumberClusters(depth, level.begin[block], level.begin[block + 1], *file);
          });
        !status)
    {
      return status;
    }
    this->Numbers.first[depth] = std::move(*file);
    return this->FetchFirst(depth, level.foreign);
  }

  // The clusters of a block and all their siblings, [begin, end).
  Status NumberClusters(unsigned depth, VertexId begin, VertexId end, SpillFile& file) const
  {
    Result<ClusterLinks> links = ReadLinks(this->Levels, depth, begin, end);
    if (!links)
    {
      return links.GetError();
    }
    if (begin == end)
    {
      return {};
    }
    // Parents are the clusters of the same cell of the tree: an interval too.
    const auto [least, most] = std::minmax_element(links->parents.begin(), links->parents.end());
    const VertexId beginAbove = *least, endAbove = *most + 1;
    const Result<std::vector<VertexId>> above = this->FirstOf(depth - 1, beginAbove, endAbove);
    if (!above)
    {
      return above.GetError();
    }
    for (VertexId& parent : links->parents)
    {
      parent -= beginAbove;
    }
    const std::vector<VertexId> first =
      FirstOfChildren(links->Links(), links->counts, *above, this->Exec);
    return WriteRecords<VertexId>(file, begin, std::span<const VertexId>(first));
  }

  Status NumberOriginal()
  {
    Result<SpillFile> file = this->CreateFile("numbers of the vertices", this->Input.vertexCount);
    if (!file)
    {
      return file.GetError();
    }
    if (Status status = this->FetchFirstOfFinest(); !status)
    {
      return status;
    }
    if (Status status = this->ForEachBlock(this->Input.blockDepth,
          [&](std::size_t block) { return this->NumberBlock(this->Input.RangeOf(block), *file); });
        !status)
    {
      return status;
    }
    this->Numbers.numberOfRank = std::move(*file);
    return this->Team.Fetch(this->Numbers.numberOfRank, sizeof(VertexId), this->Input.BlockBegins(),
      this->Input.blockDepth, this->Input.foreign);
  }

  Status FetchFirstOfFinest()
  {
    const BlockRange here = this->Team.Here(this->Input.blockDepth);
    std::vector<VertexId> clusters;
    if (here.begin < here.end && !IsAll(here, this->Input.blockDepth))
    {
      const CellRange last = this->Input.RangeOf(here.end - 1);
      const std::uint64_t begin = this->Input.RangeOf(here.begin).begin;
      clusters.resize(static_cast<std::size_t>(last.begin + last.size - begin));
      if (Status status =
            ReadRecords<VertexId>(this->Levels.clusterOfRank, begin, std::span<VertexId>(clusters));
          !status)
      {
        return status;
      }
    }
    return this->FetchFirst(this->Input.depths.finest, std::move(clusters));
  }

  // The vertices of a block. Its ranks and its numbers are the same interval. Inside a finest
  // cluster the order of ids matters for those in the same place alone.
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
    if (!points)
    {
      return points.GetError();
    }
    std::vector<VertexId> clusterOfRank(points->ranks.size());
    if (Status status = ReadRecords<VertexId>(
          this->Levels.clusterOfRank, range.begin, std::span<VertexId>(clusterOfRank));
        !status)
    {
      return status;
    }
    const VertexId beginCluster = *std::min_element(clusterOfRank.begin(), clusterOfRank.end());
    const Result<std::vector<VertexId>> first =
      this->FirstOfFinest(range, beginCluster, clusterOfRank);
    if (!first)
    {
      return first.GetError();
    }
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

  // The lowest numbered vertices of the finest clusters of a block, from cluster `begin` on; and
  // that each has room for its vertices behind its lowest. clusterOf: of each vertex of the block.
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
    Result<std::vector<VertexId>> first = this->FirstOf(finest, begin, last + 1);
    if (!first)
    {
      return first;
    }
    std::vector<VertexId> counts(first->size(), 0);
    for (const VertexId cluster : clusterOf)
    {
      ++counts[cluster - begin];
    }
    std::vector<bool> taken(clusterOf.size(), false); // of the block's numbers
    for (std::size_t i = 0; i < counts.size(); ++i)
    {
      const std::uint64_t from = (*first)[i] - range.begin; // beyond the block where it is below
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
            " does not count its vertices, which are " + std::to_string(counts[i]) };
      }
    }
    return first;
  }

  SpillFolder& Folder;
  const MeshBlocks& Input;
  const ExternalLevels& Levels;
  const Execution& Exec;
  BlockTeam Alone;
  BlockTeam& Team;
  std::vector<VertexId> FirstOfStitch; // of the clusters of level S
  ExternalNumbers Numbers;
  std::size_t BlocksDone = 0, BlocksInAll = 0;
};

}

Result<ExternalNumbers> NumberExternally(SpillFolder& folder, const MeshBlocks& mesh,
  const ExternalLevels& levels, const Execution& execution, BlockTeam* team)
{
  return ExternalNumbering(folder, mesh, levels, execution, team).Number();
}

namespace
{

Status SpreadCoarse(CoarseNumbers& numbers, unsigned stitch, BlockTeam& team)
{
  numbers.first.resize(stitch + std::size_t{ 1 });
  Status status;
  for (std::size_t d = 0; status && d <= stitch; ++d)
  {
    status = team.Spread(numbers.first[d]);
    status = status ? team.Spread(numbers.tree.levels[d].first) : status;
    status = status ? team.Spread(numbers.tree.levels[d].parents) : status;
  }
  return status;
}

}

Result<CoarseNumbers> NumberCoarseLevels(
  const MeshBlocks& mesh, const ExternalLevels& levels, BlockTeam* team)
{
  CoarseNumbers numbers;
  numbers.tree.levels.resize(mesh.depths.finest + std::size_t{ 1 });
  numbers.tree.depths = mesh.depths;
  const std::uint64_t partitions = std::uint64_t{ 1 } << mesh.depths.partition;
  for (std::uint64_t p = 0; p < partitions; ++p)
  {
    numbers.tree.partitionBegin.push_back(
      static_cast<VertexId>(RangeOfCell(mesh.vertexCount, mesh.depths.partition, p).begin));
  }
  numbers.tree.partitionBegin.push_back(mesh.vertexCount);

  if (team != nullptr && !team->IsFirst())
  {
    const Status status = SpreadCoarse(numbers, mesh.depths.stitch, *team);
    return status ? Result<CoarseNumbers>(std::move(numbers)) : status.GetError();
  }
  const std::size_t count = mesh.depths.stitch + std::size_t{ 1 };
  std::vector<ClusterLinks> fromFiles(count);
  std::vector<LevelLinks> links;
  for (unsigned d = 0; d < count; ++d)
  {
    if (d < levels.firstInFiles)
    {
      links.push_back({ levels.coarse[d].parents, levels.coarse[d].lowest });
      continue;
    }
    Result<ClusterLinks> read = ReadLinks(levels, d, 0, levels.files[d].ClusterCount());
    if (!read)
    {
      return read.GetError();
    }
    fromFiles[d] = std::move(*read);
    links.push_back(fromFiles[d].Links());
  }
  numbers.first =
    FirstOfCoarseClusters(links, fromFiles.back().counts, numbers.tree.partitionBegin);

  std::vector<VertexId> places;
  for (std::size_t d = 0; d < count; ++d)
  {
    places = PlaceClusters(numbers.first[d], links[d].parents, places, numbers.tree.levels[d]);
  }
  const Status status =
    team != nullptr ? SpreadCoarse(numbers, mesh.depths.stitch, *team) : Status{};
  return status ? Result<CoarseNumbers>(std::move(numbers)) : status.GetError();
}

}
