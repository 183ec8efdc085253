// SPDX-License-Identifier: BSD-3-Clause
// The balanced k-d tree over vertices that do not fit in memory (paper 4.2): step "tree" out of
// core.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/Result.h"
#include "filters/core/tree/KdTree.h"
#include "filters/core/tree/PointRecord.h"
#include "filters/outofcore/files/SpillFile.h"
#include "filters/outofcore/tree/MedianSearch.h"

#include <cstdint>
#include <vector>

namespace kdstream
{

struct ExternalTreeOptions
{
  // Bytes of memory that the build may take, including the boxes that it returns.
  std::uint64_t memory = std::uint64_t{ 256 } << 20;
  MedianMethod median = nullptr; // null: FindMedianByHistogram
  // Heaps only: the number of keys in both heaps as a share of the cell's keys (0.1 is the paper's
  // 10 %); 0 = as many as fit in memory.
  double heapShare = 0;
  // Whether the file of points must stay unchanged. If it may change, its disk space is reused: the
  // peak is twice the bytes of the points instead of three times.
  bool keepPoints = false;
};

// The cells of one depth that were split out of core.
struct ExternalDepthStatistics
{
  std::uint64_t cells = 0;
  std::uint64_t records = 0; // in these cells
  // Passes that the method made, summed over all cells.
  std::uint64_t medianPasses = 0;
  std::uint64_t mostMedianPasses = 0; // most passes over a single cell
  std::uint64_t medianRecords = 0;    // records read in these passes
};

struct ExternalTreeStatistics
{
  std::vector<ExternalDepthStatistics> depths; // from the root's depth on; empty if everything fits
                                               // in memory
  std::uint64_t cellsInMemory = 0;             // cells finished in memory
  std::uint64_t bytesRead = 0, bytesWritten = 0, peakBytesOnDisk = 0;
};

struct ExternalTree
{
  TreeDepths depths;
  SpillFile records;      // PointRecord<Scalar>, as BuildKdTree's `order`
  std::vector<Box> boxes; // of nodes 1 … 2^(P+1) - 1; [0] is unused
  ExternalTreeStatistics statistics;
};

// Builds the tree over the records of `points`: the same order and boxes as BuildKdTree, for any
// memory, median method and number of threads.
//
// Input: a file of records in any order, with distinct ids. It is consumed: the tree's records may
// be written over it; with keepPoints it is only read. Output: a file of the same records, finest
// cell by finest cell, ids ascending inside each. Steps:
// 1. Make a pass over all records for the box, the mean, and coordinates that are not numbers.
// 2. While a cell does not fit in memory: find its median by the method (MedianSearch.h); then make
//    one pass that writes the two halves to another file at the same place, and gathers box, mean
//    and histogram of each.
// 3. Read a cell that fits, finish it by BuildRecordTree, and write it.
//
// Complexity: a cell is read and written once for each depth that does not fit, and the cost of the
// median. Memory: options.memory; blocks of up to 2 MiB. Disk: ExternalTreeOptions::keepPoints.
// Reports the steps "survey" and "tree". Errors: InvalidArgument for no records; InvalidInput for a
// coordinate that is not a number or is beyond mostExtent (Extent.h); LimitExceeded, with the bytes
// that are enough, if the memory cannot hold one finest cell and a few blocks; InputOutput (spill
// files); Cancelled.
template <class Scalar>
Result<ExternalTree> BuildExternalTree(SpillFolder& folder, SpillFile& points,
  const TreeDepths& depths, const ExternalTreeOptions& options, const Execution& execution = {});

extern template Result<ExternalTree> BuildExternalTree<float>(
  SpillFolder&, SpillFile&, const TreeDepths&, const ExternalTreeOptions&, const Execution&);
extern template Result<ExternalTree> BuildExternalTree<double>(
  SpillFolder&, SpillFile&, const TreeDepths&, const ExternalTreeOptions&, const Execution&);

}
