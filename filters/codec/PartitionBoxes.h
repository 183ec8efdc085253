// SPDX-License-Identifier: BSD-3-Clause
// The exact boxes of partitions, which decide what a region contains: a viewer fetches those around
// a tap. Layout: doc/formats.md.
#pragma once

#include "filters/core/Result.h"
#include "filters/core/Types.h"
#include "filters/core/tree/KdTree.h"

#include <cstdint>
#include <span>
#include <vector>

namespace kdstream
{

// A blob of boxes belongs to a node of depth max(0, P - 5) and has those of the partitions below.
inline constexpr unsigned partitionBoxesDepths = 5;

unsigned DepthOfPartitionBoxes(const TreeDepths& depths);
bool HasPartitionBoxes(NodeId node, const TreeDepths& depths);
// The blob that has a partition's. REQUIRES: DepthOfNode(partition) == depths.partition.
NodeId BoxesOfPartition(NodeId partition, const TreeDepths& depths);
// The nodes that have one, ascending.
std::vector<NodeId> AllPartitionBoxes(const TreeDepths& depths);

// boxes: heap order, as KdTree::boxes. Exact, as floats where every value is one.
std::vector<std::uint8_t> EncodePartitionBoxes(
  std::span<const Box> boxes, NodeId node, const TreeDepths& depths);

// The boxes of the partitions below `node`, ascending; a partition without vertices has an empty
// box. Errors: as DecodePiece; InvalidArgument for a node that has no such blob.
Result<std::vector<Box>> DecodePartitionBoxes(
  std::span<const std::uint8_t> blob, NodeId node, const TreeDepths& depths);

// Fills the nodes above the partitions. boxes: heap order, 2^(P+1) entries.
void UniteBoxes(std::span<Box> boxes);
// The boxes of all nodes, heap order, the first unused, given those of all 2^P partitions.
std::vector<Box> BoxesAbove(std::span<const Box> partitions);

}
