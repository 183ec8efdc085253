// SPDX-License-Identifier: BSD-3-Clause
// vtkKdTreePartition on several ranks: one tree over the mesh of all ranks. Not installed.
//
// Steps:
// 1. Find this rank's points and cells, and their numbers in the mesh of all ranks.
// 2. Build the tree, depth by depth: boxes and medians over all ranks (RadixMedians.h).
// 3. Send cells and points to the ranks whose partitions they touch.
// 4. There, put them in the order of their numbers, and cut them as one process would
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
  std::vector<std::uint32_t> partitionOf; // for each point of this rank's input, also for ghosts
  std::size_t partitions = 0;             // number in the whole mesh
  std::size_t first = 0;                  // this rank's first partition, if cut
  std::vector<vtkSmartPointer<vtkPolyData>> made;
  std::vector<std::string> skipped; // arrays that are not in the output, each with a reason
  bool areSame = false;             // whether all ranks have the same points, not joined by ids
};

struct DistributedOptions
{
  KdTreeOptions tree;       // cellVertices has no effect
  bool isCut = true;        // whether partitions are cut, or points are only assigned to them
  bool generateIds = false; // add the array "PartitionId"
};

// input: this rank's part. Called by all ranks together, with the same options. If one rank has an
// error, all return it, and it names the rank. The partitions are those of BuildKdTree for the
// points of all ranks. The order of points is that of their global ids, if all ranks have ids;
// otherwise those of rank 0 come first, then those of rank 1, …. Memory: input and output twice.
// Errors: those of PolyDataMesh and BuildKdTree; LimitExceeded for more than 2^32 - 2 points;
// Cancelled, on all ranks if on one. Exceptions are not caught: RankGroup::Run reports them.
Result<DistributedPartitions> PartitionCollectively(RankGroup& ranks, vtkPolyData& input,
  const DistributedOptions& options, const Execution& execution);

}
