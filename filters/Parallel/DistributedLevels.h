// SPDX-License-Identifier: BSD-3-Clause
// The levels of a mesh whose blocks are on several ranks: step "levels" of a parallel build.
#pragma once

#include "filters/Parallel/MpiGroup.h"
#include "filters/core/Execution.h"
#include "filters/core/levels/Levels.h"
#include "filters/outofcore/levels/ExternalLevels.h"
#include "filters/outofcore/mesh/MeshBlocks.h"

#include <functional>

namespace kdstream
{

// Builds the levels L … 0, by either maker: bit for bit the levels that BuildExternalLevels makes
// of the whole mesh. Each rank makes its own blocks of each level. If the next coarser level needs
// larger blocks, they move to the rank that has their first node. In the end rank 0 has all levels
// up to S. Of the finer levels each rank has its blocks; of the foreign clusters that these use
// (LevelFile::foreign) it has what rounds and pieces need. Memory: as BuildExternalLevels; `memory`
// for searches and messages; 4 bytes for each foreign cluster. Errors: InputOutput; Cancelled;
// those of MpiGroup. seen: called with every block of the mesh of this rank.
Result<ExternalLevels> BuildLevelsCollectively(MpiGroup& group, SpillFolder& folder,
  const MeshBlocks& mesh, const LevelOptions& options, std::uint64_t memory,
  const Execution& execution, const std::function<void(const TreeBlock&)>& seen);

}
