// SPDX-License-Identifier: BSD-3-Clause
// What vtkMeshPartition passes to its subclasses, receives from them, and keeps. Not installed,
// because users would need core.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/Result.h"
#include "filters/core/Types.h"
#include "filters/core/tree/Clustering.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace kdstream
{

struct MeshPartitionWork
{
  // In: the mesh, the user's options, and the filter's threads, progress and abort. The reported
  // steps are "tree", "octree", "faces", "seeds" and "k-means".
  const std::vector<Vec3>& points;
  std::span<const Triangle> triangles;
  std::uint32_t verticesPerPartition;
  std::optional<std::uint32_t> wantedPartitions;
  const Execution& execution;

  // Out: for each point its partition, a number below `partitions`; or an error.
  std::vector<std::uint32_t> partitionOf{};
  std::size_t partitions = 0;
  Status status{};

  // Takes over the result of one of core's partitioners.
  template <class C>
  void Take(Result<C> clustering)
  {
    if (!clustering)
    {
      this->status = clustering.GetError();
      return;
    }
    this->partitionOf = std::move(clustering->clusterOf);
    this->partitions = clustering->clusters;
  }
};

// The partitions of an input's points, with the times of the input (TimeOf) and the filter for
// which they were computed.
struct PartitionAssignment
{
  std::vector<std::uint32_t> partitionOf;
  std::size_t partitions = 0;
  std::uint64_t inputTime = 0, filterTime = 0;
};

}
