// SPDX-License-Identifier: BSD-3-Clause
// Partitions as VTK's data: what a filter does once it is known whose each point is. Not installed.
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

// The array "PartitionId".
vtkSmartPointer<vtkIdTypeArray> NewPartitionIds(std::span<const std::uint32_t> partitionOf);

// The partitions first … end - 1 of `input`, with their ghosts, as vtkMeshPartition describes.
// generateIds: adds the array "PartitionId". Multithreaded; reports the step "partitions". Errors:
// Cancelled. REQUIRES: elements of `input`, and their layout.
Result<std::vector<vtkSmartPointer<vtkPolyData>>> CutPartitions(vtkPolyData& input,
  const PolyDataElements& elements, const PartitionLayout& layout, bool generateIds,
  std::size_t first, std::size_t end, const Execution& execution);

}
