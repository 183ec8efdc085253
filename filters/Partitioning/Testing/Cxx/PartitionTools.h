// SPDX-License-Identifier: BSD-3-Clause
// Shared by the tests of partition filters.
#pragma once

#include "filters/adapter/Testing/FilterTools.h"

#include <gtest/gtest.h>
#include <vtkKMeansPartition.h>
#include <vtkKdTreePartition.h>
#include <vtkOctreePartition.h>
#include <vtkPartitionedDataSet.h>
#include <vtkUnsignedCharArray.h>

namespace kdstream::testing
{

using PartitionFilters =
  ::testing::Types<vtkKdTreePartition, vtkOctreePartition, vtkKMeansPartition>;

inline std::vector<vtkPolyData*> Partitions(vtkMeshPartition& filter)
{
  std::vector<vtkPolyData*> partitions;
  for (unsigned int i = 0; i < filter.GetOutput()->GetNumberOfPartitions(); ++i)
  {
    partitions.push_back(vtkPolyData::SafeDownCast(filter.GetOutput()->GetPartition(i)));
  }
  return partitions;
}

inline vtkIdType Value(vtkDataSetAttributes* data, const char* array, vtkIdType i)
{
  return static_cast<vtkIdType>(data->GetArray(array)->GetTuple1(i));
}

inline bool IsGhost(vtkDataSetAttributes* data, vtkIdType i)
{
  return (Value(data, vtkDataSetAttributes::GhostArrayName(), i) & 1) != 0;
}

// The number of points that belong to the partition.
inline vtkIdType OwnPoints(vtkPolyData& partition)
{
  vtkIdType own = 0;
  for (vtkIdType i = 0; i < partition.GetNumberOfPoints(); ++i)
  {
    own += !IsGhost(partition.GetPointData(), i);
  }
  return own;
}

// The sizes of the partitions.
inline std::vector<vtkIdType> Sizes(vtkMeshPartition& filter)
{
  std::vector<vtkIdType> sizes;
  for (vtkPolyData* partition : Partitions(filter))
  {
    sizes.push_back(OwnPoints(*partition));
  }
  return sizes;
}

}
