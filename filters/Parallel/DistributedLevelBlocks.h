// SPDX-License-Identifier: BSD-3-Clause
// LevelBlocks (core/levels) over ranks: lets a round of collapses (CollapseRound) go through this
// rank's blocks, and sends the other ranks what their blocks need to know. For DistributedLevels.
#pragma once

#include "filters/Parallel/MpiGroup.h"
#include "filters/outofcore/levels/FileLevelBlocks.h"

#include <cstddef>
#include <cstdint>
#include <span>

namespace kdstream
{

// Between the passes of a round the ranks exchange two things: what parts of the level cost, and
// where the clusters go that other ranks use. Errors: InputOutput; MpiGroup's.
class DistributedLevelBlocks : public FileLevelBlocks
{
public:
  // Keeps references to all.
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
