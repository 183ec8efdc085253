// SPDX-License-Identifier: BSD-3-Clause
// Composite data as one mesh: which points become one, and which cells and arrays stay.
#include "Testing/Fixtures/ErrorAt.h"
#include "filters/adapter/JoinPolyData.h"
#include "filters/adapter/SharedArrays.h"
#include "filters/adapter/Testing/FilterTools.h"

#include <gtest/gtest.h>
#include <vtkDoubleArray.h>
#include <vtkFloatArray.h>
#include <vtkImageData.h>
#include <vtkIntArray.h>
#include <vtkMultiBlockDataSet.h>
#include <vtkPartitionedDataSet.h>
#include <vtkPartitionedDataSetCollection.h>
#include <vtkUnsignedCharArray.h>

namespace
{

using namespace kdstream;
using namespace kdstream::testing;

constexpr unsigned char duplicate = vtkDataSetAttributes::DUPLICATEPOINT; // for cells, too

void Mark(vtkDataSetAttributes* data, const std::vector<unsigned char>& marks)
{
  vtkNew<vtkUnsignedCharArray> array;
  array->SetName(vtkDataSetAttributes::GhostArrayName());
  for (const unsigned char mark : marks)
  {
    array->InsertNextValue(mark);
  }
  data->AddArray(array);
}

void SetGlobalIds(vtkDataSetAttributes* data, const Ids& ids)
{
  vtkNew<vtkIdTypeArray> array;
  array->SetName("GlobalIds");
  for (const vtkIdType id : ids)
  {
    array->InsertNextValue(id);
  }
  data->SetGlobalIds(array);
}

// A square of two triangles, from x to x + 1: points 0 and 2 are on its left side, 1 and 3 on its
// right.
PolyData Square(double x)
{
  const PolyData mesh =
    MakePoints({ { x, 0, 0 }, { x + 1, 0, 0 }, { x, 1, 0 }, { x + 1, 1, 0 } }, VTK_FLOAT);
  vtkNew<vtkCellArray> cells;
  AddCell(cells, { 0, 1, 2 });
  AddCell(cells, { 1, 3, 2 });
  mesh->SetPolys(cells);
  return mesh;
}

vtkSmartPointer<vtkPartitionedDataSet> Parts(const std::vector<PolyData>& meshes)
{
  auto parts = vtkSmartPointer<vtkPartitionedDataSet>::New();
  for (const PolyData& mesh : meshes)
  {
    parts->SetPartition(parts->GetNumberOfPartitions(), mesh);
  }
  return parts;
}

JoinedPolyData Join(vtkDataObject& input, bool weldByPlace = false)
{
  const auto joined = JoinPolyData(input, weldByPlace, {});
  EXPECT_TRUE(joined) << joined.GetError().message;
  return joined ? *joined : JoinedPolyData{ PolyData::New(), {} };
}

TEST(JoinPolyData, EveryKindOfCompositeAndEmptyBlocks)
{
  vtkNew<vtkPartitionedDataSetCollection> collection;
  collection->SetPartitionedDataSet(0, Parts({ Square(0), nullptr }));
  collection->SetPartitionedDataSet(2, Parts({ Square(2) }));
  vtkNew<vtkMultiBlockDataSet> blocks, inner;
  inner->SetBlock(1, Square(2));
  inner->SetBlock(3, vtkSmartPointer<vtkImageData>::New()); // has no points
  blocks->SetBlock(0, Square(0));
  blocks->SetBlock(1, PolyData::New());
  blocks->SetBlock(4, inner);
  const std::string both = Describe(*Join(*Parts({ Square(0), Square(2) })).mesh);
  EXPECT_EQ(Describe(*Join(*collection).mesh), both);
  EXPECT_EQ(Describe(*Join(*blocks).mesh), both);
  EXPECT_EQ(Join(*Parts({ nullptr, PolyData::New() })).mesh->GetNumberOfPoints(), 0);
  const PolyData square = Square(0);
  EXPECT_EQ(Describe(*Join(*square).mesh), Describe(*square));
}

// A mesh with such cells is not the same as an empty mesh.
TEST(JoinPolyData, CellsOfPointsThatAreNotThere)
{
  const PolyData mesh = PolyData::New();
  mesh->SetPolys(Square(0)->GetPolys());
  const auto joined = JoinPolyData(*mesh, false, {});
  EXPECT_TRUE(fixtures::FailsAt(joined, ErrorCode::InvalidInput, "cell 0 uses point 0"));
  const auto parts = JoinPolyData(*Parts({ Square(0), mesh }), false, {});
  EXPECT_TRUE(fixtures::FailsAt(parts, ErrorCode::InvalidInput, "partition 1: cell 0 "));
}

TEST(JoinPolyData, SharedBordersByPlaceOnlyWhereAsked)
{
  const auto parts = Parts({ Square(0), Square(1) });
  EXPECT_EQ(Join(*parts).mesh->GetNumberOfPoints(), 8);
  const JoinedPolyData welded = Join(*parts, true);
  EXPECT_EQ(welded.mesh->GetNumberOfPoints(), 6);
  EXPECT_EQ(welded.mesh->GetNumberOfCells(), 4);
  EXPECT_EQ(CellPoints(*welded.mesh, 2), (Ids{ 1, 4, 3 }));
}

TEST(JoinPolyData, PointsOfOnePartStayApart)
{
  const PolyData twice = MakePoints({ { 0, 0, 0 }, { 0, 0, 0 } });
  EXPECT_EQ(Join(*Parts({ twice, twice }), true).mesh->GetNumberOfPoints(), 2);
  EXPECT_EQ(Join(*Parts({ twice }), true).mesh->GetNumberOfPoints(), 2);
}

TEST(JoinPolyData, SharedBordersByGlobalIdsInTheirOrder)
{
  const PolyData left = Square(0), right = Square(1);
  SetGlobalIds(left->GetPointData(), { 10, 11, 20, 21 });
  SetGlobalIds(right->GetPointData(), { 11, 12, 21, 22 });
  SetGlobalIds(left->GetCellData(), { 2, 3 });
  SetGlobalIds(right->GetCellData(), { 0, 1 });
  const JoinedPolyData joined = Join(*Parts({ left, right }));
  ASSERT_EQ(joined.mesh->GetNumberOfPoints(), 6);
  vtkDataArray* const ids = joined.mesh->GetPointData()->GetGlobalIds();
  ASSERT_TRUE(ids);
  for (vtkIdType i = 0; i < 6; ++i)
  {
    EXPECT_EQ(ids->GetTuple1(i), (std::array{ 10, 11, 12, 20, 21, 22 })[std::size_t(i)]);
  }
  EXPECT_EQ(CellPoints(*joined.mesh, 0), (Ids{ 1, 2, 4 })); // a cell of the right square
  EXPECT_EQ(joined.mesh->GetCellData()->GetGlobalIds()->GetTuple1(3), 3);
}

// Two files, both with ids that begin at 0.
TEST(JoinPolyData, GlobalIdsOfDifferentPlacesAreNotBelieved)
{
  const PolyData left = Square(0), right = Square(1);
  for (const PolyData& square : { left, right })
  {
    SetGlobalIds(square->GetPointData(), { 0, 1, 2, 3 });
    SetGlobalIds(square->GetCellData(), { 0, 1 });
  }
  const JoinedPolyData joined = Join(*Parts({ left, right }));
  EXPECT_EQ(joined.mesh->GetNumberOfPoints(), 8);
  EXPECT_EQ(joined.mesh->GetNumberOfCells(), 4);
  ASSERT_EQ(joined.leftOut.size(), 1U);
  EXPECT_NE(joined.leftOut[0].find("global ids \"GlobalIds\": "), std::string::npos);
  EXPECT_FALSE(joined.mesh->GetPointData()->GetGlobalIds());
  EXPECT_FALSE(joined.mesh->GetCellData()->GetGlobalIds());
  EXPECT_EQ(Join(*Parts({ left, right }), true).mesh->GetNumberOfPoints(), 6);
}

// The left square owns the border. The first cell of the right square is the last one of the left.
TEST(JoinPolyData, GhostsAreThePointsTheyAreCopiesOf)
{
  const PolyData left = Square(0), right = Square(1);
  Mark(right->GetPointData(), { duplicate, 0, duplicate, 0 });
  const JoinedPolyData joined = Join(*Parts({ left, right }));
  EXPECT_EQ(joined.mesh->GetNumberOfPoints(), 6);
  EXPECT_EQ(CellPoints(*joined.mesh, 2), (Ids{ 1, 4, 3 }));
  EXPECT_FALSE(joined.mesh->GetPointData()->HasArray("vtkGhostType"));
  EXPECT_TRUE(joined.leftOut.empty());

  Mark(right->GetCellData(), { duplicate, duplicate });
  const JoinedPolyData dropped = Join(*Parts({ left, right }));
  EXPECT_EQ(dropped.mesh->GetNumberOfCells(), 2);
  EXPECT_EQ(dropped.mesh->GetNumberOfPoints(), 6) << "own points stay";
  const JoinedPolyData withoutOwner = Join(*Parts({ right }));
  EXPECT_EQ(withoutOwner.mesh->GetNumberOfPoints(), 2);
}

TEST(JoinPolyData, PointsOfDroppedCellsGoWherePointsAreNotMarked)
{
  const PolyData square = Square(0);
  Mark(square->GetCellData(), { 0, duplicate });
  const JoinedPolyData joined = Join(*square);
  EXPECT_EQ(joined.mesh->GetNumberOfCells(), 1);
  EXPECT_EQ(joined.mesh->GetNumberOfPoints(), 3);
}

// Two points in one place that differ in an array, and a copy of each.
TEST(JoinPolyData, CopiesGoToThePointWithTheSameValues)
{
  const auto part = [](bool isCopy)
  {
    const PolyData mesh = MakePoints({ { 0, 0, 0 }, { 0, 0, 0 }, { 1, 0, 0 } });
    vtkNew<vtkDoubleArray> side;
    side->SetName("Side");
    for (const double value : { isCopy ? 2.0 : 1.0, isCopy ? 1.0 : 2.0, 3.0 })
    {
      side->InsertNextValue(value);
    }
    mesh->GetPointData()->AddArray(side);
    vtkNew<vtkCellArray> cells;
    AddCell(cells, { 0, 1, 2 });
    mesh->SetPolys(cells);
    return mesh;
  };
  const PolyData copies = part(true);
  Mark(copies->GetPointData(), { duplicate, duplicate, duplicate });
  const JoinedPolyData joined = Join(*Parts({ copies, part(false) }));
  ASSERT_EQ(joined.mesh->GetNumberOfPoints(), 3);
  EXPECT_EQ(CellPoints(*joined.mesh, 0), (Ids{ 1, 0, 2 }));
  EXPECT_EQ(CellPoints(*joined.mesh, 1), (Ids{ 0, 1, 2 }));
}

TEST(JoinPolyData, ManyPointsInOnePlaceTakeNoLongerThanOthers)
{
  const std::vector<std::array<double, 3>> places(200000);
  const PolyData own = MakePoints(places), copies = MakePoints(places);
  vtkNew<vtkCellArray> cells;
  for (vtkIdType i = 0; i < 200000; ++i)
  {
    AddCell(cells, { i });
  }
  copies->SetVerts(cells);
  Mark(copies->GetPointData(), std::vector<unsigned char>(places.size(), duplicate));
  EXPECT_EQ(Join(*Parts({ own, copies })).mesh->GetNumberOfPoints(), 200000);
}

TEST(JoinPolyData, ArraysThatNotAllPartsHaveAreListedOnce)
{
  const PolyData left = Square(0), right = Square(1), other = Square(2);
  const auto add = [](const PolyData& mesh, const char* name, int components, vtkIdType tuples)
  {
    vtkNew<vtkDoubleArray> array;
    array->SetName(name);
    array->SetNumberOfComponents(components);
    array->SetNumberOfTuples(tuples);
    array->FillValue(1);
    mesh->GetPointData()->AddArray(array);
  };
  for (const PolyData& mesh : { left, right, other })
  {
    add(mesh, "All", 1, 4);
    add(mesh, "Components", mesh == other ? 2 : 1, 4);
    add(mesh, "Short", 1, mesh == right ? 3 : 4);
  }
  add(right, "One", 1, 4);
  const JoinedPolyData joined = Join(*Parts({ left, right, other }));
  EXPECT_EQ(
    joined.leftOut, (std::vector<std::string>{ "point array \"Short\": has 3 tuples for 4 points",
                      "point array \"Components\": not all parts have it",
                      "point array \"One\": not all parts have it" }));
  EXPECT_EQ(joined.mesh->GetPointData()->GetNumberOfArrays(), 1);
  EXPECT_EQ(joined.mesh->GetPointData()->GetArray("All")->GetNumberOfTuples(), 12);
  const JoinedPolyData whole = Join(*right);
  EXPECT_EQ(whole.leftOut.size(), 1U);
  EXPECT_EQ(whole.mesh->GetPointData()->GetNumberOfArrays(), 3);
  EXPECT_EQ(right->GetPointData()->GetNumberOfArrays(), 4) << "the input is not changed";
}

// Otherwise ghosts would be counted as own cells, without a message.
TEST(JoinPolyData, GhostArraysThatCannotBeUsedAreListed)
{
  const PolyData shorter = Square(1), other = Square(2), good = Square(0);
  Mark(good->GetCellData(), { 0, duplicate });
  Mark(shorter->GetCellData(), { duplicate });
  vtkNew<vtkIntArray> ints;
  ints->SetName(vtkDataSetAttributes::GhostArrayName());
  ints->SetNumberOfTuples(4);
  ints->FillValue(duplicate);
  other->GetPointData()->AddArray(ints);
  const JoinedPolyData joined = Join(*Parts({ good, shorter, other }));
  EXPECT_EQ(
    joined.leftOut, (std::vector<std::string>{
                      "point array \"vtkGhostType\": is not one unsigned char for each point",
                      "cell array \"vtkGhostType\": has 1 tuples for 2 cells" }));
  EXPECT_EQ(joined.mesh->GetNumberOfCells(), 5);
  const JoinedPolyData whole = Join(*other);
  EXPECT_EQ(
    whole.leftOut, (std::vector<std::string>{
                     "point array \"vtkGhostType\": is not one unsigned char for each point" }));
  EXPECT_EQ(whole.mesh->GetPointData()->GetNumberOfArrays(), 0);
}

TEST(JoinPolyData, IdsOfCellsAreDistinctOverAllKinds)
{
  const PolyData vertices = Square(0), triangles = Square(1);
  vtkNew<vtkCellArray> cells;
  AddCell(cells, { 1 });
  AddCell(cells, { 0 });
  vertices->SetPolys(nullptr);
  vertices->SetVerts(cells);
  for (const vtkIdType first : { 10, 4 })
  {
    SetGlobalIds(vertices->GetCellData(), { first + 1, first });
    SetGlobalIds(triangles->GetCellData(), { 5, 4 });
    const JoinedPolyData joined = Join(*Parts({ vertices, triangles }));
    vtkDataSetAttributes* const data = joined.mesh->GetCellData();
    ASSERT_TRUE(data->HasArray("GlobalIds"));
    EXPECT_EQ(data->GetGlobalIds() != nullptr, first == 10);
    Ids ids;
    for (vtkIdType i = 0; i < joined.mesh->GetNumberOfCells(); ++i)
    {
      ids.push_back(static_cast<vtkIdType>(data->GetArray("GlobalIds")->GetComponent(i, 0)));
    }
    EXPECT_EQ(ids, first == 10 ? (Ids{ 10, 11, 4, 5 }) : (Ids{ 5, 4, 5, 4 }));
  }
}

// Counts how often it is compared.
class CountedArray : public vtkFloatArray
{
public:
  static CountedArray* New();
  vtkTypeMacro(CountedArray, vtkFloatArray);
  int GetDataType() const override
  {
    ++compared;
    return this->Superclass::GetDataType();
  }
  static inline std::size_t compared = 0;
};
vtkStandardNewMacro(CountedArray);

TEST(JoinPolyData, ArraysAreComparedOnceForEachPart)
{
  constexpr std::size_t count = 2000;
  std::vector<vtkNew<vtkPointData>> datas(count);
  std::vector<PartData> parts;
  for (const auto& data : datas)
  {
    vtkNew<CountedArray> array;
    array->SetName("Counted");
    array->SetNumberOfTuples(1);
    data->AddArray(array);
    parts.push_back({ data, 1 });
  }
  std::vector<std::string> leftOut;
  CountedArray::compared = 0;
  EXPECT_EQ(FindSharedArrays(parts, "point", leftOut).size(), 1U);
  EXPECT_TRUE(leftOut.empty());
  EXPECT_LT(CountedArray::compared, 10 * count);
}

TEST(JoinPolyData, ErrorsNameThePart)
{
  const PolyData offsets = Square(0);
  offsets->SetPolys(MakeCells({ 0, 1000000 }, { 0, 1, 2 }));
  const double nan = std::nan("");
  const PolyData outside = Square(0);
  AddCell(outside->GetPolys(), { 0, 1, 4 });
  vtkNew<vtkImageData> image;
  image->SetDimensions(2, 2, 2);
  const std::vector<std::pair<PolyData, std::string>> cases{
    { MakePoints({ { 0, nan, 0 } }), "partition 1: point 0: " },
    { outside, "partition 1: cell 2 uses point 4" },
    { offsets, "partition 1: cell 0 uses corners 0 to 1000000" },
  };
  for (const auto& [bad, place] : cases)
  {
    const auto joined = JoinPolyData(*Parts({ Square(0), bad }), false, {});
    EXPECT_TRUE(fixtures::FailsAt(joined, ErrorCode::InvalidInput, place));
  }
  const auto joined = JoinPolyData(*image, false, {});
  ASSERT_FALSE(joined);
  EXPECT_EQ(joined.GetError().code, ErrorCode::InvalidInput);
  EXPECT_NE(joined.GetError().message.find("vtkImageData"), std::string::npos);
}

}
