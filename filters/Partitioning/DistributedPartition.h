// SPDX-License-Identifier: BSD-3-Clause
// vtkKdTreePartition on several ranks: one tree of what all of them have. Not installed.
//
// Steps: 1. which points and cells are this rank's, and their numbers in the mesh of all ranks,
// 2. the tree, depth by depth: boxes and medians over the ranks (RadixMedians.h), 3. cells and
// points to the ranks whose partitions they touch, 4. there they are put in the order of their
// numbers, and cut as one process would (CutPartitions.h).
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
  std::size_t first = 0;                  // this rank's, where they were asked for
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

// input: this rank's part. Called by all ranks together, with the same options; all return the same
// error if one has any, which names its rank. Partitions are those of BuildKdTree over all ranks'
// points in the order of their numbers: of their global ids where all ranks have them, whatever
// these are, else those of rank 0 first. Memory: input and output twice. Errors: those of
// PolyDataMesh and BuildKdTree; LimitExceeded for more than 2^32 - 2 points; Cancelled, on all
// ranks where it is on one. An exception leaves by itself: it is for RankGroup::Run to tell.
Result<DistributedPartitions> PartitionCollectively(RankGroup& ranks, vtkPolyData& input,
  const DistributedOptions& options, const Execution& execution);

}
