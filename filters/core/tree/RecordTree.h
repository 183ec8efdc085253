// SPDX-License-Identifier: BSD-3-Clause
// Builds the k-d tree below one cell, from records in memory: BuildKdTree uses it for the root, the
// tree out of core for every cell that fits the memory.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/tree/KdTree.h"
#include "filters/core/tree/PointRecord.h"

#include <cstddef>
#include <span>

namespace kdstream
{

// Orders records by finest cell, ids ascending inside each. Input: the records of cell `index` (0 …
// 2^depth - 1) at `depth` <= depths.finest, ids that differ, finite coordinates whose differences
// are finite. Output: the records in order; boxes[node] of every node of the subtree down to
// depths.partition, in a span of 2^(P+1) boxes. An empty span: no boxes, and in finest cells any
// order. Complexity: O(n (L - depth)); no memory that grows with n. Threads: nodes of one depth,
// then subtrees; the result does not depend on them. Reports the step "tree" from 0 to 1. Errors:
// Cancelled. Source: paper 4.1.
template <class Scalar>
Status BuildRecordTree(std::span<PointRecord<Scalar>> records, unsigned depth, std::size_t index,
  const TreeDepths& depths, std::span<Box> boxes, const Execution& execution = {});

extern template Status BuildRecordTree<float>(std::span<PointRecord<float>>, unsigned, std::size_t,
  const TreeDepths&, std::span<Box>, const Execution&);
extern template Status BuildRecordTree<double>(std::span<PointRecord<double>>, unsigned,
  std::size_t, const TreeDepths&, std::span<Box>, const Execution&);

}
