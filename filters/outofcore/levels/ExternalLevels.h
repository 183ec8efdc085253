// SPDX-License-Identifier: BSD-3-Clause
// The levels of a mesh that does not fit in memory: step "levels" of building out of core.
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
  // The levels firstInFiles … L are files[depth]. S is one of them; S is coarser only if all levels
  // are in files (firstInFiles <= S). The coarser levels, 0 … firstInFiles - 1, are coarse[depth],
  // whole.
  unsigned firstInFiles = 0;
  std::vector<LevelFile> files;
  std::vector<ClusterLevel> coarse;
  SpillFile clusterOfRank;               // VertexId: the cluster of level L of each vertex, by rank
  std::vector<AttributeInfo> attributes; // that levels carry (ArraysOfLevels), in the mesh's order
};

// Builds the levels L … 0 of a mesh in blocks, either by rounds of collapse or by clusters of cells
// (LevelMaker; always the latter for a cloud). For any blocks, the levels are bit for bit those
// that BuildLevels makes in memory. Blocks of a level are larger than those of the mesh if they
// need no more memory. Each block is loaded about three times; when levels are made by clusters,
// once.
//
// Memory: one block, about 520 bytes a cluster and 220 a vertex, and the next block while it is
// being loaded. Levels coarser than S with up to 2^16 clusters (sometimes four times as many; 2^14
// when made by clusters) are whole in memory. seen: called once with every block of the mesh,
// ascending, while the block is in memory. Errors: InputOutput; Cancelled.
Result<ExternalLevels> BuildExternalLevels(SpillFolder& folder, const MeshBlocks& mesh,
  const LevelOptions& options, const Execution& execution = {},
  const std::function<void(const TreeBlock&)>& seen = {});

}
