// SPDX-License-Identifier: BSD-3-Clause
// The numbers of the levels 0 … S of a mesh that does not fit the memory. Step "number" out of
// core.
//
// A cluster's lowest number follows from those of level S. So these levels are processed block by
// block: level S is numbered, then lowest numbers follow upward, and ranks and child pieces
// downward.
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

// Numbers the levels in files up to S. O(c log c) for their c clusters, about 2^(S+1), more with
// components. Memory: a block of a level at a time, about 70 bytes a cluster; the levels above the
// files, 12 bytes a cluster; 4 bytes a partition. Errors: InputOutput; Damaged (ReadLinks). group:
// the first process does the work, and all get what finer levels and CoarseTree need.
Status NumberCoarseLevels(SpillFolder& folder, const MeshBlocks& mesh, const ExternalLevels& levels,
  ExternalNumbers& numbers, BlockGroup& group);

// For CoarseTree:

// The lowest numbered vertices of the clusters above the files, [depth], by number of cluster.
Result<std::vector<std::vector<VertexId>>> FirstAboveFiles(
  const ExternalLevels& levels, const ExternalNumbers& numbers);

// For the clusters above those of a block of level `depth` their child nodes, by number of cluster.
// tree: only its depths and partitionBegin are used.
Result<std::vector<ChildNode>> ReadChildNodesOfParents(const ExternalLevels& levels,
  const ExternalNumbers& numbers, const VertexTree& tree, unsigned depth, std::size_t block);

// What ReadChildNodesOfParents takes of the tree: 4 bytes a partition.
VertexTree TreeOfPartitions(const MeshBlocks& mesh);

// Where the partitions of a cell begin, and the end.
std::vector<VertexId> PartitionsOfCell(const MeshBlocks& mesh, unsigned depth, std::size_t cell);

}
