// SPDX-License-Identifier: BSD-3-Clause
// The region around a picked cell: which partitions are streamed (paper section 5.4). Step "pick".
//
// The same code runs in the client, which picks, and in the server, which streams: both hold the
// tree's boxes.
#pragma once

#include "filters/core/Result.h"
#include "filters/core/Types.h"
#include "filters/core/tree/KdTree.h"

#include <cstdint>
#include <span>
#include <vector>

namespace kdstream
{

// The partitions whose boxes touch (closed, in doubles) the box of `cell` moved outward on every
// side by rings × the average of its three side lengths; nearest first: the partitions of the cell
// itself by number, then by the distance from box centre to box centre, ties by number. boxes: heap
// order, as KdTree::boxes, of 2^(P+1) entries. cell: any node of depth <= P. rings: 1-3 in the
// viewers, 0 = the partitions that touch the cell itself.
// O(partitions touched × P). Errors: InvalidArgument for a node outside the tree.
Result<std::vector<std::uint32_t>> FindRegion(
  std::span<const Box> boxes, const TreeDepths& depths, NodeId cell, unsigned rings);

// The partition whose box is nearest to `point`, the lowest on ties. REQUIRES: at least one box is
// not empty.
std::uint32_t NearestPartition(
  std::span<const Box> boxes, const TreeDepths& depths, const Vec3& point);

}
