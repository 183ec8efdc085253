// SPDX-License-Identifier: BSD-3-Clause
// What holds for all partition filters: nothing is lost, ghosts are marked, data are passed.
#include "filters/Partitioning/Testing/Cxx/PartitionTools.h"

#include <gtest/gtest.h>
#include <vtkDoubleArray.h>
#include <vtkFloatArray.h>
#include <vtkStringArray.h>

#include <algorithm>
#include <map>
#include <set>

namespace
{

using namespace kdstream::testing;

struct Input
{
  const char* name;
  PolyData mesh;
};

// Inputs with the arrays "Point" and "Cell", which hold in the output the number of each input
// point or cell.
std::vector<Input> Inputs()
{
  PolyData soup = MakePlate(12); // has edges of three triangles, and repeated and degenerate
                                 // triangles
  for (const Ids& triangle : { Ids{ 0, 1, 100 }, Ids{ 1, 0, 50 }, Ids{ 0, 1, 12 }, Ids{ 0, 1, 12 },
         Ids{ 5, 5, 90 }, Ids{ 7, 7, 7 }, Ids{ 143, 0, 70 } })
  {
    AddCell(soup->GetPolys(), triangle);
  }
  soup->GetCellData()->Initialize();
  soup->GetPointData()->Initialize();
  AddIds(*soup);
  return { { "sphere", MakeSphere(40) }, { "sphere in doubles", MakeSphere(23, VTK_DOUBLE) },
    { "plate", MakePlate(33) }, { "repeated point", MakeRepeatedPoint(30) }, { "soup", soup } };
}

template <class Filter>
vtkNew<Filter> Cut(vtkPolyData* input, vtkIdType verticesPerPartition)
{
  vtkNew<Filter> filter;
  filter->SetInputData(input);
  filter->SetVerticesPerPartition(verticesPerPartition);
  filter->GeneratePartitionIdsOn();
  filter->Update();
  return filter;
}

// For each point of the input the partition that owns it; every point must have exactly one owner.
std::vector<std::size_t> Owners(vtkMeshPartition& filter, vtkIdType points)
{
  std::vector<std::size_t> owners(static_cast<std::size_t>(points), SIZE_MAX);
  const std::vector<vtkPolyData*> partitions = Partitions(filter);
  for (std::size_t p = 0; p < partitions.size(); ++p)
  {
    vtkPointData* const data = partitions[p]->GetPointData();
    for (vtkIdType i = 0; i < partitions[p]->GetNumberOfPoints(); ++i)
    {
      if (!IsGhost(data, i))
      {
        std::size_t& owner = owners[static_cast<std::size_t>(Value(data, "Point", i))];
        EXPECT_EQ(owner, SIZE_MAX);
        owner = p;
      }
    }
  }
  EXPECT_EQ(std::count(owners.begin(), owners.end(), SIZE_MAX), 0);
  return owners;
}

template <class Filter>
class MeshPartition : public ::testing::Test
{
};
TYPED_TEST_SUITE(MeshPartition, PartitionFilters);

// The corners of a cell, as points of the input.
Ids InputPoints(vtkPolyData& partition, vtkIdType cell)
{
  Ids points = CellPoints(partition, cell);
  for (vtkIdType& point : points)
  {
    point = Value(partition.GetPointData(), "Point", point);
  }
  return points;
}

TYPED_TEST(MeshPartition, NothingLost)
{
  for (const Input& input : Inputs())
  {
    SCOPED_TRACE(input.name);
    const auto filter = Cut<TypeParam>(input.mesh, 60);
    std::vector<int> seen(static_cast<std::size_t>(input.mesh->GetNumberOfCells()), 0);
    for (vtkPolyData* partition : Partitions(*filter))
    {
      ASSERT_EQ(partition->GetPoints()->GetDataType(), input.mesh->GetPoints()->GetDataType());
      for (vtkIdType i = 0; i < partition->GetNumberOfPoints(); ++i)
      {
        EXPECT_EQ(
          Point(*partition, i), Point(*input.mesh, Value(partition->GetPointData(), "Point", i)));
      }
      for (vtkIdType c = 0; c < partition->GetNumberOfCells(); ++c)
      {
        const vtkIdType cell = Value(partition->GetCellData(), "Cell", c);
        EXPECT_EQ(InputPoints(*partition, c), CellPoints(*input.mesh, cell));
        seen[static_cast<std::size_t>(cell)] += !IsGhost(partition->GetCellData(), c);
      }
    }
    EXPECT_EQ(std::count(seen.begin(), seen.end(), 1), input.mesh->GetNumberOfCells());
  }
}

TYPED_TEST(MeshPartition, CellsGoWhereTheirPointsAreAndTheLowestOwnsThem)
{
  for (const Input& input : Inputs())
  {
    SCOPED_TRACE(input.name);
    const auto filter = Cut<TypeParam>(input.mesh, 60);
    const std::vector<std::size_t> owners = Owners(*filter, input.mesh->GetNumberOfPoints());
    std::map<vtkIdType, std::set<std::size_t>> found; // partitions of each cell
    const std::vector<vtkPolyData*> partitions = Partitions(*filter);
    ASSERT_TRUE(partitions.size() > 1 || input.name == std::string("repeated point"));
    for (std::size_t p = 0; p < partitions.size(); ++p)
    {
      for (vtkIdType c = 0; c < partitions[p]->GetNumberOfCells(); ++c)
      {
        const vtkIdType cell = Value(partitions[p]->GetCellData(), "Cell", c);
        EXPECT_TRUE(found[cell].insert(p).second) << "twice in one partition";
        std::size_t lowest = SIZE_MAX;
        for (const vtkIdType point : InputPoints(*partitions[p], c))
        {
          lowest = std::min(lowest, owners[static_cast<std::size_t>(point)]);
        }
        EXPECT_EQ(IsGhost(partitions[p]->GetCellData(), c), lowest != p);
      }
    }
    for (vtkIdType cell = 0; cell < input.mesh->GetNumberOfCells(); ++cell)
    {
      std::set<std::size_t> expected;
      for (const vtkIdType point : CellPoints(*input.mesh, cell))
      {
        expected.insert(owners[static_cast<std::size_t>(point)]);
      }
      EXPECT_EQ(found[cell], expected);
    }
  }
}

TYPED_TEST(MeshPartition, OwnPointsFirstThenTheGhostsThatCellsNeed)
{
  for (const Input& input : Inputs())
  {
    SCOPED_TRACE(input.name);
    const auto filter = Cut<TypeParam>(input.mesh, 60);
    for (vtkPolyData* partition : Partitions(*filter))
    {
      const vtkIdType own = OwnPoints(*partition), all = partition->GetNumberOfPoints();
      std::vector<bool> used(static_cast<std::size_t>(all), false);
      for (vtkIdType c = 0; c < partition->GetNumberOfCells(); ++c)
      {
        for (const vtkIdType point : CellPoints(*partition, c))
        {
          used[static_cast<std::size_t>(point)] = true;
        }
      }
      for (vtkIdType i = 0; i < all; ++i)
      {
        EXPECT_EQ(IsGhost(partition->GetPointData(), i), i >= own);
        EXPECT_TRUE(i < own || used[static_cast<std::size_t>(i)]);
        EXPECT_TRUE(i == 0 || i == own ||
                    Value(partition->GetPointData(), "Point", i - 1) <
                      Value(partition->GetPointData(), "Point", i));
      }
    }
  }
}

TYPED_TEST(MeshPartition, PartitionIdsAgreeOnBothOutputs)
{
  for (const Input& input : Inputs())
  {
    SCOPED_TRACE(input.name);
    const auto filter = Cut<TypeParam>(input.mesh, 60);
    const std::vector<std::size_t> owners = Owners(*filter, input.mesh->GetNumberOfPoints());
    for (vtkPolyData* partition : Partitions(*filter))
    {
      for (vtkIdType i = 0; i < partition->GetNumberOfPoints(); ++i)
      {
        const auto point = static_cast<std::size_t>(Value(partition->GetPointData(), "Point", i));
        EXPECT_EQ(Value(partition->GetPointData(), "PartitionId", i), vtkIdType(owners[point]));
      }
    }
    vtkPolyData* const labelled = vtkPolyData::SafeDownCast(filter->GetOutputDataObject(1));
    ASSERT_TRUE(vtkIdTypeArray::SafeDownCast(labelled->GetPointData()->GetArray("PartitionId")));
    for (vtkIdType i = 0; i < input.mesh->GetNumberOfPoints(); ++i)
    {
      EXPECT_EQ(Value(labelled->GetPointData(), "PartitionId", i),
        vtkIdType(owners[static_cast<std::size_t>(i)]));
    }
    labelled->GetPointData()->RemoveArray("PartitionId");
    EXPECT_EQ(Describe(*labelled), Describe(*input.mesh));
    EXPECT_FALSE(input.mesh->GetPointData()->HasArray("PartitionId")) << "the input was changed";
  }
}

TYPED_TEST(MeshPartition, CellsOfAllKinds)
{
  const PolyData input = MakeAllCells();
  vtkNew<vtkIdTypeArray> globalIds;
  globalIds->SetName("Global");
  globalIds->SetNumberOfValues(input->GetNumberOfCells());
  globalIds->FillValue(7);
  input->GetCellData()->SetGlobalIds(globalIds);
  const auto filter = Cut<TypeParam>(input, 10);
  ASSERT_GT(Partitions(*filter).size(), 4U);
  std::map<vtkIdType, std::multiset<Ids>> elements; // the elements of each cell
  for (vtkPolyData* partition : Partitions(*filter))
  {
    EXPECT_EQ(partition->GetNumberOfStrips(), 0);
    EXPECT_FALSE(partition->GetCellData()->GetGlobalIds()) << "cells were cut up";
    for (vtkIdType c = 0; c < partition->GetNumberOfCells(); ++c)
    {
      if (!IsGhost(partition->GetCellData(), c))
      {
        elements[Value(partition->GetCellData(), "Cell", c)].insert(InputPoints(*partition, c));
      }
    }
  }
  const std::map<vtkIdType, std::multiset<Ids>> expected{ { 0, { { 3 } } },
    { 1, { { 0 }, { 63 }, { 7 } } }, { 2, { { 0, 63 } } },
    { 3, { { 8, 9 }, { 9, 17 }, { 17, 16 } } }, { 4, { { 0, 1, 8 } } },
    { 5, { { 18, 19, 27 }, { 18, 27, 26 } } },
    { 6, { { 32, 33, 34 }, { 32, 34, 42 }, { 32, 42, 40 } } },
    { 8, { { 44, 52, 45 }, { 45, 52, 53 }, { 45, 53, 46 }, { 46, 53, 54 } } } };
  EXPECT_EQ(elements, expected);
}

// A split cell and one without elements must not count as two whole cells.
TYPED_TEST(MeshPartition, GlobalIdsOfCellsThatAreWhole)
{
  for (const bool isCut : { true, false })
  {
    const PolyData input = MakePlate(8);
    vtkNew<vtkCellArray> polygons;
    AddCell(polygons, isCut ? Ids{ 18, 19, 27, 26 } : Ids{ 18, 19, 27 });
    AddCell(polygons, { 5, 6 });
    input->SetPolys(polygons);
    input->GetCellData()->Initialize();
    vtkNew<vtkIdTypeArray> ids;
    ids->SetName("Global");
    ids->InsertNextValue(8);
    ids->InsertNextValue(9);
    input->GetCellData()->SetGlobalIds(ids);
    const auto filter = Cut<TypeParam>(input, 10);
    for (vtkPolyData* partition : Partitions(*filter))
    {
      EXPECT_EQ(partition->GetCellData()->GetGlobalIds() == nullptr, isCut);
    }
  }
}

TYPED_TEST(MeshPartition, FewPoints)
{
  for (int count = 1; count < 10; ++count)
  {
    std::vector<std::array<double, 3>> points;
    for (int i = 0; i < count; ++i)
    {
      points.push_back({ 1.0 * i, 0, 0 });
    }
    const PolyData input = MakePoints(points);
    AddIds(*input);
    const auto filter = Cut<TypeParam>(input, 1);
    vtkIdType sum = 0;
    for (vtkPolyData* partition : Partitions(*filter))
    {
      EXPECT_LE(partition->GetNumberOfPoints(), 1);
      EXPECT_EQ(partition->GetNumberOfCells(), 0);
      EXPECT_TRUE(partition->GetPointData()->HasArray("Point"));
      sum += partition->GetNumberOfPoints();
    }
    EXPECT_EQ(sum, count);
  }
}

TYPED_TEST(MeshPartition, PassesDataOfEveryKind)
{
  const PolyData input = MakeSphere(30);
  vtkNew<vtkFloatArray> normals;
  normals->SetName("Normals");
  normals->SetNumberOfComponents(3);
  vtkNew<vtkStringArray> names;
  names->SetName("Names");
  vtkNew<vtkIdTypeArray> pointIds, cellIds;
  pointIds->SetName("GlobalPoints");
  cellIds->SetName("GlobalCells");
  for (vtkIdType i = 0; i < input->GetNumberOfPoints(); ++i)
  {
    const double third = 1.0 / 3;
    normals->InsertNextTuple3(double(i), third, -double(i));
    names->InsertNextValue("point " + std::to_string(i));
    pointIds->InsertNextValue((vtkIdType{ 1 } << (8 * sizeof(vtkIdType) - 2)) + i);
  }
  for (vtkIdType c = 0; c < input->GetNumberOfCells(); ++c)
  {
    cellIds->InsertNextValue(2 * c);
  }
  input->GetPointData()->SetNormals(normals);
  input->GetPointData()->AddArray(names);
  input->GetPointData()->SetGlobalIds(pointIds);
  input->GetCellData()->SetGlobalIds(cellIds);
  const auto filter = Cut<TypeParam>(input, 100);
  for (vtkPolyData* partition : Partitions(*filter))
  {
    vtkPointData* const data = partition->GetPointData();
    ASSERT_TRUE(vtkFloatArray::SafeDownCast(data->GetNormals()));
    ASSERT_TRUE(data->GetGlobalIds());
    ASSERT_TRUE(partition->GetCellData()->GetGlobalIds());
    for (vtkIdType i = 0; i < partition->GetNumberOfPoints(); ++i)
    {
      const vtkIdType from = Value(data, "Point", i);
      EXPECT_EQ(data->GetAbstractArray("Names")->GetVariantValue(i).ToString(),
        "point " + std::to_string(from));
      EXPECT_EQ(data->GetNormals()->GetComponent(i, 2), -double(from));
      EXPECT_EQ(
        vtkIdTypeArray::SafeDownCast(data->GetGlobalIds())->GetValue(i), pointIds->GetValue(from));
    }
    for (vtkIdType c = 0; c < partition->GetNumberOfCells(); ++c)
    {
      EXPECT_EQ(Value(partition->GetCellData(), "GlobalCells", c),
        2 * Value(partition->GetCellData(), "Cell", c));
    }
  }
}

// An input as on one rank of several: cells of other ranks, and points that only these use, are
// dropped.
TYPED_TEST(MeshPartition, GhostsInTheInputAreDropped)
{
  const PolyData input = MakePlate(20); // rows of 20 points, and of 38 triangles
  const auto mark = [](vtkDataSetAttributes* data, vtkIdType count, vtkIdType own)
  {
    vtkNew<vtkUnsignedCharArray> marks;
    marks->SetName(vtkDataSetAttributes::GhostArrayName());
    for (vtkIdType i = 0; i < count; ++i)
    {
      marks->InsertNextValue(i < own ? 0 : vtkDataSetAttributes::DUPLICATEPOINT);
    }
    data->AddArray(marks);
  };
  mark(input->GetPointData(), input->GetNumberOfPoints(), 10 * 20);
  mark(input->GetCellData(), input->GetNumberOfCells(), 10 * 38);
  const auto filter = Cut<TypeParam>(input, 50);
  vtkIdType points = 0, cells = 0;
  for (vtkPolyData* partition : Partitions(*filter))
  {
    points += OwnPoints(*partition);
    for (vtkIdType c = 0; c < partition->GetNumberOfCells(); ++c)
    {
      cells += !IsGhost(partition->GetCellData(), c);
    }
  }
  EXPECT_EQ(points, 11 * 20); // the row along the cut belongs to others, but is used
  EXPECT_EQ(cells, 10 * 38);
  EXPECT_EQ(
    vtkPolyData::SafeDownCast(filter->GetOutputDataObject(1))->GetNumberOfPoints(), 11 * 20);
}

}
