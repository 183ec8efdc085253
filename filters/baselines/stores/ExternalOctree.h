// SPDX-License-Identifier: BSD-3-Clause
// Octree clustering of vertices that do not fit in memory: the paper's baseline in Table 3.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/Result.h"
#include "filters/core/tree/PointRecord.h"
#include "filters/outofcore/files/SpillFile.h"

#include <cstdint>
#include <vector>

namespace kdstream
{

struct ExternalOctreeOptions
{
  std::uint32_t verticesPerPartition = 2000;         // a cell of more vertices is split, at least 1
  std::uint64_t memory = std::uint64_t{ 256 } << 20; // bytes
  // Whether the file of points must stay unchanged; see ExternalTreeOptions.
  bool keepPoints = false;
};

struct ExternalOctreeStatistics
{
  std::uint64_t distributions = 0; // number of cells that did not fit in memory
  // Records read by the two passes over each of these cells: one counts, the other writes.
  std::uint64_t distributedRecords = 0;
  std::uint64_t groupsInMemory = 0;
  std::uint64_t bytesRead = 0, bytesWritten = 0, peakBytesOnDisk = 0;
};

struct ExternalOctree
{
  SpillFile records; // PointRecord<Scalar>, cluster by cluster, ids ascending inside each
  std::vector<std::uint64_t> clusterBegin; // first record of each cluster, and the end
  unsigned depth = 0;                      // of the deepest leaf; the root has depth 0
  ExternalOctreeStatistics statistics;
};

// Clusters vertices by the leaves of an octree: the same clusters in the same order as
// ClusterByOctree, for any memory and number of threads.
//
// Input: a file of records, ids ascending; consumed unless keepPoints is set. Output: the same
// records in Morton order of the leaves. Steps:
// 1. Make a pass for the box.
// 2. While a cell does not fit in memory: one pass counts the vertices of its descendants some
//    depths below; another writes them to another file, group by group; each group consists of as
//    many whole cells as fit in memory.
// 3. Read a group that fits, sort it by its keys, and split its cells.
//
// Complexity: two reads and a write of a cell that does not fit, for several depths at once.
// Memory: options.memory, and 8 bytes a cluster. Disk: as BuildExternalTree. Reports the steps
// "survey" and "octree". Errors: InvalidArgument for no records, or an N of 0; InvalidInput for a
// coordinate that is not a number or is beyond mostExtent (Extent.h); LimitExceeded for less memory
// than a few records need; InputOutput; Cancelled. Source: paper 2.1, 4.2.4, [22].
template <class Scalar>
Result<ExternalOctree> ClusterByExternalOctree(SpillFolder& folder, SpillFile& points,
  const ExternalOctreeOptions& options, const Execution& execution = {});

extern template Result<ExternalOctree> ClusterByExternalOctree<float>(
  SpillFolder&, SpillFile&, const ExternalOctreeOptions&, const Execution&);
extern template Result<ExternalOctree> ClusterByExternalOctree<double>(
  SpillFolder&, SpillFile&, const ExternalOctreeOptions&, const Execution&);

}
