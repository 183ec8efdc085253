// SPDX-License-Identifier: BSD-3-Clause
// The numbers of the levels 0 … S, for a mesh that does not fit in memory. Step "number" out of
// core.
//
// A cluster's lowest number follows from those of level S. So these levels are processed block by
// block: first level S is numbered; then lowest numbers are passed up, and ranks and child pieces
// down.
#pragma once

#include "filters/core/Result.h"
#include "filters/core/pieces/VertexTree.h"
#include "filters/outofcore/files/SpillFile.h"
#include "filters/outofcore/levels/BlockGroup.h"
#include "filters/outofcore/levels/ExternalLevels.h"
#include "filters/outofcore/mesh/MeshBlocks.h"
#include "filters/outofcore/pieces/ExternalNumbers.h"

#include <cstddef>
#include <span>
#include <vector>

namespace kdstream
{

// Numbers the levels in files up to S. O(c log c) for their c clusters: about 2^(S+1), more with
// components. Memory: one block of a level, about 70 bytes a cluster; 12 bytes a cluster of the
// levels above those in files; 4 bytes a partition. Errors: InputOutput; Damaged (ReadLinks).
// group: the first process does the work, and all processes get what finer levels and CoarseTree
// need.
Status NumberCoarseLevels(SpillFolder& folder, const MeshBlocks& mesh, const ExternalLevels& levels,
  ExternalNumbers& numbers, BlockGroup& group);

// For CoarseTree:

// The lowest numbered vertices of the clusters of the levels above those in files, [depth], by
// number of cluster.
Result<std::vector<std::vector<VertexId>>> FirstAboveFiles(
  const ExternalLevels& levels, const ExternalNumbers& numbers);

// The child nodes of the clusters one level above a block of level `depth`, by number of cluster.
// tree: only its depths and partitionBegin are used.
Result<std::vector<ChildNode>> ReadChildNodesOfParents(const ExternalLevels& levels,
  const ExternalNumbers& numbers, const VertexTree& tree, unsigned depth, std::size_t block);

// The part of the tree that ReadChildNodesOfParents uses: 4 bytes a partition.
VertexTree TreeOfPartitions(const MeshBlocks& mesh);

// The first vertex of each partition of a cell, and the end.
std::vector<VertexId> PartitionsOfCell(const MeshBlocks& mesh, unsigned depth, std::size_t cell);

}
