// SPDX-License-Identifier: BSD-3-Clause
// The exact boxes of partitions, which decide what a region contains. A viewer fetches the boxes
// around a tap. Layout: doc/formats.md.
#pragma once

#include "filters/core/Result.h"
#include "filters/core/Types.h"
#include "filters/core/tree/KdTree.h"

#include <cstdint>
#include <span>
#include <vector>

namespace kdstream
{

// A blob of boxes belongs to a node of depth max(0, P - 5), and has the boxes of the partitions
// below it.
inline constexpr unsigned partitionBoxesDepths = 5;

unsigned DepthOfPartitionBoxes(const TreeDepths& depths);
bool HasPartitionBoxes(NodeId node, const TreeDepths& depths);
// The node whose blob has a partition's box. REQUIRES: DepthOfNode(partition) == depths.partition.
NodeId BoxesOfPartition(NodeId partition, const TreeDepths& depths);
// The nodes that have a blob of boxes, ascending.
std::vector<NodeId> AllPartitionBoxes(const TreeDepths& depths);

// Encodes the boxes of the partitions below `node` exactly: as floats if floats hold every value.
// boxes: heap order, as KdTree::boxes.
std::vector<std::uint8_t> EncodePartitionBoxes(
  std::span<const Box> boxes, NodeId node, const TreeDepths& depths);

// The boxes of the partitions below `node`, ascending; a partition without vertices has an empty
// box. Errors: as DecodePiece; InvalidArgument if the node has no blob of boxes.
Result<std::vector<Box>> DecodePartitionBoxes(
  std::span<const std::uint8_t> blob, NodeId node, const TreeDepths& depths);

// Computes the boxes of the nodes above the partitions. boxes: heap order, 2^(P+1) entries.
void UniteBoxes(std::span<Box> boxes);
// The boxes of all nodes, from those of all 2^P partitions. Heap order; the first entry is unused.
std::vector<Box> BoxesAbove(std::span<const Box> partitions);

}
