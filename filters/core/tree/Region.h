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
  // A box that contains the node's box, empty only if the node has no vertices; null if none is
  // known. Called from the root down.
  virtual const Box* Around(NodeId node) = 0;
  // The exact box of a partition's node; null if it is not known.
  virtual const Box* OfPartition(NodeId node) = 0;
  // Called when a search cannot go on without a box around a node, or the exact box of a partition.
  virtual void NeedAround(NodeId node) = 0;
  virtual void NeedOfPartition(NodeId node) = 0;
};

// The partitions whose boxes touch an enlarged box of `cell`: each of its sides is moved outward by
// rings × the average of its three side lengths. Boxes are closed; computed in doubles. The order
// is nearest first: the partitions of the cell itself by number, then the others by the distance
// between box centres, ties by number. boxes: 2^(P+1) entries in heap order, as KdTree::boxes.
// cell: any node of depth <= P. rings: 1 to 3 in the viewers; 0 gives the partitions that touch the
// cell itself. O(partitions touched × P). Errors: InvalidArgument for a node outside the tree;
// LimitExceeded for a region of more than `most` partitions, before they are sorted.
Result<std::vector<std::uint32_t>> FindRegion(std::span<const Box> boxes, const TreeDepths& depths,
  NodeId cell, unsigned rings, std::size_t most = std::numeric_limits<std::size_t>::max());
// The same around a partition's node. No value if boxes are needed that are not known.
std::optional<std::vector<std::uint32_t>> FindKnownRegion(
  TreeBoxes& boxes, const TreeDepths& depths, NodeId partition, unsigned rings);

// The partition whose box is nearest to `point`; of equally near ones, the lowest. REQUIRES: at
// least one box is not empty.
std::uint32_t NearestPartition(
  std::span<const Box> boxes, const TreeDepths& depths, const Vec3& point);
// The same if boxes may be unknown. If `known` is false, unknown boxes are needed: the search
// requests those that most likely contain the nearest partition (TreeBoxes::NeedAround,
// NeedOfPartition); call it again when they have arrived. `partition` is empty for a tree without
// vertices.
struct NearestAnswer
{
  bool known = true;
  std::optional<std::uint32_t> partition;
};
NearestAnswer NearestKnownPartition(TreeBoxes& boxes, const TreeDepths& depths, const Vec3& point);

}
