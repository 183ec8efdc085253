// SPDX-License-Identifier: BSD-3-Clause
// Gives a round of collapses access to a level in files. Only for the levels out of core.
#pragma once

#include "filters/core/levels/LevelBlocks.h"
#include "filters/outofcore/levels/LevelStates.h"

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

namespace kdstream
{

// Makes the clusters of the coarser level from the blocks of a round; the caller makes its
// triangles.
class FileLevelBlocks : public LevelBlocks
{
public:
  // Keeps references to all arguments. coarser: clusters are appended to it, block by block.
  FileLevelBlocks(SpillFolder& folder, LevelFile& below, const LevelStates& states,
    const LevelArrays& arrays, LevelFile& coarser, LevelWriter& writer);
  // Makes the files. Errors: InputOutput.
  Status Begin();

  std::size_t Count() const override { return this->Below.BlockCount(); }
  double AreaPerCluster() const override;
  void LoadAhead(std::size_t block) override;
  Result<const CollapseState*> Load(std::size_t block) override;
  Status KeepLists(std::size_t block, std::vector<MergeList>&& lists) override;
  Result<std::vector<MergeList>*> Lists(std::size_t block) override;
  Status KeepTargets(
    std::size_t block, TargetStage stage, std::span<const VertexId> targets) override;
  Result<std::vector<VertexId>> GhostTargets(TargetStage stage) override;
  Status KeepCoarser(
    std::size_t block, CollapseState&& coarser, std::vector<VertexId>&& parents) override;

protected:
  // The merge lists of a block in a file: all merges of the first list, then all of the second.
  struct KeptLists
  {
    SpillFile merges;
    std::vector<MergeList> heads; // without their merges
    std::vector<std::uint32_t> counts;
  };
  struct LoadedBlock
  {
    LevelBlock block; // its triangles have moved into the state
    CollapseState state;
  };
  static constexpr std::size_t none = std::numeric_limits<std::size_t>::max();

  Result<LoadedBlock> LoadFiles(std::size_t block) const;

  SpillFolder& Folder;
  LevelFile& Below;
  const LevelStates& States;
  const LevelArrays& Arrays;
  LevelFile& Coarser;
  LevelWriter& Writer;
  std::vector<KeptLists> Kept;      // of each block, the lists kept in a file
  std::array<SpillFile, 2> Targets; // VertexId, by stage
  std::size_t Loaded = none;        // the block in Current
  LoadedBlock Current;
  std::size_t Ahead = none; // the block in Next
  std::optional<Result<LoadedBlock>> Next;
  std::size_t LoadedLists = none;
  std::vector<MergeList> CurrentLists;
};

}
