// SPDX-License-Identifier: BSD-3-Clause
// The numbers of the vertex tree, for a mesh that does not fit in memory. Step "number" out of
// core.
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
  VertexId parentRank = 0; // rank of its parent in the next coarser level
};

// The ReachedNodes of the clusters of a level, by number of cluster, block after block.
struct ChildNodeFile
{
  SpillFile nodes;
  std::vector<std::uint64_t> begin; // of each block, and the end
};

// The results of NumberVertices and OrderLeaves for a mesh that does not fit in memory, in files.
// For levels that are not in files they are quickly computed from these (CoarseTree,
// CoarseNumbers.h).
struct ExternalNumbers
{
  // All are indexed by [depth] of a level in files. The last three are only for levels up to S.
  std::vector<SpillFile> first;          // VertexId: lowest numbered vertex of each cluster
  std::vector<SpillFile> ranks;          // VertexId: rank of each cluster (VertexTreeLevel)
  std::vector<SpillFile> ranked;         // RankedCluster
  std::vector<ChildNodeFile> childNodes; // ChildNode: for levels that have child nodes
                                         // (HasChildNodes)
  SpillFile numberOfRank; // VertexId: number of each original vertex, by its rank in the tree
};

// Numbers all clusters and vertices from the top down: each level by the blocks of its file, the
// original by the blocks of the mesh. The result does not depend on the blocks. Reads the parents
// of each level once (up to S three times), and the records of the mesh once. Writes 4 bytes a
// cluster (20 up to S) and 4 bytes a vertex. O(n log n) for the largest block. Memory: one block,
// about 45 bytes a vertex, and the levels above those in files. For levels finer than S and the
// mesh, reports the step "levels" once for every four blocks, from 0 to 1. Errors: InputOutput;
// Damaged, naming the cluster, if numbers of clusters and vertices in the files contradict each
// other; Cancelled. REQUIRES: levels of this mesh, 0 … L; levels.firstInFiles <= S. In a level in
// files up to S, no cluster may be in two blocks, and neither may siblings, unless their parent's
// level is not in files. group: each process numbers its own blocks; the first process also numbers
// the levels up to S.
Result<ExternalNumbers> NumberExternally(SpillFolder& folder, const MeshBlocks& mesh,
  const ExternalLevels& levels, const Execution& execution = {}, BlockGroup* group = nullptr);

}
