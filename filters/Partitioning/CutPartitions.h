// SPDX-License-Identifier: BSD-3-Clause
// Makes partitions as VTK data, after the filter has assigned each point to a partition. Not
// installed.
#pragma once

#include "filters/adapter/PartitionLayout.h"
#include "filters/adapter/PolyDataMesh.h"
#include "filters/core/Execution.h"
#include "filters/core/Result.h"

#include <vtkIdTypeArray.h>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace kdstream
{

// Makes the array "PartitionId".
vtkSmartPointer<vtkIdTypeArray> NewPartitionIds(std::span<const std::uint32_t> partitionOf);

// Makes the partitions first … end - 1 of `input`, with their ghosts, as vtkMeshPartition
// describes. generateIds: adds the array "PartitionId". Multithreaded; reports the step
// "partitions". Errors: Cancelled. REQUIRES: elements of `input`, and their layout.
Result<std::vector<vtkSmartPointer<vtkPolyData>>> CutPartitions(vtkPolyData& input,
  const PolyDataElements& elements, const PartitionLayout& layout, bool generateIds,
  std::size_t first, std::size_t end, const Execution& execution);

}
