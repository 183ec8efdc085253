// SPDX-License-Identifier: BSD-3-Clause
// vtkPartitionMeasures: tables, accepted and refused arrays, pipelines.
#include "filters/Partitioning/Testing/Cxx/PartitionTools.h"
#include "filters/adapter/Testing/SmpBackend.h"

#include <vtkDoubleArray.h>
#include <vtkFloatArray.h>
#include <vtkPartitionMeasures.h>
#include <vtkShortArray.h>
#include <vtkStringArray.h>
#include <vtkTable.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace
{

using namespace kdstream::testing;

vtkTable* Table(vtkPartitionMeasures& filter, int port)
{
  return vtkTable::SafeDownCast(filter.GetOutputDataObject(port));
}

double At(vtkPartitionMeasures& filter, int port, vtkIdType row, const char* column)
{
  vtkDataArray* const array =
    vtkDataArray::SafeDownCast(Table(filter, port)->GetColumnByName(column));
  EXPECT_TRUE(array) << column;
  return array ? array->GetTuple1(row) : -1;
}

// A plate of 7 × 7 points, and an array that divides it at x = 0.4 into three and four columns.
template <class Array>
PolyData CutPlate(double low, double high)
{
  PolyData plate = MakePlate(7);
  vtkNew<Array> ids;
  ids->SetName("PartitionId");
  ids->SetNumberOfTuples(49);
  for (vtkIdType i = 0; i < 49; ++i)
  {
    ids->SetTuple1(i, Point(*plate, i)[0] < 0.4 ? low : high);
  }
  plate->GetPointData()->AddArray(ids);
  return plate;
}

void ExpectEmpty(vtkPartitionMeasures& filter)
{
  EXPECT_EQ(Table(filter, 0)->GetNumberOfRows(), 0);
  EXPECT_EQ(Table(filter, 1)->GetNumberOfRows(), 0);
}

TEST(PartitionMeasuresFilter, ByHand)
{
  vtkNew<vtkPartitionMeasures> filter;
  filter->SetInputData(CutPlate<vtkIdTypeArray>(5, -2)); // rows are in the order of the numbers
  filter->Update();
  ASSERT_EQ(Table(*filter, 0)->GetNumberOfRows(), 2);
  const struct
  {
    const char* column;
    double first, second;
  } rows[] = { { "PartitionId", -2, 5 }, { "Vertices", 28, 21 }, { "Triangles", 48, 36 },
    { "OwnTriangles", 48, 24 }, { "BoundaryLength", 20.0 / 6, 3 }, { "Area", 24.0 / 36, 0.5 },
    { "Compactness", 400.0 / 24 / (4 * 3.14159265358979), 18 / (4 * 3.14159265358979) } };
  for (const auto& row : rows)
  {
    EXPECT_NEAR(At(*filter, 0, 0, row.column), row.first, 1e-6) << row.column;
    EXPECT_NEAR(At(*filter, 0, 1, row.column), row.second, 1e-6) << row.column;
  }
  EXPECT_EQ(Table(*filter, 0)->GetNumberOfColumns(), 7);
  ASSERT_EQ(Table(*filter, 1)->GetNumberOfRows(), 1);
  EXPECT_EQ(Table(*filter, 1)->GetNumberOfColumns(), 17);
  EXPECT_EQ(At(*filter, 1, 0, "Partitions"), 2);
  EXPECT_EQ(At(*filter, 1, 0, "Measured"), 2);
  EXPECT_EQ(At(*filter, 1, 0, "VerticesMinimum"), 21);
  EXPECT_EQ(At(*filter, 1, 0, "VerticesMaximum"), 28);
  EXPECT_EQ(At(*filter, 1, 0, "VerticesMean"), 24.5);
  EXPECT_EQ(At(*filter, 1, 0, "VerticesStandardDeviation"), 3.5);
  EXPECT_EQ(At(*filter, 1, 0, "TrianglesRatio"), 48.0 / 36);
  EXPECT_NEAR(At(*filter, 1, 0, "CompactnessMaximum"), 18 / (4 * 3.14159265358979), 1e-6);
}

TEST(PartitionMeasuresFilter, TakesAnyNumericTypeAndArray)
{
  vtkNew<vtkPartitionMeasures> filter;
  for (const PolyData& input : { CutPlate<vtkDoubleArray>(0, 1), CutPlate<vtkFloatArray>(-1e6, 7),
         CutPlate<vtkShortArray>(3, 4), CutPlate<vtkUnsignedCharArray>(0, 255) })
  {
    filter->SetInputData(input);
    filter->Update();
    ASSERT_EQ(Table(*filter, 0)->GetNumberOfRows(), 2);
    EXPECT_EQ(At(*filter, 0, 0, "Vertices"), 21);
  }
  const PolyData input = CutPlate<vtkIdTypeArray>(0, 1);
  input->GetPointData()->GetArray("PartitionId")->SetName("Region");
  filter->SetInputData(input);
  filter->SetInputArrayToProcess(0, 0, 0, vtkDataObject::FIELD_ASSOCIATION_POINTS, "Region");
  filter->Update();
  EXPECT_EQ(Table(*filter, 0)->GetNumberOfRows(), 2);
  vtkNew<vtkIdTypeArray> large; // larger than a double can hold exactly
  large->SetName("Large");
  for (vtkIdType i = 0; i < 49; ++i)
  {
    large->InsertNextValue(std::numeric_limits<vtkIdType>::max() - i % 2);
  }
  input->GetPointData()->AddArray(large);
  filter->SetInputArrayToProcess(0, 0, 0, vtkDataObject::FIELD_ASSOCIATION_POINTS, "Large");
  filter->Update();
  EXPECT_EQ(Table(*filter, 0)->GetNumberOfRows(), 2);
}

template <class Filter>
class PartitionMeasuresOf : public ::testing::Test
{
};
TYPED_TEST_SUITE(PartitionMeasuresOf, PartitionFilters);

TYPED_TEST(PartitionMeasuresOf, AgreesWithThePartitionsOfTheFilter)
{
  vtkNew<TypeParam> partition;
  partition->SetInputData(MakeSphere(50));
  partition->SetVerticesPerPartition(200);
  partition->GeneratePartitionIdsOn();
  vtkNew<vtkPartitionMeasures> measures;
  measures->SetInputConnection(partition->GetOutputPort(1));
  measures->Update();
  partition->Update();
  const std::vector<vtkPolyData*> partitions = Partitions(*partition);
  ASSERT_EQ(Table(*measures, 0)->GetNumberOfRows(), vtkIdType(partitions.size()));
  for (std::size_t p = 0; p < partitions.size(); ++p)
  {
    const auto row = static_cast<vtkIdType>(p);
    vtkIdType own = 0;
    for (vtkIdType c = 0; c < partitions[p]->GetNumberOfCells(); ++c)
    {
      own += !IsGhost(partitions[p]->GetCellData(), c);
    }
    EXPECT_EQ(At(*measures, 0, row, "PartitionId"), double(p));
    EXPECT_EQ(At(*measures, 0, row, "Vertices"), double(OwnPoints(*partitions[p])));
    EXPECT_EQ(At(*measures, 0, row, "Triangles"), double(partitions[p]->GetNumberOfCells()));
    EXPECT_EQ(At(*measures, 0, row, "OwnTriangles"), double(own));
    EXPECT_GT(At(*measures, 0, row, "Compactness"), 0.5);
  }
}

TEST(PartitionMeasuresFilter, PolygonsAndStripsCountAsTriangles)
{
  const PolyData input = MakeAllCells();
  vtkNew<vtkIdTypeArray> ids;
  ids->SetName("PartitionId");
  ids->SetNumberOfValues(64);
  ids->FillValue(0);
  input->GetPointData()->AddArray(ids);
  vtkNew<vtkPartitionMeasures> filter;
  filter->SetInputData(input);
  filter->Update();
  EXPECT_EQ(At(*filter, 0, 0, "Triangles"), 10);
  EXPECT_EQ(At(*filter, 0, 0, "Vertices"), 64);
}

TEST(PartitionMeasuresFilter, NothingDefined)
{
  vtkNew<vtkPartitionMeasures> filter;
  for (const PolyData& input : { MakeRepeatedPoint(5),
         MakeGrid(5,
           [](double u, double v) {
             return std::array<double, 3>{ u + v, 0, 0 };
           }),
         MakePoints({ { 1, 2, 3 }, { 4, 5, 6 } }) })
  {
    vtkNew<vtkIdTypeArray> ids;
    ids->SetName("PartitionId");
    ids->SetNumberOfValues(input->GetNumberOfPoints());
    ids->FillValue(0);
    input->GetPointData()->AddArray(ids);
    filter->SetInputData(input);
    filter->Update();
    ASSERT_EQ(Table(*filter, 0)->GetNumberOfRows(), 1);
    EXPECT_EQ(At(*filter, 0, 0, "Area"), 0);
    EXPECT_TRUE(std::isnan(At(*filter, 0, 0, "Compactness")));
    EXPECT_EQ(At(*filter, 1, 0, "Measured"), 0);
  }
}

TEST(PartitionMeasuresFilter, EmptyInput)
{
  for (const PolyData& input : { PolyData(PolyData::New()), MakePoints({}) })
  {
    vtkNew<vtkPartitionMeasures> filter;
    FilterObserver observer(filter);
    filter->SetInputData(input);
    filter->Update();
    EXPECT_EQ(observer.error, "");
    EXPECT_EQ(Table(*filter, 0)->GetNumberOfRows(), 0);
    EXPECT_EQ(Table(*filter, 0)->GetNumberOfColumns(), 7);
    EXPECT_EQ(At(*filter, 1, 0, "Partitions"), 0);
  }
}

TEST(PartitionMeasuresFilter, ErrorsNameWhatIsWrong)
{
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const PolyData none = MakePlate(3);
  const PolyData wide = MakePlate(3), notFinite = CutPlate<vtkIdTypeArray>(0, 1);
  vtkNew<vtkIdTypeArray> pairs;
  pairs->SetName("PartitionId");
  pairs->SetNumberOfComponents(2);
  pairs->SetNumberOfTuples(9);
  wide->GetPointData()->AddArray(pairs);
  const PolyData texts = MakePlate(3);
  vtkNew<vtkStringArray> strings;
  strings->SetName("PartitionId");
  strings->SetNumberOfValues(9);
  texts->GetPointData()->AddArray(strings);
  notFinite->GetPoints()->SetPoint(4, nan, 0, 0);
  const PolyData outside = CutPlate<vtkIdTypeArray>(0, 1);
  AddCell(outside->GetPolys(), { 0, 1, 49 });
  const struct
  {
    PolyData input;
    const char* message;
  } cases[] = { { none, "there is no point array of partition ids" },
    { texts, "there is no point array of partition ids" },
    { wide, "the array \"PartitionId\" has 9 tuples of 2 components for 9 points" },
    { CutPlate<vtkDoubleArray>(0, 0.5),
      "the array \"PartitionId\": value 0.500000 of point 3 is not a whole number" },
    { CutPlate<vtkDoubleArray>(nan, 0), "value nan of point 0 is not a whole number" },
    { CutPlate<vtkDoubleArray>(1e300, 0), "is not a whole number" },
    { notFinite, "point 4: a coordinate is not finite" },
    { outside, "uses point 49, but there are 49" } };
  for (const auto& c : cases)
  {
    SCOPED_TRACE(c.message);
    vtkNew<vtkPartitionMeasures> filter;
    filter->SetInputData(CutPlate<vtkIdTypeArray>(0, 1));
    filter->Update();
    ASSERT_EQ(Table(*filter, 0)->GetNumberOfRows(), 2);
    FilterObserver observer(filter);
    filter->SetInputData(c.input);
    filter->Update();
    EXPECT_NE(observer.error.find(c.message), std::string::npos) << observer.error;
    EXPECT_TRUE(observer.failed);
    ExpectEmpty(*filter);
  }
}

TEST(PartitionMeasuresFilter, CellArraysAreRefused)
{
  const PolyData input = MakePlate(3);
  vtkNew<vtkPartitionMeasures> filter;
  FilterObserver observer(filter);
  filter->SetInputData(input);
  filter->SetInputArrayToProcess(0, 0, 0, vtkDataObject::FIELD_ASSOCIATION_CELLS, "Cell");
  filter->Update();
  EXPECT_NE(observer.error.find("has 8 tuples of 1 components for 9 points"), std::string::npos)
    << observer.error;
}

TEST(PartitionMeasuresFilter, RunsAgainOnlyWhenSomethingChanged)
{
  const PolyData input = CutPlate<vtkIdTypeArray>(0, 1);
  vtkNew<vtkPartitionMeasures> filter;
  FilterObserver observer(filter);
  filter->SetInputData(input);
  filter->Update();
  filter->Update();
  filter->Update(1);
  EXPECT_EQ(observer.runs, 1);
  input->Modified();
  filter->Update();
  EXPECT_EQ(observer.runs, 2);
  filter->SetInputArrayToProcess(0, 0, 0, vtkDataObject::FIELD_ASSOCIATION_POINTS, "Point");
  filter->Update();
  EXPECT_EQ(observer.runs, 3);
  EXPECT_EQ(Table(*filter, 0)->GetNumberOfRows(), 49);
}

TEST(PartitionMeasuresFilter, ProgressAbortAndBackends)
{
  const PolyData input = CutPlate<vtkIdTypeArray>(0, 1);
  for (const std::string& backend : smpBackends)
  {
    if (!UseSmpBackend(backend, 4))
    {
      continue;
    }
    vtkNew<vtkPartitionMeasures> filter;
    FilterObserver observer(filter);
    filter->SetInputData(input);
    filter->Update();
    EXPECT_TRUE(std::is_sorted(observer.progress.begin(), observer.progress.end()));
    EXPECT_EQ(observer.progress.back(), 1);
    EXPECT_GT(observer.progress.size(), 2U);
    EXPECT_EQ(At(*filter, 0, 0, "Area"), 0.5);
    for (const double at : { 0.0, 0.3 })
    {
      observer.abortAt = at;
      filter->Modified();
      filter->Update();
      EXPECT_EQ(observer.error, "");
      ExpectEmpty(*filter);
      observer.StopAborting();
      filter->Update();
      EXPECT_EQ(Table(*filter, 0)->GetNumberOfRows(), 2);
    }
  }
}

TEST(PartitionMeasuresFilter, Prints)
{
  vtkNew<vtkPartitionMeasures> filter;
  std::ostringstream text;
  filter->Print(text);
  EXPECT_NE(text.str().find("vtkPartitionMeasures"), std::string::npos);
}

}
