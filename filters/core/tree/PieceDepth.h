// SPDX-License-Identifier: BSD-3-Clause
// The depth of the tree at which a resolution is cut into pieces: used by levels, pieces and their
// files.
#pragma once

#include "filters/core/Types.h"
#include "filters/core/tree/KdTree.h"

#include <cstddef>
#include <cstdint>

namespace kdstream
{

// The depth of the nodes that a resolution is cut into: P for the original, min(P, max(0, d - 11))
// for level d.
unsigned PieceDepth(Resolution resolution, const TreeDepths& depths);

// R, the finest level that is one piece whatever the model: min(L, 11).
unsigned PreviewLevel(const TreeDepths& depths);

// The levels for which vertices of a resolution carry the ranks of their ancestors
// (doc/design.md#numbers): `count` levels, from `coarsest` = R to min(d, S) - 1.
struct AncestorLevels
{
  unsigned coarsest = 0;
  unsigned count = 0;
  bool own = false; // whether own vertices carry them (levels up to S), or only ghosts

  std::size_t Rows(std::size_t ownVertices, std::size_t ghosts) const
  {
    return (this->own ? ownVertices : 0) + ghosts;
  }
};
AncestorLevels AncestorLevelsOf(Resolution resolution, const TreeDepths& depths);

// Whether clusters of a resolution have a list of their child pieces at the next level: those of
// the levels R <= d < S.
bool HasChildNodes(Resolution resolution, const TreeDepths& depths);

constexpr NodeId NodeOfPartition(std::uint32_t partition, const TreeDepths& depths)
{
  return partition + (NodeId{ 1 } << depths.partition);
}

}
