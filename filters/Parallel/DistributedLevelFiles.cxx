// SPDX-License-Identifier: BSD-3-Clause
#include "filters/Parallel/DistributedLevelFiles.h"

#include "filters/Parallel/DistributedFiles.h"
#include "filters/core/TakeResult.h"
#include "filters/outofcore/files/RecordFile.h"

#include <algorithm>

namespace kdstream
{
namespace
{

// Moves `count` elements to a lower place in the file.
Status MoveDown(SpillFile& file, std::size_t elementBytes, std::uint64_t from, std::uint64_t to,
  std::uint64_t count)
{
  const std::uint64_t bytes = from == to ? 0 : count * elementBytes;
  std::vector<std::byte> block;
  for (std::uint64_t at = 0; at < bytes; at += block.size())
  {
    block.resize(static_cast<std::size_t>(std::min<std::uint64_t>(spillBlockBytes, bytes - at)));
    KDSTREAM_TRY(file.Read(from * elementBytes + at, block));
    KDSTREAM_TRY(file.Write(to * elementBytes + at, block));
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

}

DistributedLevelFiles::DistributedLevelFiles(
  MpiGroup& group, SpillFolder& folder, const LevelArrays& arrays, bool byClusters)
  : Group(group)
  , Folder(folder)
  , Arrays(arrays)
  , ByClusters(byClusters)
  , SumBytes(AttributeSums(arrays.attributes, 0).RecordSize())
{
}

CellRange DistributedLevelFiles::RangeHere(std::span<const VertexId> begin, unsigned depth) const
{
  const BlockRange here = this->Group.Here(depth);
  return { begin[here.begin], begin[here.end] - begin[here.begin] };
}

std::vector<DistributedLevelFiles::ClusterFile> DistributedLevelFiles::FilesOf(
  LevelFile& level, LevelStates& states) const
{
  std::vector<ClusterFile> files{ { &level.clusters, sizeof(ClusterRecord) },
    { &level.tuples, this->Arrays.TupleBytes() }, { &states.sums, sizeof(ClusterState) },
    { &states.components, this->Arrays.components * sizeof(float) },
    { &states.attributeSums, this->SumBytes } };
  std::erase_if(files, [](const ClusterFile& file) { return file.elementBytes == 0; });
  return files;
}

Status DistributedLevelFiles::Settle(
  LevelFile& level, LevelStates& states, SpillFile& map, const CellRange& mapped)
{
  const VertexId before = level.begin[this->Group.Here(level.blockDepth).begin];
  KDSTREAM_TRY(this->CountClusters(level));
  const CellRange own = this->RangeHere(level.begin, level.blockDepth);
  const VertexId down = own.size == 0 ? 0 : before - static_cast<VertexId>(own.begin);
  for (const ClusterFile& file : this->FilesOf(level, states))
  {
    KDSTREAM_TRY(MoveDown(*file.file, file.elementBytes, before, own.begin, own.size));
  }
  KDSTREAM_TRY(CountDown(map, mapped, down));
  return this->ByClusters ? Status{} : this->AddUpArea(states, own);
}

// Finds where the clusters of each block begin, over all ranks. Before, each rank knows only its
// own.
Status DistributedLevelFiles::CountClusters(LevelFile& level)
{
  const BlockRange here = this->Group.Here(level.blockDepth);
  std::vector<std::uint64_t> counts(level.BlockCount(), 0);
  for (std::size_t block = here.begin; block < here.end; ++block)
  {
    counts[block] = level.begin[block + 1] - level.begin[block];
  }
  KDSTREAM_TRY(this->Group.Sum(counts));
  level.begin.assign(1, 0);
  for (const std::uint64_t count : counts)
  {
    level.begin.push_back(level.begin.back() + static_cast<VertexId>(count));
  }
  return {};
}

// Adds up areas in the order of the clusters over all ranks. The areas are put into a file first,
// so that the other ranks wait less while a rank adds its own.
Status DistributedLevelFiles::AddUpArea(LevelStates& states, const CellRange& own)
{
  SpillFile file;
  KDSTREAM_TRY(Take(this->Folder.CreateFile("areas of clusters", 0), file));
  RecordWriter<double> areas(file);
  KDSTREAM_TRY(ForEachBlockOf<ClusterState>(states.sums, own.begin, own.begin + own.size,
    [&](std::span<const ClusterState> clusters)
    {
      for (const ClusterState& cluster : clusters)
      {
        areas.Append(cluster.sum.quadric.Trace());
      }
    }));
  KDSTREAM_TRY(areas.Finish());
  const auto add = [&](double& sum)
  {
    return ForEachBlockOf<double>(file, 0, own.size,
      [&](std::span<const double> numbers)
      { std::for_each(numbers.begin(), numbers.end(), [&](double area) { sum += area; }); });
  };
  return Take(this->Group.AddInOrder(add), states.area);
}

Status DistributedLevelFiles::MakeBlocks(LevelFile& level, LevelStates& states, unsigned blockDepth)
{
  const NodeShares& shares = this->Group.Shares();
  const std::vector<std::uint64_t> before = shares.PlacesOf(level.begin, level.blockDepth);
  MergeBlocks(level, blockDepth);
  const std::vector<std::uint64_t> after = shares.PlacesOf(level.begin, blockDepth);
  for (const ClusterFile& file : this->FilesOf(level, states))
  {
    KDSTREAM_TRY(MoveElements(this->Group, *file.file, file.elementBytes, before, after));
  }
  return {};
}

Status DistributedLevelFiles::MoveToFirst(LevelFile& level, LevelStates& states, LevelLinks& links)
{
  const std::vector<std::uint64_t> before =
    this->Group.Shares().PlacesOf(level.begin, level.blockDepth);
  std::vector<std::uint64_t> after(before.size(), level.ClusterCount());
  after[0] = 0;
  LevelStates none;
  const bool coarsest = !level.parents.IsOpen();
  std::vector<ClusterFile> files = this->FilesOf(level, coarsest ? states : none);
  files.push_back({ &level.parents, sizeof(VertexId) });
  for (const ClusterFile& file : files)
  {
    if (file.file->IsOpen())
    {
      KDSTREAM_TRY(MoveElements(this->Group, *file.file, file.elementBytes, before, after));
    }
  }
  KDSTREAM_TRY(this->ListToFirst(level, level.triangles, level.triangleBegin));
  return coarsest && this->ByClusters ? this->ListToFirst(level, links.file, links.begin)
                                      : Status{};
}

// Sends a list of triangles, in the order of a level's blocks, to rank 0. begin: of each block.
Status DistributedLevelFiles::ListToFirst(
  const LevelFile& level, SpillFile& file, std::vector<std::uint64_t>& begin)
{
  const BlockRange here = this->Group.Here(level.blockDepth);
  std::vector<std::uint64_t> counts(level.BlockCount(), 0);
  for (std::size_t block = here.begin; block < here.end; ++block)
  {
    counts[block] = begin[block + 1] - begin[block];
  }
  KDSTREAM_TRY(this->Group.Sum(counts));
  std::vector<std::uint64_t> all{ 0 };
  for (const std::uint64_t count : counts)
  {
    all.push_back(all.back() + count);
  }
  std::vector<std::uint64_t> places; // on rank 0: where the list of each rank goes
  for (std::size_t rank = 0; rank < this->Group.Count(); ++rank)
  {
    places.push_back(all[this->Group.Shares().BlocksOf(rank, level.blockDepth).begin]);
  }
  const std::uint64_t from = begin[here.begin], size = begin[here.end] - from;
  if (this->Group.IsFirst())
  {
    begin = std::move(all);
  }
  return this->SendToFirst(file, from, this->Group.IsFirst() ? 0 : size, std::move(places));
}

// Sends the triangles [from, from + size) of a file to rank 0, which writes those of a rank at
// places[rank].
Status DistributedLevelFiles::SendToFirst(
  SpillFile& file, std::uint64_t from, std::uint64_t size, std::vector<std::uint64_t> places)
{
  constexpr std::size_t ofRound = ElementsOfRound(sizeof(Triangle));
  const auto make = [&](std::uint64_t round, RankLists<Triangle>& out)
  {
    const std::uint64_t at = round * ofRound;
    out[0].resize(static_cast<std::size_t>(std::min<std::uint64_t>(ofRound, size - at)));
    return ReadRecords<Triangle>(file, from + at, std::span<Triangle>(out[0]));
  };
  const auto take = [&](std::size_t rank, std::span<const Triangle> triangles)
  {
    const std::uint64_t place = places[rank];
    places[rank] += triangles.size();
    return WriteRecords<Triangle>(file, place, triangles);
  };
  return this->Group.ExchangeInRounds<Triangle>(RoundsOf(size, ofRound), make, take);
}

}
