// SPDX-License-Identifier: BSD-3-Clause
// vtkPolyData to core's types: order, kinds and orientation of elements, and what is refused.
#include "Testing/Fixtures/ErrorAt.h"
#include "filters/adapter/PolyDataMesh.h"

#include "filters/adapter/MeshPolyData.h"
#include "filters/adapter/SmpFor.h"
#include "filters/adapter/Testing/FilterTools.h"
#include "filters/adapter/Testing/SmpBackend.h"

#include <gtest/gtest.h>

#include <vtkBitArray.h>
#include <vtkDoubleArray.h>
#include <vtkFloatArray.h>
#include <vtkIdTypeArray.h>
#include <vtkMath.h>
#include <vtkNew.h>
#include <vtkSOADataArrayTemplate.h>
#include <vtkTypeUInt64Array.h>
#include <vtkUnsignedCharArray.h>

#include <atomic>
#include <cmath>
#include <limits>
#include <random>

namespace kdstream
{
namespace
{

using namespace kdstream::testing;

TEST(PolyDataMesh, ElementsOfAllKindsInTheOrderOfCells)
{
  const Result<PolyDataElements> elements = ReadElements(*MakeAllCells());
  ASSERT_TRUE(elements);
  EXPECT_EQ(elements->vertices, 4U);
  EXPECT_EQ(elements->segments, 4U);
  const std::vector<Triangle> expected{ { 3, 3, 3 }, { 0, 0, 0 }, { 63, 63, 63 }, { 7, 7, 7 },
    { 0, 63, 63 }, { 8, 9, 9 }, { 9, 17, 17 }, { 17, 16, 16 }, { 0, 1, 8 }, { 18, 19, 27 },
    { 18, 27, 26 }, { 32, 33, 34 }, { 32, 34, 42 }, { 32, 42, 40 }, { 44, 52, 45 }, { 45, 52, 53 },
    { 45, 53, 46 }, { 46, 53, 54 } };
  EXPECT_EQ(elements->corners, expected);
  EXPECT_EQ(elements->cells, (Ids{ 0, 1, 1, 1, 2, 3, 3, 3, 4, 5, 5, 6, 6, 6, 8, 8, 8, 8 }));
  EXPECT_EQ(elements->Triangles().size(), 10U);
  EXPECT_EQ(elements->Triangles()[0], (Triangle{ 0, 1, 8 }));
}

// A large mesh can be cancelled after every 2^18 points or triangles.
TEST(PolyDataMesh, FillingStopsBetweenItsSteps)
{
  Mesh mesh;
  mesh.points.assign(std::size_t{ 5 } << 17, Vec3{ 1, 2, 3 }); // 2.5 steps
  mesh.triangles.assign(std::size_t{ 7 } << 17, Triangle{ 0, 1, 2 });
  int most = 100, reported = 0;
  Execution execution;
  execution.progress = [&](std::string_view step, double)
  {
    EXPECT_EQ(step, "fill");
    return ++reported < most;
  };
  const auto fill = [&]
  {
    reported = 0;
    const vtkNew<vtkPolyData> output;
    return FillPolyData(
      mesh, 0, [](const AttributeInfo&) { return true; }, *output, execution);
  };
  EXPECT_TRUE(fill());
  EXPECT_EQ(reported, 2 + 3);
  for (most = 1; most <= 5; ++most)
  {
    const Status stopped = fill();
    ASSERT_FALSE(stopped);
    EXPECT_EQ(stopped.GetError().code, ErrorCode::Cancelled);
    EXPECT_EQ(reported, most);
  }
}

// A random star around the origin, in a tilted plane; it is usually concave. The area vectors of
// its triangles must add up to its own, and none may point the opposite way.
TEST(PolyDataMesh, ConcavePolygonsAreCutInside)
{
  std::mt19937 random(5);
  std::uniform_real_distribution<double> radius(0.2, 1);
  for (std::size_t corners = 4; corners < 40; ++corners)
  {
    std::vector<std::array<double, 3>> points(3, { 9, 9, 9 }); // so that ids differ from indices in
                                                               // the polygon
    Ids polygon;
    for (std::size_t i = 0; i < corners; ++i)
    {
      const double angle = 2 * vtkMath::Pi() * double(i) / double(corners), r = radius(random);
      polygon.push_back(static_cast<vtkIdType>(points.size()));
      points.push_back({ r * std::cos(angle), r * std::sin(angle), 0.5 * r * std::sin(angle) });
    }
    const PolyData mesh = MakePoints(points);
    const vtkNew<vtkCellArray> cells;
    cells->InsertNextCell(static_cast<vtkIdType>(corners), polygon.data());
    mesh->SetPolys(cells);
    const Result<PolyDataElements> elements = ReadElements(*mesh);
    ASSERT_TRUE(elements);
    ASSERT_EQ(elements->corners.size(), corners - 2);
    double whole = 0, sum = 0;
    const auto area = [&](vtkIdType a, vtkIdType b)
    {
      const auto &p = points[static_cast<std::size_t>(a)], &q = points[static_cast<std::size_t>(b)];
      return (p[0] * q[1] - p[1] * q[0]) / 2;
    };
    for (std::size_t i = 0; i < corners; ++i)
    {
      whole += area(polygon[i], polygon[(i + 1) % corners]);
    }
    for (const Triangle& t : elements->corners)
    {
      const double one = area(t[0], t[1]) + area(t[1], t[2]) + area(t[2], t[0]);
      EXPECT_GE(one, -1e-12) << corners;
      sum += std::abs(one);
    }
    EXPECT_NEAR(sum, whole, 1e-9) << corners;
  }
}

// No ear can be cut from a polygon without an inside. It becomes a fan, and no triangle is lost.
TEST(PolyDataMesh, PolygonsWithoutAnInsideAreFans)
{
  const PolyData mesh = MakePoints({ { 0, 0, 0 }, { 1, 0, 0 }, { 3, 0, 0 }, { 2, 0, 0 } });
  const Ids polygon{ 0, 1, 2, 3 };
  const vtkNew<vtkCellArray> cells;
  cells->InsertNextCell(4, polygon.data());
  mesh->SetPolys(cells);
  EXPECT_EQ(ReadElements(*mesh)->corners, (std::vector<Triangle>{ { 0, 1, 2 }, { 0, 2, 3 } }));
}

TEST(PolyDataMesh, PointsBitForBit)
{
  const double tiny = std::numeric_limits<double>::denorm_min();
  const PolyData mesh = MakePoints({ { 0.1, -0.0, tiny }, { 1e300, 2, 3 } });
  const Result<Mesh> read = ReadMesh(*mesh, {});
  ASSERT_TRUE(read);
  EXPECT_EQ(read->points, (std::vector<Vec3>{ { 0.1, -0.0, tiny }, { 1e300, 2, 3 } }));
  EXPECT_TRUE(std::signbit(read->points[0][1]));
  EXPECT_EQ(read->scalarType, ScalarType::Float64);
  EXPECT_TRUE(read->triangles.empty());
  EXPECT_EQ(ReadMesh(*MakePoints({ { 1, 2, 3 } }, VTK_FLOAT), {})->scalarType, ScalarType::Float32);
  EXPECT_EQ(ReadMesh(*MakePoints({ { 1, 2, 3 } }, VTK_INT), {})->scalarType, ScalarType::Float64);
  EXPECT_TRUE(ReadMesh(*PolyData::New(), {})->points.empty());
}

TEST(PolyDataMesh, NotFinite)
{
  for (const double bad : { std::numeric_limits<double>::quiet_NaN(),
         std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity() })
  {
    for (std::size_t k = 0; k < 3; ++k)
    {
      std::vector<std::array<double, 3>> points(20, { 1, 2, 3 });
      points[17][k] = bad;
      const Result<std::vector<Vec3>> read = ReadPoints(*MakePoints(points), {});
      ASSERT_FALSE(read);
      EXPECT_EQ(read.GetError().code, ErrorCode::InvalidInput);
      EXPECT_EQ(read.GetError().message.rfind("point 17: ", 0), 0U);
    }
  }
}

TEST(PolyDataMesh, PointOutOfRangeInEachKindOfCell)
{
  const std::vector<std::string> cells{ "1", "3", "7", "8" };
  for (std::size_t kind = 0; kind < 4; ++kind)
  {
    for (const vtkIdType bad : { vtkIdType{ 64 }, vtkIdType{ -1 }, vtkIdType{ 1 } << 40 })
    {
      const PolyData mesh = MakeAllCells();
      vtkCellArray* const arrays[] = { mesh->GetVerts(), mesh->GetLines(), mesh->GetPolys(),
        mesh->GetStrips() };
      const vtkIdType last = arrays[kind]->GetNumberOfCells() - 1;
      vtkNew<vtkIdList> points;
      arrays[kind]->GetCellAtId(last, points);
      points->SetId(points->GetNumberOfIds() - 1, bad);
      arrays[kind]->ReplaceCellAtId(last, points);
      const Result<PolyDataElements> read = ReadElements(*mesh);
      EXPECT_TRUE(fixtures::FailsAt(read, ErrorCode::InvalidInput,
        "cell " + cells[kind] + " uses point " + std::to_string(bad)));
    }
  }
}

// Nothing may be read beyond the end of the connectivity.
TEST(PolyDataMesh, InvalidOffsetsInEachKindOfCell)
{
  const std::vector<std::pair<Ids, std::string>> cases{
    { { 0, 1000000 }, "uses corners 0 to 1000000 of a list of 3" },
    { { 0, 3, 1, 3 }, "uses corners 3 to 1 of a list of 3" },
    { { -1000000, 3 }, "uses corners -1000000 to 3 of a list of 3" },
    { { 1000000, 1000000 }, "uses corners 1000000 to 1000000 of a list of 3" },
    { {}, "no offsets" },
  };
  const Ids firstOfKind{ 0, 2, 4, 8 };
  for (std::size_t kind = 0; kind < 4; ++kind)
  {
    for (const auto& [offsets, message] : cases)
    {
      SCOPED_TRACE(message + " in kind " + std::to_string(kind));
      const PolyData mesh = MakeAllCells();
      const auto cells = MakeCells(offsets, { 0, 1, 2 });
      const auto set = { &vtkPolyData::SetVerts, &vtkPolyData::SetLines, &vtkPolyData::SetPolys,
        &vtkPolyData::SetStrips };
      (*mesh.*std::data(set)[kind])(cells);
      const Result<PolyDataElements> read = ReadElements(*mesh);
      ASSERT_FALSE(read);
      EXPECT_EQ(read.GetError().code, ErrorCode::InvalidInput);
      EXPECT_NE(read.GetError().message.find(message), std::string::npos)
        << read.GetError().message;
      const bool isSecond = offsets.size() == 4;
      EXPECT_TRUE(
        offsets.empty() || read.GetError().message.rfind(
                             "cell " + std::to_string(firstOfKind[kind] + isSecond) + " ", 0) == 0)
        << read.GetError().message;
      const Status checked = CheckCells(*mesh);
      ASSERT_FALSE(checked);
      EXPECT_EQ(checked.GetError().message, read.GetError().message);
    }
  }
}

// By VTK's rules the last offset is the length of the connectivity; a longer one does no harm.
TEST(PolyDataMesh, CornersThatNoCellHas)
{
  const PolyData mesh = MakePoints({ { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 } });
  mesh->SetPolys(MakeCells({ 0, 3 }, { 0, 1, 2, 2, 1 }));
  const Result<PolyDataElements> read = ReadElements(*mesh);
  ASSERT_TRUE(read) << read.GetError().message;
  EXPECT_EQ(read->corners, (std::vector<Triangle>{ { 0, 1, 2 } }));
}

TEST(PolyDataMesh, PointsOfTwoCoordinates)
{
  const PolyData mesh = MakePoints({ { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 }, { 1, 1, 0 } });
  mesh->GetPoints()->GetData()->SetNumberOfComponents(2);
  const Result<std::vector<Vec3>> read = ReadPoints(*mesh, {});
  EXPECT_TRUE(fixtures::FailsAt(read, ErrorCode::InvalidInput, "2 coordinates"));
}

template <class Array>
Result<std::vector<std::int64_t>> LabelsFrom(const std::vector<typename Array::ValueType>& values)
{
  vtkNew<Array> array;
  array->SetName("Of");
  array->SetNumberOfComponents(1); // required by vtkSOADataArrayTemplate
  array->SetNumberOfTuples(static_cast<vtkIdType>(values.size()));
  for (std::size_t i = 0; i < values.size(); ++i)
  {
    array->SetValue(static_cast<vtkIdType>(i), values[i]);
  }
  return ReadLabels(*array, array->GetNumberOfTuples());
}

// Labels must be exact in every type, also in arrays that VTK's dispatch may not know.
TEST(PolyDataMesh, LabelsOfEveryArray)
{
  using Labels = std::vector<std::int64_t>;
  constexpr std::int64_t large = (std::int64_t{ 1 } << 60) + 1, most = std::int64_t{ 1 } << 53;
  EXPECT_EQ(*LabelsFrom<vtkIdTypeArray>({ large, -large, 0 }), (Labels{ large, -large, 0 }));
  EXPECT_EQ(*LabelsFrom<vtkTypeUInt64Array>({ large, 7 }), (Labels{ large, 7 }));
  EXPECT_EQ(*LabelsFrom<vtkSOADataArrayTemplate<long long>>({ large, -7 }), (Labels{ large, -7 }));
  EXPECT_EQ(*LabelsFrom<vtkUnsignedCharArray>({ 255, 0 }), (Labels{ 255, 0 }));
  EXPECT_EQ(*LabelsFrom<vtkFloatArray>({ -3, 16777216 }), (Labels{ -3, 16777216 }));
  EXPECT_EQ(*LabelsFrom<vtkDoubleArray>({ double(most), -0.0 }), (Labels{ most, 0 }));
  EXPECT_EQ(
    *LabelsFrom<vtkSOADataArrayTemplate<double>>({ 5, -double(most) }), (Labels{ 5, -most }));
  vtkNew<vtkBitArray> bits;
  for (const int bit : { 1, 0, 1 })
  {
    bits->InsertNextValue(bit);
  }
  EXPECT_EQ(*ReadLabels(*bits, 3), (Labels{ 1, 0, 1 }));
}

TEST(PolyDataMesh, LabelsThatAreNotWholeNumbers)
{
  const double nan = std::numeric_limits<double>::quiet_NaN(), beyond = 9007199254740994;
  const std::vector<std::pair<double, std::string>> cases{ { 0.5, "0.500000" }, { nan, "nan" },
    { beyond, "9007199254740994.000000" } };
  for (const auto& [value, text] : cases)
  {
    for (const auto& labels : { LabelsFrom<vtkDoubleArray>({ 1, 2, value, 0.25 }),
           LabelsFrom<vtkSOADataArrayTemplate<double>>({ 1, 2, value, 0.25 }) })
    {
      EXPECT_TRUE(fixtures::FailsAt(
        labels, ErrorCode::InvalidInput, "\"Of\": value " + text + " of point 2"));
    }
  }
}

TEST(SmpFor, CoversEveryItemOnceOnEveryBackend)
{
  for (const std::string& backend : smpBackends)
  {
    for (const int threads : { 8, 2, 1 })
    {
      if (!UseSmpBackend(backend, threads))
      {
        continue;
      }
      for (const std::size_t count : { 0U, 1U, 7U, 1000U })
      {
        for (const std::size_t grain : { 1U, 3U, 5000U })
        {
          std::vector<std::atomic<int>> visits(count);
          SmpFor(count, grain,
            [&](std::size_t begin, std::size_t end)
            {
              EXPECT_LT(begin, end);
              for (std::size_t i = begin; i < end; ++i)
              {
                ++visits[i];
              }
            });
          for (const std::atomic<int>& visit : visits)
          {
            ASSERT_EQ(visit, 1);
          }
        }
      }
    }
  }
}

}
}
