// SPDX-License-Identifier: BSD-3-Clause
// LevelBlocks (core/levels) on several ranks: a round of collapses (CollapseRound) goes through
// this rank's blocks, and what blocks of other ranks need is sent to them. For DistributedLevels.
#pragma once

#include "filters/Parallel/MpiGroup.h"
#include "filters/outofcore/levels/FileLevelBlocks.h"

#include <cstddef>
#include <cstdint>
#include <span>

namespace kdstream
{

// Between the passes of a round, the ranks exchange two things: the costs in parts of the level,
// and the targets of clusters that other ranks use. Errors: InputOutput; those of MpiGroup.
class DistributedLevelBlocks : public FileLevelBlocks
{
public:
  // Keeps references to all arguments.
  DistributedLevelBlocks(MpiGroup& group, SpillFolder& folder, LevelFile& below,
    const LevelStates& states, const LevelArrays& arrays, LevelFile& coarser, LevelWriter& writer)
    : FileLevelBlocks(folder, below, states, arrays, coarser, writer)
    , Group(group)
  {
  }

  BlockRange Here() const override { return this->Group.Here(this->Below.blockDepth); }
  bool Alone() const override { return false; }
  Status Sum(std::span<std::uint64_t> numbers) override { return this->Group.Sum(numbers); }
  Status ShareParts(std::span<std::byte> parts) override
  {
    return this->Group.Share(parts, this->Below.blockDepth);
  }
  Status ShareTargets(TargetStage stage) override
  {
    return this->Group.Fetch(this->Targets[static_cast<std::size_t>(stage)], sizeof(VertexId),
      this->Below.begin, this->Below.blockDepth, this->Below.foreign);
  }

private:
  MpiGroup& Group;
};

}
