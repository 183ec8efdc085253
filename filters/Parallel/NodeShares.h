// SPDX-License-Identifier: BSD-3-Clause
// Which rank of a job has which nodes of the tree. This determines who has the blocks of each
// depth, and the ranges in files that are in the order of blocks.
#pragma once

#include "filters/core/Types.h"
#include "filters/core/levels/LevelBlocks.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace kdstream
{

// The nodes of one depth are distributed in consecutive intervals: about the same number to each
// rank, at least one to rank 0. A block of another depth is on the rank of its ancestor, or of the
// first node in it.
class NodeShares
{
public:
  explicit NodeShares(std::size_t ranks)
    : Ranks(ranks)
  {
  }

  // Distributes the nodes of this depth. Before this call everything is on rank 0.
  void Divide(unsigned depth) { this->NodeDepth = depth; }
  unsigned DividedDepth() const { return this->NodeDepth; }

  // The blocks (cells of `depth`) of a rank.
  BlockRange BlocksOf(std::size_t rank, unsigned depth) const;
  // The rank that has a block. O(log ranks).
  std::size_t OwnerOf(std::size_t block, unsigned depth) const;
  // For a list in the order of blocks: the first place of each rank, and the end. begin: the first
  // place of each block (a cell of `depth`), and the end.
  std::vector<std::uint64_t> PlacesOf(std::span<const VertexId> begin, unsigned depth) const;

private:
  std::size_t Ranks;
  unsigned NodeDepth = 0;
};

}
