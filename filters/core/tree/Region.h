// SPDX-License-Identifier: BSD-3-Clause
// The region around a picked cell: which partitions are streamed (paper section 5.4). Step "pick".
//
// The same code runs in the client, which picks, and in the server, which streams. The server has
// all boxes of the tree, the client only those that it has fetched.
#pragma once

#include "filters/core/Result.h"
#include "filters/core/Types.h"
#include "filters/core/tree/KdTree.h"

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

namespace kdstream
{

// Boxes of a tree as far as they are known.
class TreeBoxes
{
public:
  virtual ~TreeBoxes() = default;
  // A box that contains the node's box; empty only for a node without vertices; null if it is not
  // known. Called from the root down.
  virtual const Box* Around(NodeId node) = 0;
  // Exact; null where it is not known.
  virtual const Box* OfPartition(NodeId node) = 0;
  // A search cannot go on without the box around a node, or the exact one of a partition.
  virtual void NeedAround(NodeId node) = 0;
  virtual void NeedOfPartition(NodeId node) = 0;
};

// The partitions whose boxes touch (closed, in doubles) the box of `cell` moved outward on every
// side by rings × the average of its three side lengths; nearest first: the partitions of the cell
// itself by number, then by the distance from box centre to box centre, ties by number. boxes: heap
// order, as KdTree::boxes, of 2^(P+1) entries. cell: any node of depth <= P. rings: 1 to 3 in the
// viewers; 0: the partitions that touch the cell itself. O(partitions touched × P). Errors:
// InvalidArgument for a node outside the tree; LimitExceeded for a region of more than `most`
// partitions, before they are sorted.
Result<std::vector<std::uint32_t>> FindRegion(std::span<const Box> boxes, const TreeDepths& depths,
  NodeId cell, unsigned rings, std::size_t most = std::numeric_limits<std::size_t>::max());
// The same around a partition's node; nothing where boxes are needed that are not known.
std::optional<std::vector<std::uint32_t>> FindKnownRegion(
  TreeBoxes& boxes, const TreeDepths& depths, NodeId partition, unsigned rings);

// The partition whose box is nearest to `point`; of equals, the lowest. REQUIRES: at least one box
// is not empty.
std::uint32_t NearestPartition(
  std::span<const Box> boxes, const TreeDepths& depths, const Vec3& point);
// The same with boxes that may be unknown. `known` false: unknown boxes are needed. The search
// names those that most likely contain the nearest one; call it again when they have arrived. No
// partition for a tree without vertices.
struct NearestAnswer
{
  bool known = true;
  std::optional<std::uint32_t> partition;
};
NearestAnswer NearestKnownPartition(TreeBoxes& boxes, const TreeDepths& depths, const Vec3& point);

}
