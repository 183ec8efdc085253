// SPDX-License-Identifier: BSD-3-Clause
// The levels of a mesh whose blocks lie on several ranks: step "levels" of a parallel build.
#pragma once

#include "filters/Parallel/MpiGroup.h"
#include "filters/core/Execution.h"
#include "filters/core/levels/Levels.h"
#include "filters/outofcore/levels/ExternalLevels.h"
#include "filters/outofcore/mesh/MeshBlocks.h"

#include <functional>

namespace kdstream
{

// Builds the levels L … 0, by either maker: to the bit what BuildExternalLevels makes of the whole.
// Each rank makes its own blocks of each level; where the next coarser level needs larger ones they
// move to the rank of their first node. The levels up to S end on rank 0, whole; of the others each
// rank has its blocks, and of the clusters that these use of others (LevelFile::foreign) what
// rounds and pieces need. Memory: as BuildExternalLevels; `memory`, for what is looked for or
// carried beside that; 4 bytes for each of the others' clusters. Errors: InputOutput; Cancelled;
// MpiGroup's. seen: called with every block of the mesh that is here.
Result<ExternalLevels> BuildLevelsCollectively(MpiGroup& group, SpillFolder& folder,
  const MeshBlocks& mesh, const LevelOptions& options, std::uint64_t memory,
  const Execution& execution, const std::function<void(const TreeBlock&)>& seen);

}
