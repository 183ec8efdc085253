// SPDX-License-Identifier: BSD-3-Clause
// Shared by the tests of model sources: a mesh in VTK's arrays, its store, and the content of an
// output, whatever the order of its points and cells.
#pragma once

#include "Testing/Fixtures/Meshes.h"
#include "Testing/Fixtures/TemporaryFolder.h"
#include "filters/adapter/MeshPolyData.h"
#include "filters/adapter/Testing/FilterTools.h"
#include "filters/build/Builder.h"

#include <gtest/gtest.h>
#include <vtkKdModelSource.h>
#include <vtkPartitionedDataSet.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <vector>

namespace kdstream::testing
{

inline PolyData AsPolyData(const Mesh& mesh)
{
  auto data = PolyData::New();
  EXPECT_TRUE(FillPolyData(
    mesh, mesh.points.size(), [](const AttributeInfo&) { return true; }, *data));
  return data;
}

// Builds a lossless store, with partitions of at most this number of vertices.
inline void BuildTo(const std::filesystem::path& file, const Mesh& mesh,
  std::uint32_t verticesPerPartition, const PartitionMethod* partitioner = &KdTreeMethod())
{
  BuildOptions options;
  options.bits = 0;
  options.tree.verticesPerPartition = verticesPerPartition;
  options.partitioner = partitioner;
  const auto built = BuildStore(mesh, "mesh", file, options);
  ASSERT_TRUE(built) << built.GetError().message;
}

// The positions of points, and of the corners of cells (rotated so that the least corner is first):
// of those that are not marked, or of all.
struct Content
{
  std::vector<std::array<double, 3>> points;
  std::vector<std::vector<std::array<double, 3>>> cells;
  bool operator==(const Content&) const = default;

  void Add(vtkPolyData& mesh, bool marked)
  {
    const auto isMarked = [](vtkDataSetAttributes* data, vtkIdType i)
    {
      vtkDataArray* const marks = data->GetArray(vtkDataSetAttributes::GhostArrayName());
      return marks && marks->GetComponent(i, 0) != 0;
    };
    for (vtkIdType i = 0; i < mesh.GetNumberOfPoints(); ++i)
    {
      if (marked || !isMarked(mesh.GetPointData(), i))
      {
        this->points.push_back(Point(mesh, i));
      }
    }
    for (vtkIdType i = 0; i < mesh.GetNumberOfCells(); ++i)
    {
      if (marked || !isMarked(mesh.GetCellData(), i))
      {
        std::vector<std::array<double, 3>> corners;
        for (const vtkIdType id : CellPoints(mesh, i))
        {
          corners.push_back(Point(mesh, id));
        }
        auto least = corners;
        for (std::size_t k = 1; k < corners.size(); ++k)
        {
          std::rotate(corners.begin(), corners.begin() + 1, corners.end());
          least = std::min(least, corners);
        }
        this->cells.push_back(least);
      }
    }
  }
  Content& Sort()
  {
    std::sort(this->points.begin(), this->points.end());
    std::sort(this->cells.begin(), this->cells.end());
    return *this;
  }
};

inline Content ContentOf(vtkDataObject* data, bool marked = false)
{
  Content content;
  if (auto* const mesh = vtkPolyData::SafeDownCast(data))
  {
    content.Add(*mesh, marked);
  }
  else if (auto* const parts = vtkPartitionedDataSet::SafeDownCast(data))
  {
    for (unsigned int i = 0; i < parts->GetNumberOfPartitions(); ++i)
    {
      if (auto* const part = vtkPolyData::SafeDownCast(parts->GetPartitionAsDataObject(i)))
      {
        content.Add(*part, marked);
      }
    }
  }
  return content.Sort();
}

// The content of partition i, marked or not.
inline Content ContentOfPartition(vtkDataObject* data, unsigned int i, bool marked)
{
  auto* const parts = vtkPartitionedDataSet::SafeDownCast(data);
  return ContentOf(parts->GetPartitionAsDataObject(i), marked);
}

inline unsigned int LoadedPartitions(vtkDataObject* data)
{
  auto* const parts = vtkPartitionedDataSet::SafeDownCast(data);
  unsigned int loaded = 0;
  for (unsigned int i = 0; i < parts->GetNumberOfPartitions(); ++i)
  {
    loaded += parts->GetPartitionAsDataObject(i) ? 1 : 0;
  }
  return loaded;
}

}
