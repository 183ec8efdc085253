// SPDX-License-Identifier: BSD-3-Clause
// Which rank of a job has which nodes of the tree, and so which blocks of every depth and which
// places of files that lie in the order of blocks.
#pragma once

#include "filters/core/Types.h"
#include "filters/core/levels/LevelBlocks.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace kdstream
{

// Nodes of one depth are dealt out in intervals that follow each other, about as many to each rank,
// at least one to rank 0. A block of another depth goes with its first node, or with its ancestor.
class NodeShares
{
public:
  explicit NodeShares(std::size_t ranks)
    : Ranks(ranks)
  {
  }

  // Deals out the nodes of this depth; before that all goes to rank 0.
  void Divide(unsigned depth) { this->NodeDepth = depth; }
  unsigned DividedDepth() const { return this->NodeDepth; }

  // The blocks, cells of `depth`, that a rank has.
  BlockRange BlocksOf(std::size_t rank, unsigned depth) const;
  // The rank that has a block. O(log ranks).
  std::size_t OwnerOf(std::size_t block, unsigned depth) const;
  // The first place of each rank, and the end, of a list whose blocks, cells of `depth`, begin at
  // begin[block]; begin has an end.
  std::vector<std::uint64_t> PlacesOf(std::span<const VertexId> begin, unsigned depth) const;

private:
  std::size_t Ranks;
  unsigned NodeDepth = 0;
};

}
