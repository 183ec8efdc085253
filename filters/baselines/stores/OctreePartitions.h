// SPDX-License-Identifier: BSD-3-Clause
// Builds an octree over vertices that do not fit in memory, as the tree of a store: the same as
// TreeOfClustering(ClusterByOctree) in memory.
#pragma once

#include "filters/build/ExternalMethod.h"
#include "filters/core/Execution.h"
#include "filters/core/Result.h"
#include "filters/core/Types.h"
#include "filters/core/tree/KdTree.h"
#include "filters/outofcore/files/SpillFile.h"

#include <cstdint>
#include <span>
#include <vector>

namespace kdstream
{

// Partitions vertices by an octree. points: records, ids ascending; consumed. Gives the same
// partitions as OctreeMethod in memory, and P = S = L. options: verticesPerPartition, or
// partitions. For a number of partitions, the octree is made about 2 + log2(n / partitions) times,
// because N is found by trial. Complexity and memory: ClusterByExternalOctree, and a pass for the
// boxes; 96 bytes a partition. Errors: those of ClusterByExternalOctree; InvalidArgument for a
// number of partitions of 0 or above n.
template <class Scalar>
Result<ExternalPartitions> PartitionByExternalOctree(SpillFolder& folder, SpillFile& points,
  const KdTreeOptions& options, std::uint64_t memory, const Execution& execution = {});

extern template Result<ExternalPartitions> PartitionByExternalOctree<float>(
  SpillFolder&, SpillFile&, const KdTreeOptions&, std::uint64_t, const Execution&);
extern template Result<ExternalPartitions> PartitionByExternalOctree<double>(
  SpillFolder&, SpillFile&, const KdTreeOptions&, std::uint64_t, const Execution&);

// Joins neighbouring partitions into blocks of at most `most` vertices; each block has at least one
// partition. partitionBegin: the first rank of each partition, and the end. Returns the same for
// the blocks. O(partitions).
std::vector<VertexId> JoinIntoBlocks(std::span<const VertexId> partitionBegin, std::uint64_t most);

}
