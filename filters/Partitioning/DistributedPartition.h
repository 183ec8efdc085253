// SPDX-License-Identifier: BSD-3-Clause
// vtkKdTreePartition on several ranks: one tree of the mesh of all ranks. Not installed.
//
// Steps:
// 1. Find this rank's points and cells, and their numbers in the mesh of all ranks.
// 2. Build the tree, depth by depth: boxes and medians over the ranks (RadixMedians.h).
// 3. Send cells and points to the ranks whose partitions they touch.
// 4. Put them there in the order of their numbers, and cut them as one process would
//    (CutPartitions.h).
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/Result.h"
#include "filters/core/tree/KdTree.h"
#include "filters/ranks/RankGroup.h"

#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace kdstream
{

struct DistributedPartitions
{
  std::vector<std::uint32_t> partitionOf; // of each point of this rank's input, ghosts too
  std::size_t partitions = 0;             // of the whole mesh
  std::size_t first = 0;                  // the first one of this rank, if requested
  std::vector<vtkSmartPointer<vtkPolyData>> made;
  std::vector<std::string> skipped; // arrays that did not come along, each with a reason
  bool areSame = false;             // all ranks have the same points, and each counts
};

struct DistributedOptions
{
  KdTreeOptions tree;       // cellVertices does not matter
  bool isCut = true;        // whether partitions are wanted, or only whose each point is
  bool generateIds = false; // with "PartitionId"
};

// input: this rank's part. Called by all ranks together, with the same options; if one has an
// error, all return it; it names the rank. The partitions are those of BuildKdTree for the points
// of all ranks. The order of points is that of their global ids, if all ranks have any; else rank
// 0's come first, then rank 1's, …. Memory: input and output twice. Errors: those of PolyDataMesh
// and BuildKdTree; LimitExceeded for more than 2^32 - 2 points; Cancelled, on all ranks if on one.
// Exceptions are not caught: RankGroup::Run reports them.
Result<DistributedPartitions> PartitionCollectively(RankGroup& ranks, vtkPolyData& input,
  const DistributedOptions& options, const Execution& execution);

}
