// The numbers of the vertex tree of a mesh that does not fit the memory. Step "number" out of core.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/Result.h"
#include "filters/core/VertexTree.h"
#include "filters/outofcore/BlockTeam.h"
#include "filters/outofcore/ExternalLevels.h"
#include "filters/outofcore/MeshBlocks.h"
#include "filters/outofcore/SpillFile.h"

#include <vector>

namespace kdstream
{

// What NumberVertices and OrderLeaves would say of the whole, in files; the levels 0 … S are not
// there, since their numbers follow quickly from the levels (NumberCoarseLevels).
struct ExternalNumbers
{
  // [depth]: of each cluster its lowest numbered vertex (VertexId); of the levels up to S closed.
  std::vector<SpillFile> first;
  SpillFile numberOfRank; // VertexId: of each original vertex, by rank, its number
};

// Numbers all clusters and vertices, from the top down: the levels 0 … S whole, every finer level
// by the blocks of its file, the original by those of the mesh. The same whatever the blocks are.
// A read of the links of each level and of the records of the mesh, a write of 4 bytes a cluster
// and vertex. O(n log n) for the largest block; memory: one block, about 45 bytes a vertex, and
// NumberCoarseLevels. Reports the step "levels" once for each four blocks, from 0 to 1. Errors:
// InputOutput; Damaged, naming the cluster, where numbers of clusters and vertices in the files do
// not fit together; Cancelled. REQUIRES: levels of this mesh, 0 … L; levels.firstInFiles <= S.
// team: each process numbers its own blocks; the levels up to S are with the first one.
Result<ExternalNumbers> NumberExternally(SpillFolder& folder, const MeshBlocks& mesh,
  const ExternalLevels& levels, const Execution& execution = {}, BlockTeam* team = nullptr);

// The numbers of the levels 0 … S.
struct CoarseNumbers
{
  std::vector<std::vector<VertexId>> first; // [depth <= S]: as in ExternalNumbers
  // Depths, beginnings of partitions, and of the levels 0 … S `first` and `parents`; nothing of the
  // finer ones and of the original.
  VertexTree tree;
};

// What NumberExternally begins with. O(c log c) for the c clusters of these levels, about 2^(S+1),
// sheets multiply them; 12 bytes a cluster are kept, 32 more are taken meanwhile; 4 bytes a
// partition. Errors, REQUIRES: NumberExternally.
// team: all get what the first one has.
Result<CoarseNumbers> NumberCoarseLevels(
  const MeshBlocks& mesh, const ExternalLevels& levels, BlockTeam* team = nullptr);

}
