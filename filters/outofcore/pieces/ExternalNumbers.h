// SPDX-License-Identifier: BSD-3-Clause
// The numbers of the vertex tree of a mesh that does not fit the memory. Step "number" out of core.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/Result.h"
#include "filters/outofcore/files/SpillFile.h"
#include "filters/outofcore/levels/BlockGroup.h"
#include "filters/outofcore/levels/ExternalLevels.h"
#include "filters/outofcore/mesh/MeshBlocks.h"

#include <cstdint>
#include <vector>

namespace kdstream
{

// A cluster of a level <= S, by rank.
struct RankedCluster
{
  VertexId first = 0;      // lowest numbered vertex
  VertexId parentRank = 0; // of the next coarser level
};

// The ReachedNodes of a level's clusters, by number, block after block.
struct ChildNodeFile
{
  SpillFile nodes;
  std::vector<std::uint64_t> begin; // of each block, and the end
};

// What NumberVertices and OrderLeaves would say of the whole, in files; of the levels above those
// in files it follows quickly (CoarseTree, CoarseNumbers.h).
struct ExternalNumbers
{
  // [depth], of the levels in files. The last three up to S only.
  std::vector<SpillFile> first;          // VertexId: of each cluster its lowest numbered vertex
  std::vector<SpillFile> ranks;          // VertexId: of each cluster its rank (VertexTreeLevel)
  std::vector<SpillFile> ranked;         // RankedCluster
  std::vector<ChildNodeFile> childNodes; // ChildNode: of levels that have it (HasChildNodes)
  SpillFile numberOfRank; // VertexId: of each original vertex, by its rank in the tree, its number
};

// Numbers all clusters and vertices, from the top down: every level by the blocks of its file, the
// original by those of the mesh. The same whatever the blocks are. A read of the links of each
// level, three of those up to S, and of the records of the mesh; a write of 4 bytes a cluster (20
// up to S) and vertex. O(n log n) for the largest block; memory: one block, about 45 bytes a
// vertex, and the levels above those in files. Reports the step "levels" once for each four blocks
// finer than S, from 0 to 1. Errors: InputOutput; Damaged, naming the cluster, where numbers of
// clusters and vertices in the files do not fit together; Cancelled.
// REQUIRES: levels of this mesh, 0 … L; levels.firstInFiles <= S; of a level in files up to S no
// cluster in two blocks, nor siblings unless their parent is above the files.
// group: each process numbers its own blocks; the levels up to S are with the first one.
Result<ExternalNumbers> NumberExternally(SpillFolder& folder, const MeshBlocks& mesh,
  const ExternalLevels& levels, const Execution& execution = {}, BlockGroup* group = nullptr);

}
