// SPDX-License-Identifier: BSD-3-Clause
// The levels of a mesh that does not fit the memory: step "levels" of building out of core.
#pragma once

#include "filters/core/levels/Levels.h"
#include "filters/outofcore/files/SpillFile.h"
#include "filters/outofcore/levels/LevelFile.h"
#include "filters/outofcore/mesh/MeshBlocks.h"

#include <functional>
#include <vector>

namespace kdstream
{

struct ExternalLevels
{
  // The levels firstInFiles … L are files[depth]. S is one of them; it is coarser only if all
  // levels are in files (firstInFiles <= S). The coarser levels, 0 … firstInFiles - 1, are
  // coarse[depth], whole.
  unsigned firstInFiles = 0;
  std::vector<LevelFile> files;
  std::vector<ClusterLevel> coarse;
  SpillFile clusterOfRank; // VertexId: of each vertex, by rank, its cluster of level L
  std::vector<AttributeInfo> attributes; // that levels carry (ArraysOfLevels), in the mesh's order
};

// Builds the levels L … 0 of a mesh in blocks: bit for bit the levels that BuildLevels makes in
// memory, for any blocks; by rounds of collapse, or by clusters of cells (LevelMaker, and for a
// cloud). Blocks of a level are larger than the mesh's, if they need no more memory. Each is loaded
// about three times, with clusters once.
//
// Memory: a block at a time, about 520 bytes a cluster and 220 a vertex, and the next one while it
// is loaded. Coarser than S, levels of up to 2^16 clusters (sometimes four times as many; with
// clusters 2^14) are whole in memory. seen: called once with every block of the mesh, ascending,
// while it is in memory. Errors: InputOutput; Cancelled.
Result<ExternalLevels> BuildExternalLevels(SpillFolder& folder, const MeshBlocks& mesh,
  const LevelOptions& options, const Execution& execution = {},
  const std::function<void(const TreeBlock&)>& seen = {});

}
