// SPDX-License-Identifier: BSD-3-Clause
#include "filters/outofcore/levels/FileLevelBlocks.h"

#include "filters/outofcore/files/ScatteredRead.h"

#include <algorithm>

namespace kdstream
{

FileLevelBlocks::FileLevelBlocks(SpillFolder& folder, LevelFile& below, const LevelStates& states,
  const LevelArrays& arrays, LevelFile& coarser, LevelWriter& writer)
  : Folder(folder)
  , Below(below)
  , States(states)
  , Arrays(arrays)
  , Coarser(coarser)
  , Writer(writer)
  , Kept(below.BlockCount())
{
}

Status FileLevelBlocks::Begin()
{
  const std::uint64_t bytes = this->Below.ClusterCount() * std::uint64_t{ sizeof(VertexId) };
  for (SpillFile* const file : { &this->Targets[0], &this->Targets[1], &this->Below.parents })
  {
    Result<SpillFile> made = this->Folder.CreateFile(
      file == &this->Below.parents ? "parents of clusters" : "targets of clusters",
      file == &this->Below.parents ? bytes : 0);
    KDSTREAM_TRY(made);
    *file = std::move(*made);
  }
  return {};
}

double FileLevelBlocks::AreaPerCluster() const
{
  return this->States.area / double(this->Below.ClusterCount());
}

Result<FileLevelBlocks::LoadedBlock> FileLevelBlocks::LoadFiles(std::size_t block) const
{
  Result<LevelBlock> loaded = LoadLevelBlock(this->Below, block);
  KDSTREAM_TRY(loaded);
  Result<CollapseState> state = LoadState(this->Below, this->States, this->Arrays, *loaded);
  KDSTREAM_TRY(state);
  return LoadedBlock{ std::move(*loaded), std::move(*state) };
}

void FileLevelBlocks::LoadAhead(std::size_t block)
{
  this->Next.emplace(this->LoadFiles(block));
  this->Ahead = block;
}

Result<const CollapseState*> FileLevelBlocks::Load(std::size_t block)
{
  if (block != this->Loaded)
  {
    this->Loaded = none;
    this->Current = {}; // freed before the next block is loaded
    if (block != this->Ahead)
    {
      this->Next.reset();
      this->LoadAhead(block);
    }
    Result<LoadedBlock> loaded = std::move(*this->Next);
    this->Next.reset();
    this->Ahead = none;
    KDSTREAM_TRY(loaded);
    this->Current = std::move(*loaded);
    this->Loaded = block;
  }
  return &this->Current.state;
}

Status FileLevelBlocks::KeepLists(std::size_t block, std::vector<MergeList>&& lists)
{
  KeptLists kept;
  std::uint64_t all = 0;
  for (const MergeList& list : lists)
  {
    kept.counts.push_back(static_cast<std::uint32_t>(list.merges.size()));
    kept.heads.push_back({ {}, list.own, list.stuck, list.whole });
    all += list.merges.size();
  }
  Result<SpillFile> file = this->Folder.CreateFile("merges", all * sizeof(Merge));
  KDSTREAM_TRY(file);
  kept.merges = std::move(*file);
  RecordWriter<Merge> writer(kept.merges);
  for (const MergeList& list : lists)
  {
    for (const Merge& merge : list.merges)
    {
      writer.Append(merge);
    }
  }
  KDSTREAM_TRY(writer.Finish());
  this->Kept[block] = std::move(kept);
  this->CurrentLists = std::move(lists);
  this->LoadedLists = block;
  return {};
}

Result<std::vector<MergeList>*> FileLevelBlocks::Lists(std::size_t block)
{
  if (block != this->LoadedLists)
  {
    this->LoadedLists = none;
    const KeptLists& kept = this->Kept[block];
    this->CurrentLists = kept.heads;
    std::uint64_t first = 0;
    for (std::size_t i = 0; i < this->CurrentLists.size(); ++i)
    {
      std::vector<Merge>& merges = this->CurrentLists[i].merges;
      merges.resize(kept.counts[i]);
      KDSTREAM_TRY(ReadRecords<Merge>(kept.merges, first, std::span<Merge>(merges)));
      first += merges.size();
    }
    this->LoadedLists = block;
  }
  return &this->CurrentLists;
}

Status FileLevelBlocks::KeepTargets(
  std::size_t block, TargetStage stage, std::span<const VertexId> targets)
{
  const VertexId first = this->Below.begin[block];
  std::vector<VertexId> numbers(targets.size());
  std::transform(targets.begin(), targets.end(), numbers.begin(),
    [&](VertexId target) { return first + target; });
  return WriteRecords<VertexId>(
    this->Targets[static_cast<std::size_t>(stage)], first, std::span<const VertexId>(numbers));
}

Result<std::vector<VertexId>> FileLevelBlocks::GhostTargets(TargetStage stage)
{
  const std::vector<VertexId> ghosts = this->Current.block.Ghosts();
  std::vector<VertexId> targets(ghosts.size());
  KDSTREAM_TRY(ReadRecordsAt<VertexId>(
    this->Targets[static_cast<std::size_t>(stage)], ghosts, std::span<VertexId>(targets)));
  return targets;
}

Status FileLevelBlocks::KeepCoarser(
  std::size_t block, CollapseState&& coarser, std::vector<VertexId>&& parents)
{
  const VertexId first = this->Below.begin[block], base = this->Coarser.begin.back();
  Result<AttributeSums> sums = LoadAttributeSums(this->States, this->Arrays, first, parents.size());
  KDSTREAM_TRY(sums);
  const std::span<const VertexId> lowest = std::span(this->Current.state.level.lowest)
                                             .subspan(this->Current.state.ownBegin, parents.size());
  KDSTREAM_TRY(
    this->Writer.Append(coarser, sums->MakeCoarser(parents, lowest, coarser.clusters.size())));
  for (VertexId& parent : parents)
  {
    parent += base;
  }
  return WriteRecords<VertexId>(this->Below.parents, first, std::span<const VertexId>(parents));
}

}
