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

// The results of NumberVertices and OrderLeaves for a mesh that does not fit the memory, in files.
// Those of the levels that are not in files follow quickly from them (CoarseTree, CoarseNumbers.h).
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
// original by those of the mesh. The result does not depend on the blocks. Reads the parents of
// each level once (of those up to S three times), and the records of the mesh once; writes 4 bytes
// a cluster (20 up to S) and 4 a vertex. O(n log n) for the largest block; memory: one block, about
// 45 bytes a vertex, and the levels above those in files. Reports the step "levels" once for each
// four blocks finer than S, from 0 to 1. Errors: InputOutput; Damaged, naming the cluster, if
// numbers of clusters and vertices in the files contradict each other; Cancelled. REQUIRES: levels
// of this mesh, 0 … L; levels.firstInFiles <= S; in a level in files up to S no cluster is in two
// blocks, and neither are siblings, unless their parent's level is not in files. group: each
// process numbers its own blocks; the first one also the levels up to S.
Result<ExternalNumbers> NumberExternally(SpillFolder& folder, const MeshBlocks& mesh,
  const ExternalLevels& levels, const Execution& execution = {}, BlockGroup* group = nullptr);

}
