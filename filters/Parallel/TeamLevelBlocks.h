// SPDX-License-Identifier: BSD-3-Clause
// LevelBlocks (core/levels) over ranks: lets a round of collapses (CollapseRound) go through the
// blocks that this rank has, and tells the others what theirs need to know. For TeamLevels.
#pragma once

#include "filters/Parallel/MpiTeam.h"
#include "filters/outofcore/levels/FileLevelBlocks.h"

#include <cstddef>
#include <cstdint>
#include <span>

namespace kdstream
{

// Between the passes of a round the ranks tell each other what parts of the level cost, and where
// clusters go that others use. Errors: InputOutput; MpiTeam's.
class TeamLevelBlocks : public FileLevelBlocks
{
public:
  // Keeps references to all.
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

}
