// SPDX-License-Identifier: BSD-3-Clause
// How deep in the tree a resolution is cut into pieces, which levels, pieces and their files all go
// by.
#pragma once

#include "filters/core/Types.h"
#include "filters/core/tree/KdTree.h"

#include <cstdint>

namespace kdstream
{

// The depth of the nodes that a resolution is cut into: P for the original, min(P, max(0, d - 11))
// for level d.
unsigned PieceDepth(Resolution resolution, const TreeDepths& depths);

constexpr NodeId NodeOfPartition(std::uint32_t partition, const TreeDepths& depths)
{
  return partition + (NodeId{ 1 } << depths.partition);
}

}
