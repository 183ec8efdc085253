// SPDX-License-Identifier: BSD-3-Clause
// The levels 0 … S of the vertex tree, for a mesh that does not fit in memory, as far as a part of
// the mesh needs them. Step "cut" out of core.
#pragma once

#include "filters/core/Result.h"
#include "filters/core/pieces/VertexTree.h"
#include "filters/outofcore/levels/BlockGroup.h"
#include "filters/outofcore/levels/ExternalLevels.h"
#include "filters/outofcore/mesh/CellTriangles.h"
#include "filters/outofcore/mesh/MeshBlocks.h"
#include "filters/outofcore/pieces/ExternalNumbers.h"

#include <optional>
#include <span>
#include <vector>

namespace kdstream
{

// Levels that are not in files are whole in memory. Of the levels in files, only the ancestors of
// given vertices are loaded. Keeps references.
class CoarseTree
{
public:
  CoarseTree(const MeshBlocks& mesh, const ExternalLevels& levels, const ExternalNumbers& numbers);

  // O(c log c) for the c clusters of level S and of the coarsest level in files. Memory: 24 bytes
  // for each cluster above the files, the child nodes of those clusters, and 12 bytes a partition.
  // Errors: InputOutput; Damaged (ReadLinks). group: all processes get what AncestorsOf needs; only
  // the first one gets the child nodes.
  Status Load(BlockGroup& group);

  // The levels in memory, coarser than those in files: first, parents, child nodes.
  const std::vector<VertexTreeLevel>& Whole() const { return this->WholeLevels; }
  // The lowest numbered vertices of the levels in memory, by number of cluster; only in the first
  // process of a group.
  const std::vector<std::vector<VertexId>>& First() const { return this->FirstOfWhole; }

  // The ancestors of `own`, the numbered vertices of some partitions, and of other vertices,
  // `ghosts`, which ascend. For each level in files from R to S, [depth]: the clusters that contain
  // these vertices, with parents and ranks; at level S also `first`. O(ghosts, and the level-S
  // clusters of all their partitions). Errors: InputOutput.
  Result<std::vector<VertexTreeLevel>> AncestorsOf(
    const CellRange& own, std::span<const VertexId> ghosts) const;
  // The same for the ancestors of clusters with given ranks, ascending, of a level in files up to
  // S. The result includes these clusters, without `first`.
  Result<std::vector<VertexTreeLevel>> AncestorsOfRanks(
    unsigned depth, std::vector<VertexId> ranks) const;

private:
  Status LoadWhole();
  Status LoadChildNodes();
  Status FindPartitions();
  Status Spread(BlockGroup& group);
  // Append clusters of level S, with the ranks of their parents. AppendOwn: all clusters of some
  // partitions. AppendHolders: the clusters that contain given vertices.
  Status AppendOwn(const CellRange& own, VertexTreeLevel& level) const;
  Status AppendHolders(std::span<const VertexId> numbers, VertexTreeLevel& level) const;
  Status ReadParentRanks(unsigned depth, VertexTreeLevel& level) const;
  Status AddAncestors(std::vector<VertexTreeLevel>& levels) const;

  const MeshBlocks& Input;
  const ExternalLevels& Levels;
  const ExternalNumbers& Numbers;
  std::vector<VertexTreeLevel> WholeLevels;
  std::vector<std::vector<VertexId>> FirstOfWhole;
  std::vector<VertexId> PlacesAboveFiles; // of clusters of level firstInFiles - 1, by number
  std::optional<CellOfRank> PartitionOf;
  std::vector<VertexId> StitchBegin; // rank of each partition's first level-S cluster, and the end
};

}
