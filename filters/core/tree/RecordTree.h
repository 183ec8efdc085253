// SPDX-License-Identifier: BSD-3-Clause
// Builds the k-d tree below one cell, from records in memory: BuildKdTree uses it for the root, the
// out-of-core tree for every cell that fits in memory.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/tree/KdTree.h"
#include "filters/core/tree/PointRecord.h"

#include <cstddef>
#include <span>

namespace kdstream
{

// Orders records by finest cell, ids ascending inside each. Input: the records of cell `index` (0 …
// 2^depth - 1) at `depth` <= depths.finest, all ids differ; coordinates and their differences are
// finite. Output: the records in order, and boxes[node] of every node of the subtree down to
// depths.partition, in a span of 2^(P+1) boxes. If the span is empty, no boxes are made, and the
// order inside finest cells is unspecified. Complexity: O(n (L - depth)); memory does not grow with
// n. Threads: the nodes of a depth in parallel, then subtrees; the result does not depend on the
// threads. Reports the step "tree" from 0 to 1. Errors: Cancelled. Source: paper 4.1.
template <class Scalar>
Status BuildRecordTree(std::span<PointRecord<Scalar>> records, unsigned depth, std::size_t index,
  const TreeDepths& depths, std::span<Box> boxes, const Execution& execution = {});

extern template Status BuildRecordTree<float>(std::span<PointRecord<float>>, unsigned, std::size_t,
  const TreeDepths&, std::span<Box>, const Execution&);
extern template Status BuildRecordTree<double>(std::span<PointRecord<double>>, unsigned,
  std::size_t, const TreeDepths&, std::span<Box>, const Execution&);

}
