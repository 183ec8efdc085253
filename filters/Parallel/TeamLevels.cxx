// The levels of several ranks: see TeamLevels.h. Steps, shared with the levels of one process, are
// in LevelSteps.h.
//   1. The finest level, every rank its blocks (FinestClusters.h).
//   2. Rounds from level to level (CollapseRound.h, ClusterRound.h): between their passes the ranks
//      tell each other what parts of the level cost, and where clusters go that others use.
//   3. The coarse levels, on rank 0.
// Clusters of a level are numbered over all ranks; how many come before those of a rank is known
// when all have made theirs. Until then a rank counts from the first of the finer elements that it
// has, which leaves room enough (Settle).
#include "filters/Parallel/TeamLevels.h"

#include "filters/Parallel/NumberSet.h"
#include "filters/Parallel/TeamCoincidence.h"
#include "filters/core/TakeResult.h"
#include "filters/outofcore/files/FreeMemory.h"
#include "filters/outofcore/files/LoadAhead.h"
#include "filters/outofcore/files/RecordFile.h"
#include "filters/outofcore/levels/LevelSteps.h"

#include <algorithm>
#include <optional>

namespace kdstream
{
namespace
{

constexpr std::size_t trianglesOfRound = ElementsOfRound(sizeof(NumberedTriangle));

// A level whose blocks lie on several ranks, as a round of collapses goes through it.
class TeamLevelBlocks : public FileLevelBlocks
{
public:
  TeamLevelBlocks(MpiTeam& team, SpillFolder& folder, LevelFile& below, const LevelStates& states,
    const LevelArrays& arrays, LevelFile& coarser, LevelWriter& writer)
    : FileLevelBlocks(folder, below, states, arrays, coarser, writer)
    , Team(team)
  {
  }

  BlockRange Here() const override { return this->Team.Here(this->Below.blockDepth); }
  bool Alone() const override { return false; }
  Status Sum(std::span<std::uint64_t> numbers) override { return this->Team.Sum(numbers); }
  Status ShareParts(std::span<std::byte> parts) override
  {
    return this->Team.Share(parts, this->Below.blockDepth);
  }
  Status ShareTargets(TargetStage stage) override
  {
    return this->Team.Fetch(this->Targets[static_cast<std::size_t>(stage)], sizeof(VertexId),
      this->Below.begin, this->Below.blockDepth, this->Below.foreign);
  }

private:
  MpiTeam& Team;
};

// Moves `count` elements to a lower place.
Status MoveDown(SpillFile& file, std::size_t elementBytes, std::uint64_t from, std::uint64_t to,
  std::uint64_t count)
{
  std::uint64_t bytes = from == to ? 0 : count * elementBytes;
  std::vector<std::byte> block;
  for (std::uint64_t at = 0; at < bytes; at += block.size())
  {
    block.resize(static_cast<std::size_t>(std::min<std::uint64_t>(spillBlockBytes, bytes - at)));
    Status status = file.Read(from * elementBytes + at, block);
    status = status ? file.Write(to * elementBytes + at, block) : status;
    KDSTREAM_TRY(status);
  }
  return {};
}

// Subtracts `down` from the entries [begin, begin + size) of a file of VertexId.
Status CountDown(SpillFile& file, const CellRange& entries, VertexId down)
{
  RecordReader<VertexId> reader(file, entries.begin, entries.begin + entries.size);
  RecordWriter<VertexId> writer(file, entries.begin);
  while (down > 0 && writer.Position() < entries.begin + entries.size)
  {
    const Result<std::span<const VertexId>> read = reader.Next();
    KDSTREAM_TRY(read);
    std::for_each(read->begin(), read->end(), [&](VertexId entry) { writer.Append(entry - down); });
  }
  return writer.Finish();
}

class LevelsBuilder
{
public:
  LevelsBuilder(MpiTeam& team, SpillFolder& folder, const MeshBlocks& mesh,
    const LevelOptions& options, std::uint64_t memory, const Execution& execution,
    const std::function<void(const TreeBlock&)>& seen)
    : Team(team)
    , Folder(folder)
    , Mesh(mesh)
    , Memory(memory)
    , Exec(execution)
    , Seen(seen)
    , Steps(mesh, options, execution)
    , SumBytes(AttributeSums(this->Steps.Arrays().attributes, 0).RecordSize())
  {
    this->Output.attributes = this->Steps.Arrays().attributes;
    this->Output.files.resize(mesh.depths.finest + 1);
  }

  Result<ExternalLevels> Build()
  {
    Status status = this->BuildFinest();
    status = status ? this->MapFinestTriangles() : status;
    unsigned depth = this->Mesh.depths.finest;
    while (status && this->Steps.IsCoarserInFiles(this->FileOf(depth)))
    {
      status = this->BuildCoarser(--depth);
    }
    // Of the last one the parents are still to come.
    status = status ? this->MoveToFirst(depth) : status;
    this->Output.firstInFiles = depth;
    if (status && this->Team.IsFirst())
    {
      status = Take(this->Steps.BuildCoarse(
                      this->Folder, this->FileOf(depth), std::move(this->States), this->Links),
        this->Output.coarse);
    }
    KDSTREAM_TRY(status);
    return std::move(this->Output);
  }

private:
  // A file with an element for each cluster of a level.
  struct ClusterFile
  {
    SpillFile* file;
    std::size_t elementBytes;
  };

  LevelFile& FileOf(unsigned depth) { return this->Output.files[depth]; }

  std::vector<ClusterFile> FilesOf(LevelFile& level, LevelStates& states)
  {
    const LevelArrays& arrays = this->Steps.Arrays();
    std::vector<ClusterFile> files{ { &level.clusters, sizeof(ClusterRecord) },
      { &level.tuples, arrays.TupleBytes() }, { &states.sums, sizeof(ClusterState) },
      { &states.components, arrays.components * sizeof(float) },
      { &states.attributeSums, this->SumBytes } };
    std::erase_if(files, [](const ClusterFile& file) { return file.elementBytes == 0; });
    return files;
  }

  // The elements of a level's or the mesh's blocks that are here.
  CellRange RangeHere(std::span<const VertexId> begin, unsigned depth) const
  {
    const BlockRange here = this->Team.Here(depth);
    return { begin[here.begin], begin[here.end] - begin[here.begin] };
  }

  Status BuildFinest()
  {
    LevelFile& level = this->FileOf(this->Mesh.depths.finest);
    level.depth = this->Mesh.depths.finest;
    LevelWriter writer(level, this->States, this->Steps.Arrays());
    Status status = writer.Begin(this->Folder, 0);
    status =
      status ? Take(this->Folder.CreateFile("clusters of vertices", 0), this->Output.clusterOfRank)
             : status;
    KDSTREAM_TRY(status);
    const BlockRange here = this->Team.Here(this->Mesh.blockDepth);
    const CellRange vertices = this->RangeHere(this->Mesh.BlockBegins(), this->Mesh.blockDepth);
    level.begin.assign(here.begin + 1, static_cast<VertexId>(vertices.begin));
    status = ForEachLoaded(
      here.end - here.begin, [&](std::size_t index) { return this->Mesh.Load(here.begin + index); },
      [&](const TreeBlock& block)
      {
        this->Seen(block);
        const Status built = this->Steps.BuildFinestBlock(
          block, level.begin.back(), this->Output.clusterOfRank, writer);
        ReturnFreeMemory(this->Mesh.keptMemory);
        return built ? this->Steps.ReportFinest(
                         double(block.cell + 1 - here.begin) / double(here.end - here.begin))
                     : built;
      },
      this->Exec);
    level.blockDepth = this->Mesh.blockDepth;
    return status ? this->Settle(level, this->States, this->Output.clusterOfRank, vertices)
                  : status;
  }

  Status MapFinestTriangles()
  {
    LevelFile& level = this->FileOf(this->Mesh.depths.finest);
    Status status = this->MakeBlocks(
      level, this->States, this->Steps.BlockDepthOf(level.depth, this->Mesh.blockDepth));
    TeamCoincidence links;
    if (status && this->Steps.LinksCoincident())
    {
      status =
        Take(LinkCoincidentTogether(this->Team, this->Folder, this->Mesh, this->Memory), links);
    }
    std::vector<VertexId> wanted = this->Mesh.foreign;
    wanted.insert(wanted.end(), links.foreign.begin(), links.foreign.end());
    const std::vector<VertexId> begins = this->Mesh.BlockBegins();
    if (status)
    {
      status = this->Team.Fetch(
        this->Output.clusterOfRank, sizeof(VertexId), begins, this->Mesh.blockDepth, wanted);
    }
    return status
             ? this->WriteImages(level, this->Output.clusterOfRank, begins, this->Mesh.blockDepth,
                 [&](std::size_t block, std::vector<Triangle>& triangles)
                 {
                   const Status loaded = this->Mesh.triangles->ForEach(block,
                     [&](const NumberedTriangle& t) -> Status
                     {
                       triangles.push_back(t.corners);
                       return {};
                     });
                   return loaded ? links.Load(block, triangles) : loaded;
                 })
             : status;
  }

  // Numbers the clusters that all ranks have made of a level, in the blocks of the finer one: they
  // move down in the files, and the entries of `map` in `mapped` with them. The area of all.
  Status Settle(LevelFile& level, LevelStates& states, SpillFile& map, const CellRange& mapped)
  {
    const BlockRange here = this->Team.Here(level.blockDepth);
    std::vector<std::uint64_t> counts(level.BlockCount(), 0);
    for (std::size_t block = here.begin; block < here.end; ++block)
    {
      counts[block] = level.begin[block + 1] - level.begin[block];
    }
    Status status = this->Team.Sum(counts);
    const VertexId before = level.begin[here.begin];
    level.begin.assign(1, 0);
    for (const std::uint64_t count : counts)
    {
      level.begin.push_back(level.begin.back() + static_cast<VertexId>(count));
    }
    const CellRange own = this->RangeHere(level.begin, level.blockDepth);
    const VertexId down = own.size == 0 ? 0 : before - static_cast<VertexId>(own.begin);
    for (const ClusterFile& file : this->FilesOf(level, states))
    {
      status =
        status ? MoveDown(*file.file, file.elementBytes, before, own.begin, own.size) : status;
    }
    status = status ? CountDown(map, mapped, down) : status;
    return status && !this->Steps.ByClusters() ? this->AddUpArea(states, own) : status;
  }

  // In the clusters' order over all ranks. The numbers are taken out first: while a rank adds its
  // own the others wait.
  Status AddUpArea(LevelStates& states, const CellRange& own)
  {
    SpillFile file;
    Status status = Take(this->Folder.CreateFile("areas of clusters", 0), file);
    RecordWriter<double> areas(file);
    RecordReader<ClusterState> reader(states.sums, own.begin, own.begin + own.size);
    while (status && areas.Position() < own.size)
    {
      const Result<std::span<const ClusterState>> read = reader.Next();
      status = read ? Status{} : Status(read.GetError());
      for (std::size_t i = 0; status && i < read->size(); ++i)
      {
        areas.Append((*read)[i].sum.quadric.Trace());
      }
    }
    status = status ? areas.Finish() : status;
    const auto add = [&](double& sum) -> Status
    {
      RecordReader<double> numbers(file, 0, own.size);
      for (std::uint64_t done = 0; done < own.size;)
      {
        const Result<std::span<const double>> read = numbers.Next();
        KDSTREAM_TRY(read);
        std::for_each(read->begin(), read->end(), [&](double area) { sum += area; });
        done += read->size();
      }
      return {};
    };
    return status ? Take(this->Team.AddInOrder(add), states.area) : status;
  }

  // Blocks of a smaller depth: clusters move to the ranks that have these.
  Status MakeBlocks(LevelFile& level, LevelStates& states, unsigned blockDepth)
  {
    const std::vector<std::uint64_t> before =
      PlacesOfRanks(this->Team, level.begin, level.blockDepth);
    MergeBlocks(level, blockDepth);
    const std::vector<std::uint64_t> after = PlacesOfRanks(this->Team, level.begin, blockDepth);
    Status status;
    for (const ClusterFile& file : this->FilesOf(level, states))
    {
      status = status ? this->Team.Move(*file.file, file.elementBytes, before, after) : status;
    }
    return status;
  }

  // Writes the triangles and links of a level's blocks that are here. load(block, triangles): those
  // of a block of the finer level, or of the mesh, that is here; their corners are places in `map`,
  // where those of other ranks are filled in. finerBegin, finerDepth: of these blocks.
  template <class Load>
  Status WriteImages(LevelFile& level, const SpillFile& map, std::span<const VertexId> finerBegin,
    unsigned finerDepth, const Load& load)
  {
    const unsigned step = finerDepth - level.blockDepth;
    const BlockRange finerHere = this->Team.Here(finerDepth);
    const auto image = [&](std::size_t finer, std::vector<Triangle>& triangles)
    {
      std::vector<Triangle> added;
      Status status = load(finer, added);
      status = status ? MapCorners(added, map, finerBegin[finer], finerBegin[finer + 1]) : status;
      triangles.insert(triangles.end(), added.begin(), added.end());
      return status;
    };
    std::optional<RecordBuckets<Triangle>> received;
    Status status = this->SendImages(level, finerHere, step, image, received);
    ImageWriter writer(this->Folder, level);
    LevelLinks links;
    LinkWriter linkWriter(level, links);
    status = status ? writer.Begin(0) : status;
    status = status && this->Steps.ByClusters() ? linkWriter.Begin(this->Folder) : status;
    const BlockRange here = this->Team.Here(level.blockDepth);
    for (std::size_t block = 0; status && block < level.BlockCount(); ++block)
    {
      std::vector<Triangle> triangles;
      if (block >= here.begin && block < here.end)
      {
        const std::size_t end = std::min(finerHere.end, (block + 1) << step);
        for (std::size_t f = std::max(finerHere.begin, block << step); status && f < end; ++f)
        {
          status = image(f, triangles);
        }
        status = status && received ? received->ForEach(block - here.begin,
                                        [&](const Triangle& t) -> Status
                                        {
                                          triangles.push_back(t);
                                          return {};
                                        })
                                    : status;
      }
      status = status && this->Steps.ByClusters() ? linkWriter.Add(triangles) : status;
      status = status ? writer.Add(triangles) : status;
    }
    this->Links = std::move(links);
    return status ? this->FetchForeign(level) : status;
  }

  // The images of those finer blocks that are here but whose blocks in the level are not; `number`
  // is the block.
  template <class Image>
  Status SendImages(const LevelFile& level, const BlockRange& finerHere, unsigned step,
    const Image& image, std::optional<RecordBuckets<Triangle>>& received)
  {
    const BlockRange here = this->Team.Here(level.blockDepth);
    std::vector<std::size_t> away; // finer blocks
    for (std::size_t finer = finerHere.begin; finer < finerHere.end; ++finer)
    {
      if (this->Team.OwnerOf(finer >> step, level.blockDepth) != this->Team.Rank())
      {
        away.push_back(finer);
      }
    }
    Status status;
    if (here.begin < here.end)
    {
      Result<RecordBuckets<Triangle>> buckets = RecordBuckets<Triangle>::Create(
        this->Folder, "triangles of other ranks", here.end - here.begin, 0, this->Memory / 8);
      status = buckets ? Status{} : Status(buckets.GetError());
      if (buckets)
      {
        received.emplace(std::move(*buckets));
      }
    }
    const auto make = [&](std::uint64_t round, RankLists<NumberedTriangle>& out)
    {
      const std::size_t block = away[static_cast<std::size_t>(round)] >> step;
      std::vector<NumberedTriangle>& list = out[this->Team.OwnerOf(block, level.blockDepth)];
      std::vector<Triangle> triangles;
      const Status loaded = image(away[static_cast<std::size_t>(round)], triangles);
      for (const Triangle& t : triangles)
      {
        const bool line = t[0] == t[1] || t[1] == t[2] || t[2] == t[0];
        if (!line || (this->Steps.ByClusters() && (t[0] != t[1] || t[1] != t[2])))
        {
          list.push_back({ t, static_cast<std::uint32_t>(block) });
        }
      }
      return loaded;
    };
    const auto take = [&](std::size_t, std::span<const NumberedTriangle> triangles)
    {
      Status added;
      for (std::size_t i = 0; added && i < triangles.size(); ++i)
      {
        added = received->Add(triangles[i].number - here.begin, triangles[i].corners);
      }
      return added;
    };
    status =
      status ? this->Team.ExchangeInRounds<NumberedTriangle>(away.size(), make, take) : status;
    return status && received ? received->Finish() : status;
  }

  // What the blocks here use of other ranks' clusters.
  Status FetchForeign(LevelFile& level)
  {
    const BlockRange here = this->Team.Here(level.blockDepth);
    const CellRange own = this->RangeHere(level.begin, level.blockDepth);
    NumberSet<VertexId> foreign;
    const auto add = [&](VertexId c)
    {
      if (c < own.begin || c - own.begin >= own.size)
      {
        foreign.Add(c);
      }
    };
    for (std::size_t block = here.begin; block < here.end; ++block)
    {
      const Result<LevelBlock> loaded = LoadLevelBlock(level, block);
      KDSTREAM_TRY(loaded);
      const std::vector<VertexId> ghosts = loaded->Ghosts();
      std::for_each(ghosts.begin(), ghosts.end(), add);
      std::vector<Triangle> links;
      const Status status =
        this->Steps.ByClusters() ? this->Links.Load(block, block + 1, links) : Status{};
      KDSTREAM_TRY(status);
      for (const Triangle& link : links)
      {
        std::for_each(link.begin(), link.end(), add);
      }
    }
    level.foreign = foreign.Take();
    const auto fetch = [&](SpillFile& file, std::size_t elementBytes)
    {
      return elementBytes == 0
               ? Status{}
               : this->Team.Fetch(file, elementBytes, level.begin, level.blockDepth, level.foreign);
    };
    const Status status = fetch(level.clusters, sizeof(ClusterRecord));
    return status ? fetch(level.tuples, this->Steps.Arrays().TupleBytes()) : status;
  }

  // Level `depth` from the one below it.
  Status BuildCoarser(unsigned depth)
  {
    LevelFile& below = this->FileOf(depth + 1);
    LevelFile& level = this->FileOf(depth);
    level.depth = depth;
    LevelStates states;
    const CellRange belowHere = this->RangeHere(below.begin, below.blockDepth);
    Status status = this->MakeClusters(below, depth, states);
    level.blockDepth = below.blockDepth;
    status = status ? this->Settle(level, states, below.parents, belowHere) : status;
    this->States = std::move(states);
    if (status)
    {
      status = this->MakeBlocks(
        level, this->States, std::min(below.blockDepth, this->Steps.BlockDepthOf(depth, 62)));
    }
    if (status)
    {
      status = this->Team.Fetch(
        below.parents, sizeof(VertexId), below.begin, below.blockDepth, below.foreign);
    }
    if (status)
    {
      const LevelLinks links = std::move(this->Links);
      status = this->WriteImages(level, below.parents, below.begin, below.blockDepth,
        [&](std::size_t block, std::vector<Triangle>& triangles)
        {
          const std::uint64_t from = below.triangleBegin[block];
          triangles.resize(static_cast<std::size_t>(below.triangleBegin[block + 1] - from));
          const Status read =
            ReadRecords<Triangle>(below.triangles, from, std::span<Triangle>(triangles));
          return read && this->Steps.ByClusters() ? links.Load(block, block + 1, triangles) : read;
        });
    }
    // Nothing coarser is made of the level below any more.
    return status && depth < this->Mesh.depths.stitch ? this->MoveToFirst(depth + 1) : status;
  }

  Status MakeClusters(LevelFile& below, unsigned depth, LevelStates& states)
  {
    LevelFile& level = this->FileOf(depth);
    const LevelArrays& arrays = this->Steps.Arrays();
    LevelWriter writer(level, states, arrays);
    const Status status = writer.Begin(this->Folder, 0);
    const BlockRange here = this->Team.Here(below.blockDepth);
    level.begin.assign(here.begin + 1, below.begin[here.begin]);
    if (!status || this->Steps.ByClusters())
    {
      return status ? this->Steps.Join(
                        this->Folder, { below, this->States, this->Links, here }, depth, writer)
                    : status;
    }
    TeamLevelBlocks blocks(this->Team, this->Folder, below, this->States, arrays, level, writer);
    return this->Steps.Collapse(blocks, depth);
  }

  // All of a level that is needed whole, to rank 0: clusters, parents where there are any,
  // triangles, and of the coarsest so far the states and links too.
  Status MoveToFirst(unsigned depth)
  {
    LevelFile& level = this->FileOf(depth);
    const std::vector<std::uint64_t> before =
      PlacesOfRanks(this->Team, level.begin, level.blockDepth);
    std::vector<std::uint64_t> after(before.size(), level.ClusterCount());
    after[0] = 0;
    LevelStates none;
    const bool coarsest = !level.parents.IsOpen();
    std::vector<ClusterFile> files = this->FilesOf(level, coarsest ? this->States : none);
    files.push_back({ &level.parents, sizeof(VertexId) });
    Status status;
    for (const ClusterFile& file : files)
    {
      if (status && file.file->IsOpen())
      {
        status = this->Team.Move(*file.file, file.elementBytes, before, after);
      }
    }
    status = status ? this->ListOnFirst(level, level.triangles, level.triangleBegin) : status;
    return status && coarsest && this->Steps.ByClusters()
             ? this->ListOnFirst(level, this->Links.file, this->Links.begin)
             : status;
  }

  // A list of triangles in the order of a level's blocks, whole to rank 0. begin: of each block.
  Status ListOnFirst(const LevelFile& level, SpillFile& file, std::vector<std::uint64_t>& begin)
  {
    const BlockRange here = this->Team.Here(level.blockDepth);
    std::vector<std::uint64_t> counts(level.BlockCount(), 0);
    for (std::size_t block = here.begin; block < here.end; ++block)
    {
      counts[block] = begin[block + 1] - begin[block];
    }
    const Status summed = this->Team.Sum(counts);
    KDSTREAM_TRY(summed);
    std::vector<std::uint64_t> all{ 0 };
    for (const std::uint64_t count : counts)
    {
      all.push_back(all.back() + count);
    }
    std::vector<std::uint64_t> places; // on rank 0, of what comes next from each rank
    for (std::size_t rank = 0; rank < this->Team.Count(); ++rank)
    {
      places.push_back(all[this->Team.HereOf(rank, level.blockDepth).begin]);
    }
    const std::uint64_t from = begin[here.begin], size = begin[here.end] - from;
    const Status status = this->Team.ExchangeInRounds<Triangle>(
      this->Team.IsFirst() ? 0 : RoundsOf(size, trianglesOfRound),
      [&](std::uint64_t round, RankLists<Triangle>& out)
      {
        const std::uint64_t at = round * trianglesOfRound;
        out[0].resize(
          static_cast<std::size_t>(std::min<std::uint64_t>(trianglesOfRound, size - at)));
        return ReadRecords<Triangle>(file, from + at, std::span<Triangle>(out[0]));
      },
      [&](std::size_t rank, std::span<const Triangle> triangles)
      {
        const Status written = WriteRecords<Triangle>(file, places[rank], triangles);
        places[rank] += triangles.size();
        return written;
      });
    if (this->Team.IsFirst())
    {
      begin = std::move(all);
    }
    return status;
  }

  MpiTeam& Team;
  SpillFolder& Folder;
  const MeshBlocks& Mesh;
  const std::uint64_t Memory;
  const Execution& Exec;
  const std::function<void(const TreeBlock&)>& Seen;
  LevelSteps Steps;
  const std::size_t SumBytes;
  LevelStates States; // of the coarsest level so far
  LevelLinks Links;   // of the same; only by clusters
  ExternalLevels Output;
};

}

Result<ExternalLevels> BuildLevelsTogether(MpiTeam& team, SpillFolder& folder,
  const MeshBlocks& mesh, const LevelOptions& options, std::uint64_t memory,
  const Execution& execution, const std::function<void(const TreeBlock&)>& seen)
{
  return LevelsBuilder(team, folder, mesh, options, memory, execution, seen).Build();
}

}
