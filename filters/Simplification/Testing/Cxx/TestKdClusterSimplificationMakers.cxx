// SPDX-License-Identifier: BSD-3-Clause
// vtkKdClusterSimplification: collapse, targets, clusters from an array, normals and colours.
#include "filters/Simplification/SimplifiedLevel.h"
#include "filters/adapter/Testing/FilterTools.h"
#include "filters/adapter/Testing/SmpBackend.h"

#include <gtest/gtest.h>
#include <vtkCellData.h>
#include <vtkDoubleArray.h>
#include <vtkFloatArray.h>
#include <vtkKdClusterSimplification.h>
#include <vtkUnsignedCharArray.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>
#include <string>

namespace
{

using namespace kdstream;
using namespace kdstream::testing;

using Filter = vtkSmartPointer<vtkKdClusterSimplification>;

Filter MakeFilter(const PolyData& input, int maker)
{
  auto filter = Filter::New();
  filter->SetInputData(input);
  filter->SetMaker(maker);
  return filter;
}

// Adds arrays to points and cells: the place, whose mean must be the mean place; classes for two
// halves; a constant.
void AddArrays(vtkPolyData& mesh)
{
  const auto add = [](vtkDataSetAttributes* data, vtkIdType count, const auto& placeOf)
  {
    vtkNew<vtkDoubleArray> places;
    places->SetName("Place");
    places->SetNumberOfComponents(3);
    vtkNew<vtkUnsignedCharArray> halves;
    halves->SetName("Half");
    vtkNew<vtkFloatArray> heat;
    heat->SetName("Heat");
    for (vtkIdType i = 0; i < count; ++i)
    {
      const auto place = placeOf(i);
      places->InsertNextTuple(place.data());
      halves->InsertNextValue(place[0] > 0 ? 200 : 10);
      heat->InsertNextValue(36.5f);
    }
    data->AddArray(places);
    data->AddArray(halves);
    data->SetScalars(heat);
  };
  add(mesh.GetPointData(), mesh.GetNumberOfPoints(), [&](vtkIdType i) { return Point(mesh, i); });
  add(mesh.GetCellData(), mesh.GetNumberOfCells(),
    [&](vtkIdType i)
    {
      std::array<double, 3> centre{};
      for (const vtkIdType id : CellPoints(mesh, i))
      {
        for (std::size_t k = 0; k < 3; ++k)
        {
          centre[k] += Point(mesh, id)[k] / 3;
        }
      }
      return centre;
    });
}

double Distance(const std::array<double, 3>& a, const double* b)
{
  return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

// Converts a triangle mesh to points and triangles.
Mesh MeshOf(vtkPolyData& input)
{
  Mesh mesh;
  for (vtkIdType i = 0; i < input.GetNumberOfPoints(); ++i)
  {
    mesh.points.push_back(Point(input, i));
  }
  for (vtkIdType c = 0; c < input.GetNumberOfCells(); ++c)
  {
    const Ids ids = CellPoints(input, c);
    mesh.triangles.push_back({ VertexId(ids[0]), VertexId(ids[1]), VertexId(ids[2]) });
  }
  return mesh;
}

void ExpectLevel(vtkPolyData& output, const ClusterLevel& level)
{
  ASSERT_EQ(output.GetNumberOfPoints(), vtkIdType(level.positions.size()));
  ASSERT_EQ(output.GetNumberOfCells(), vtkIdType(level.triangles.size()));
  vtkDataArray* const geometricErrors = output.GetPointData()->GetArray("Deviation");
  ASSERT_TRUE(geometricErrors);
  for (std::size_t i = 0; i < level.positions.size(); ++i)
  {
    EXPECT_EQ(Point(output, vtkIdType(i)), level.positions[i]);
    EXPECT_EQ(geometricErrors->GetTuple1(vtkIdType(i)), level.geometricErrors[i]);
  }
  for (std::size_t t = 0; t < level.triangles.size(); ++t)
  {
    const Triangle& expected = level.triangles[t];
    EXPECT_EQ(CellPoints(output, vtkIdType(t)), (Ids{ expected[0], expected[1], expected[2] }));
  }
}

// Adds a point array of cluster ids.
void AddClusters(vtkPolyData& mesh, const char* name, const std::vector<double>& ids)
{
  vtkNew<vtkDoubleArray> array;
  array->SetName(name);
  for (const double id : ids)
  {
    array->InsertNextValue(id);
  }
  mesh.GetPointData()->AddArray(array);
}

void UseClusters(vtkKdClusterSimplification& filter, const char* name)
{
  filter.SetInputArrayToProcess(0, 0, 0, vtkDataObject::FIELD_ASSOCIATION_POINTS, name);
}

TEST(KdClusterSimplificationMakers, CollapseIsCores)
{
  const PolyData input = MakeSphere(60, VTK_DOUBLE);
  const Mesh mesh = MeshOf(*input);
  const Filter filter = MakeFilter(input, vtkKdClusterSimplification::Collapse);
  filter->WeldOff();
  SimplificationOptions options;
  options.levels.maker = LevelMaker::Collapse;
  for (const unsigned depth : { 0U, 4U, 8U, 11U })
  {
    SCOPED_TRACE(depth);
    options.depth = depth;
    filter->SetDepth(static_cast<int>(depth));
    filter->Update();
    ExpectLevel(*filter->GetOutput(), SimplifyMesh(mesh, options, {})->level);
  }
}

TEST(KdClusterSimplificationMakers, CollapseMeetsATarget)
{
  const Filter filter =
    MakeFilter(MakeSphere(60, VTK_DOUBLE), vtkKdClusterSimplification::Collapse);
  for (const vtkIdType target : { 3001, 1000, 999, 250, 60, 4 })
  {
    SCOPED_TRACE(target);
    filter->SetTargetNumberOfTriangles(target);
    filter->Update();
    const vtkIdType triangles = filter->GetOutput()->GetNumberOfPolys();
    EXPECT_LE(triangles, target);
    EXPECT_GE(triangles, target > 60 ? target - 3 : 0);
  }
  filter->SetTargetNumberOfTriangles(1000000);
  filter->SetDepth(2); // must have no effect
  filter->Update();
  const std::string all = Describe(*filter->GetOutput());
  filter->SetTargetNumberOfTriangles(0);
  filter->SetDepth(-1);
  filter->Update();
  EXPECT_EQ(Describe(*filter->GetOutput()), all) << "the finest level";
}

TEST(KdClusterSimplificationMakers, ClustersGiveTheLevelNearestToATarget)
{
  const PolyData input = MakeSphere(40);
  const Filter byDepth = MakeFilter(input, vtkKdClusterSimplification::Cluster);
  std::vector<vtkIdType> triangles;
  std::vector<std::string> levels;
  byDepth->Update();
  for (int depth = 0; depth <= byDepth->GetFinestDepth(); ++depth)
  {
    byDepth->SetDepth(depth);
    byDepth->Update();
    triangles.push_back(byDepth->GetOutput()->GetNumberOfPolys());
    levels.push_back(Describe(*byDepth->GetOutput()));
  }
  const Filter filter = MakeFilter(input, vtkKdClusterSimplification::Cluster);
  for (std::size_t d = 4; d + 1 < levels.size(); ++d)
  {
    SCOPED_TRACE(d);
    const vtkIdType middle = (triangles[d] + triangles[d + 1]) / 2;
    filter->SetTargetNumberOfTriangles(middle - 1);
    filter->Update();
    EXPECT_EQ(Describe(*filter->GetOutput()), levels[d]);
    filter->SetTargetNumberOfTriangles(middle + 2);
    filter->Update();
    EXPECT_EQ(Describe(*filter->GetOutput()), levels[d + 1]);
  }
}

TEST(KdClusterSimplificationMakers, PointSetsHaveTargetsOfPoints)
{
  const PolyData input = PolyData::New();
  input->SetPoints(MakePlate(32)->GetPoints());
  for (const int maker :
    { vtkKdClusterSimplification::Cluster, vtkKdClusterSimplification::Collapse })
  {
    const Filter filter = MakeFilter(input, maker);
    filter->SetTargetNumberOfTriangles(33);
    filter->Update();
    EXPECT_EQ(filter->GetOutput()->GetNumberOfPoints(), 32);
    EXPECT_EQ(filter->GetOutput()->GetNumberOfVerts(), 32);
  }
}

TEST(KdClusterSimplificationMakers, AnyClustersFromAnArray)
{
  const PolyData input = MakeSphere(40, VTK_DOUBLE);
  const Mesh mesh = MeshOf(*input);
  std::mt19937 random(4);
  std::vector<double> ids(mesh.points.size());
  std::vector<std::int64_t> labels;
  for (double& id : ids)
  {
    id = double(random() % 100) * 1e6 - 5e7;
    labels.push_back(static_cast<std::int64_t>(id));
  }
  AddClusters(*input, "Mine", ids);
  const Filter filter = MakeFilter(input, vtkKdClusterSimplification::Collapse);
  UseClusters(*filter, "Mine");
  filter->WeldOff();
  filter->SetDepth(1); // neither has an effect
  filter->SetTargetNumberOfTriangles(17);
  for (const bool byComponents : { true, false })
  {
    SCOPED_TRACE(byComponents);
    filter->SetSheets(byComponents);
    filter->Update();
    ClusterOptions options;
    options.byComponents = byComponents;
    ExpectLevel(
      *filter->GetOutput(), *SimplifyByClusters(mesh, ClusteringOfLabels(labels), options));
    EXPECT_EQ(filter->GetFinestDepth(), -1);
  }
  EXPECT_EQ(filter->GetOutput()->GetNumberOfPoints(), 100);
  UseClusters(*filter, ""); // no longer by the array
  filter->Update();
  EXPECT_GT(filter->GetFinestDepth(), 1);
  EXPECT_LE(filter->GetOutput()->GetNumberOfPolys(), 17);
}

TEST(KdClusterSimplificationMakers, PointsOfDifferentClustersAreNotWelded)
{
  const PolyData input = MakePoints({ { 0, 0, 0 }, { 0, 0, 0 }, { 0, 0, 0 }, { 9, 0, 0 } });
  AddClusters(*input, "Mine", { 5, 7, 5, 5 });
  const Filter filter = MakeFilter(input, vtkKdClusterSimplification::Cluster);
  UseClusters(*filter, "Mine");
  filter->Update();
  ASSERT_EQ(filter->GetOutput()->GetNumberOfPoints(), 2);
  EXPECT_EQ(Point(*filter->GetOutput(), 0), (Vec3{ 4.5, 0, 0 })) << "one of the two, and the last";
  EXPECT_EQ(Point(*filter->GetOutput(), 1), (Vec3{ 0, 0, 0 }));
}

// Ids beyond 2^53, where doubles are no longer exact.
TEST(KdClusterSimplificationMakers, LargeClusterIdsAreExact)
{
  const PolyData input = MakePoints({ { 0, 0, 0 }, { 1, 0, 0 }, { 5, 0, 0 } });
  vtkNew<vtkIdTypeArray> ids;
  ids->SetName("Mine");
  for (const vtkIdType id : { 0, 0, 1 })
  {
    ids->InsertNextValue((vtkIdType{ 1 } << 60) + id);
  }
  input->GetPointData()->AddArray(ids);
  const Filter filter = MakeFilter(input, vtkKdClusterSimplification::Cluster);
  UseClusters(*filter, "Mine");
  filter->Update();
  ASSERT_EQ(filter->GetOutput()->GetNumberOfPoints(), 2);
  EXPECT_EQ(Point(*filter->GetOutput(), 0), (Vec3{ 0.5, 0, 0 }));
}

TEST(KdClusterSimplificationMakers, ArraysThatAreNotClusters)
{
  const PolyData input = MakePoints({ { 0, 0, 0 }, { 1, 0, 0 } });
  AddClusters(*input, "Half", { 1, 1.5 });
  AddClusters(*input, "NotANumber", { std::nan(""), 0 });
  AddClusters(*input, "Short", { 1 });
  vtkNew<vtkFloatArray> vectors;
  vectors->SetName("Vectors");
  vectors->SetNumberOfComponents(3);
  vectors->SetNumberOfTuples(2);
  vectors->Fill(0);
  input->GetPointData()->AddArray(vectors);
  const std::pair<const char*, const char*> cases[] = {
    { "Half", "array \"Half\": value 1.500000 of point 1 is not a whole number" },
    { "NotANumber", "array \"NotANumber\": value nan of point 0 is not a whole number" },
    { "Short",
      "the input does not have this point array of cluster ids" }, // left out, with a warning
    { "Vectors", "the array \"Vectors\" has " },
    { "Nothing", "the input does not have this point array of cluster ids" },
  };
  for (const auto& [name, message] : cases)
  {
    const Filter filter = MakeFilter(input, vtkKdClusterSimplification::Cluster);
    UseClusters(*filter, name);
    FilterObserver observer(filter);
    filter->Update();
    EXPECT_NE(observer.error.find(message), std::string::npos) << observer.error;
    EXPECT_TRUE(observer.failed);
    EXPECT_EQ(filter->GetOutput()->GetNumberOfPoints(), 0);
  }
}

// Normals pointing up, the given colours, and an array that levels do not carry.
PolyData MakeColored(int side)
{
  PolyData input = MakePlate(side);
  vtkNew<vtkFloatArray> normals;
  normals->SetName("N");
  normals->SetNumberOfComponents(3);
  vtkNew<vtkUnsignedCharArray> colors;
  colors->SetName("Paint");
  colors->SetNumberOfComponents(3);
  for (vtkIdType i = 0; i < input->GetNumberOfPoints(); ++i)
  {
    normals->InsertNextTuple3(0, 0, i % 2 == 0 ? 1 : 3);
    colors->InsertNextTuple3(i % 2 == 0 ? 100 : 101, 7, 255);
  }
  input->GetPointData()->SetNormals(normals);
  input->GetPointData()->SetScalars(colors);
  return input;
}

TEST(KdClusterSimplificationMakers, NormalsAndColorsAreAveraged)
{
  const PolyData input = MakeColored(16);
  AddClusters(*input, "One", std::vector<double>(256, 3));
  for (const bool byArray : { false, true })
  {
    SCOPED_TRACE(byArray);
    const Filter filter = MakeFilter(input, vtkKdClusterSimplification::Collapse);
    filter->SetDepth(0);
    if (byArray)
    {
      UseClusters(*filter, "One");
    }
    filter->Update();
    vtkPointData* const data = filter->GetOutput()->GetPointData();
    ASSERT_EQ(filter->GetOutput()->GetNumberOfPoints(), 1);
    EXPECT_EQ(data->GetNumberOfArrays(), 5) << "Deviation, Point and One, too";
    ASSERT_TRUE(data->GetNormals());
    EXPECT_STREQ(data->GetNormals()->GetName(), "Normals");
    EXPECT_EQ(data->GetNormals()->GetComponent(0, 2), 1);
    ASSERT_TRUE(data->GetScalars());
    EXPECT_STREQ(data->GetScalars()->GetName(), "RGB");
    const double red = data->GetScalars()->GetComponent(0, 0);
    if (byArray)
    {
      EXPECT_EQ(red, 101) << "100.5, rounded up";
    }
    EXPECT_TRUE(red == 100 || red == 101) << red; // after a collapse, the colour at the new place
    EXPECT_EQ(data->GetScalars()->GetComponent(0, 1), 7);
    EXPECT_EQ(data->GetScalars()->GetComponent(0, 2), 255);
  }
}

TEST(KdClusterSimplificationMakers, SameOnEveryBackendAndNumberOfThreads)
{
  std::string first;
  for (const std::string& backend : smpBackends)
  {
    for (const int threads : { 8, 2, 1 })
    {
      if (!UseSmpBackend(backend, threads))
      {
        continue;
      }
      const Filter filter = MakeFilter(MakeSphere(100), vtkKdClusterSimplification::Collapse);
      filter->SetVerticesPerPartition(200);
      filter->SetDepth(8);
      filter->Update();
      std::string output = Describe(*filter->GetOutput());
      filter->SetTargetNumberOfTriangles(1500);
      filter->Update();
      output += Describe(*filter->GetOutput());
      first = first.empty() ? output : first;
      EXPECT_TRUE(output == first) << backend << ", " << threads << " threads";
    }
  }
  EXPECT_GT(first.size(), 10000U);
}

TEST(KdClusterSimplificationMakers, AbortLeavesAnEmptyOutput)
{
  const Filter filter = MakeFilter(MakeSphere(70), vtkKdClusterSimplification::Collapse);
  filter->SetDepth(0);
  FilterObserver observer(filter);
  filter->Update();
  EXPECT_TRUE(std::is_sorted(observer.progress.begin(), observer.progress.end()));
  for (const double at : { 0.0, 0.2, 0.6, 0.95 })
  {
    SCOPED_TRACE(at);
    observer.abortAt = at;
    filter->Modified();
    filter->Update();
    EXPECT_EQ(observer.error, "");
    EXPECT_EQ(filter->GetOutput()->GetNumberOfPoints(), 0);
    observer.StopAborting();
    filter->Update();
    EXPECT_GT(filter->GetOutput()->GetNumberOfPoints(), 0);
  }
}

TEST(KdClusterSimplificationMakers, RunsAgainOnlyWhenSomethingChanged)
{
  const PolyData input = MakeSphere(20);
  AddClusters(*input, "Mine", std::vector<double>(400, 3));
  const Filter filter = MakeFilter(input, vtkKdClusterSimplification::Cluster);
  FilterObserver observer(filter);
  filter->Update();
  filter->SetMakerToCluster();
  filter->SetTargetNumberOfTriangles(0);
  filter->Update();
  EXPECT_EQ(observer.runs, 1);
  filter->SetMakerToCollapse();
  filter->Update();
  EXPECT_EQ(observer.runs, 2);
  filter->SetTargetNumberOfTriangles(50);
  filter->Update();
  EXPECT_EQ(observer.runs, 3);
  UseClusters(*filter, "Mine");
  filter->Update();
  EXPECT_EQ(observer.runs, 4);
  EXPECT_EQ(filter->GetOutput()->GetNumberOfPoints(), 1);
  filter->Update();
  EXPECT_EQ(observer.runs, 4);
}

TEST(KdClusterSimplificationMakers, OptionsAreClampedAndPrinted)
{
  vtkNew<vtkKdClusterSimplification> filter;
  EXPECT_EQ(filter->GetMaker(), vtkKdClusterSimplification::Collapse);
  EXPECT_STREQ(filter->GetMakerAsString(), "Collapse");
  EXPECT_STREQ(filter->GetRepresentativeAsString(), "Quadric");
  EXPECT_EQ(filter->GetTargetNumberOfTriangles(), 0);
  filter->SetMaker(9);
  EXPECT_EQ(filter->GetMaker(), vtkKdClusterSimplification::Cluster);
  filter->SetTargetNumberOfTriangles(77);
  FilterObserver observer(filter);
  filter->SetTargetNumberOfTriangles(-4);
  EXPECT_NE(observer.error.find("TargetNumberOfTriangles must be from 0 to "), std::string::npos)
    << observer.error;
  std::ostringstream text;
  filter->Print(text);
  for (const char* line : { "Maker: Cluster\n", "TargetNumberOfTriangles: 77\n" })
  {
    EXPECT_NE(text.str().find(line), std::string::npos) << line;
  }
}

TEST(KdClusterSimplificationMakers, ArraysComeAlong)
{
  const PolyData input = MakeSphere(80); // radius 1
  input->GetPointData()->Initialize();
  input->GetCellData()->Initialize();
  AddArrays(*input);
  vtkNew<vtkIdTypeArray> ids;
  ids->SetName("node");
  ids->SetNumberOfValues(input->GetNumberOfPoints());
  ids->FillValue(5);
  input->GetPointData()->SetGlobalIds(ids);
  for (const int maker :
    { vtkKdClusterSimplification::Cluster, vtkKdClusterSimplification::Collapse })
  {
    for (const int depth : { -1, 8 })
    {
      SCOPED_TRACE(std::to_string(maker) + " " + std::to_string(depth));
      const Filter filter = MakeFilter(input, maker);
      filter->SetDepth(depth);
      filter->Update();
      vtkPolyData* const output = filter->GetOutput();
      const double size = depth == 8 ? 0.35 : 0.15; // about the size of a cluster
      for (vtkDataSetAttributes* data :
        std::array<vtkDataSetAttributes*, 2>{ output->GetPointData(), output->GetCellData() })
      {
        const bool ofPoints = data == output->GetPointData();
        ASSERT_EQ(data->GetNumberOfArrays(), ofPoints ? 4 : 3);
        vtkDataArray* const places = data->GetArray("Place");
        vtkDataArray* const halves = data->GetArray("Half");
        ASSERT_TRUE(places && halves);
        EXPECT_EQ(places->GetDataType(), VTK_DOUBLE);
        ASSERT_TRUE(data->GetScalars());
        EXPECT_STREQ(data->GetScalars()->GetName(), "Heat");
        EXPECT_EQ(data->GetScalars()->GetRange()[0], 36.5f);
        EXPECT_EQ(data->GetScalars()->GetRange()[1], 36.5f);
        EXPECT_EQ(data->GetGlobalIds(), nullptr);
        for (vtkIdType i = 0; i < places->GetNumberOfTuples(); ++i)
        {
          std::array<double, 3> here{};
          const Ids corners = ofPoints ? Ids{ i } : CellPoints(*output, i);
          for (const vtkIdType corner : corners)
          {
            for (std::size_t k = 0; k < 3; ++k)
            {
              here[k] += Point(*output, corner)[k] / double(corners.size());
            }
          }
          EXPECT_LT(Distance(here, places->GetTuple3(i)), size) << ofPoints << " " << i;
          if (std::abs(here[0]) > size)
          {
            EXPECT_EQ(halves->GetComponent(i, 0), here[0] > 0 ? 200 : 10) << ofPoints << " " << i;
          }
        }
      }
    }
  }
}

// Arrays that identify points and cells have no meaningful means, whatever the type of their
// numbers.
TEST(KdClusterSimplificationMakers, IdsAreLeftOutWhateverTheirType)
{
  for (const int type : { VTK_ID_TYPE, VTK_DOUBLE, VTK_FLOAT })
  {
    const PolyData input = MakeSphere(40);
    const auto idsOf = [&](const char* name, vtkIdType count)
    {
      const auto ids = vtkSmartPointer<vtkDataArray>::Take(vtkDataArray::CreateDataArray(type));
      ids->SetName(name);
      ids->SetNumberOfTuples(count);
      for (vtkIdType i = 0; i < count; ++i)
      {
        ids->SetComponent(i, 0, double(i));
      }
      return ids;
    };
    for (vtkDataSetAttributes* data :
      std::array<vtkDataSetAttributes*, 2>{ input->GetPointData(), input->GetCellData() })
    {
      const vtkIdType count = data->GetArray(0)->GetNumberOfTuples();
      data->SetGlobalIds(idsOf("node", count));
      data->SetPedigreeIds(idsOf("origin", count));
      ASSERT_TRUE(data->GetGlobalIds() && data->GetPedigreeIds());
    }
    const Filter filter = MakeFilter(input, vtkKdClusterSimplification::Collapse);
    filter->Update();
    vtkPolyData* const output = filter->GetOutput();
    ASSERT_GT(output->GetNumberOfCells(), 0);
    for (vtkDataSetAttributes* data :
      std::array<vtkDataSetAttributes*, 2>{ output->GetPointData(), output->GetCellData() })
    {
      EXPECT_FALSE(data->GetGlobalIds() || data->GetPedigreeIds()) << type;
      EXPECT_FALSE(data->HasArray("node") || data->HasArray("origin")) << type;
    }
  }
}

// The levels of a store depend only on points that triangles use.
TEST(KdClusterSimplificationMakers, PointsThatNoTriangleUsesDecideNothing)
{
  for (const int maker :
    { vtkKdClusterSimplification::Cluster, vtkKdClusterSimplification::Collapse })
  {
    const PolyData plain = MakeSphere(40), strewn = MakeSphere(40);
    plain->GetPointData()->Initialize();
    strewn->GetPointData()->Initialize();
    vtkNew<vtkPoints> points; // every second one is used
    for (vtkIdType i = 0; i < plain->GetNumberOfPoints(); ++i)
    {
      points->InsertNextPoint(plain->GetPoint(i));
      points->InsertNextPoint(20, double(i), -double(i * i));
    }
    vtkNew<vtkCellArray> cells;
    for (vtkIdType c = 0; c < plain->GetNumberOfCells(); ++c)
    {
      Ids corners = CellPoints(*plain, c);
      for (vtkIdType& corner : corners)
      {
        corner *= 2;
      }
      AddCell(cells, corners);
    }
    strewn->SetPoints(points);
    strewn->SetPolys(cells);
    std::vector<double> values, strewnValues;
    for (vtkIdType i = 0; i < plain->GetNumberOfPoints(); ++i)
    {
      values.push_back(double(i % 7));
      strewnValues.insert(strewnValues.end(), { double(i % 7), 1e9 });
    }
    AddClusters(*plain, "value", values);
    AddClusters(*strewn, "value", strewnValues);
    for (const int depth : { -1, 6 })
    {
      std::string described;
      for (const PolyData& input : { plain, strewn })
      {
        const Filter filter = MakeFilter(input, maker);
        filter->SetDepth(depth);
        filter->Update();
        const std::string output = Describe(*filter->GetOutput());
        EXPECT_TRUE(described.empty() || described == output) << maker << " " << depth;
        described = output;
      }
    }
  }
}

// If nothing is simplified, arrays must be unchanged, bit by bit.
TEST(KdClusterSimplificationMakers, ArraysOfAMeshThatIsNotSimplifiedAreTheSame)
{
  const PolyData input = MakePlate(9);
  const Filter filter = MakeFilter(input, vtkKdClusterSimplification::Cluster);
  filter->SetCellVertices(1);
  filter->Update();
  vtkPolyData* const output = filter->GetOutput();
  ASSERT_EQ(output->GetNumberOfPoints(), input->GetNumberOfPoints());
  ASSERT_EQ(output->GetNumberOfCells(), input->GetNumberOfCells());
  for (vtkIdType i = 0; i < output->GetNumberOfPoints(); ++i)
  {
    const auto was = vtkIdType(output->GetPointData()->GetArray("Point")->GetComponent(i, 0));
    EXPECT_EQ(Point(*output, i), Point(*input, was));
  }
  for (vtkIdType c = 0; c < output->GetNumberOfCells(); ++c)
  {
    const auto was = vtkIdType(output->GetCellData()->GetArray("Cell")->GetComponent(c, 0));
    std::set<std::array<double, 3>> here, there;
    for (std::size_t k = 0; k < 3; ++k)
    {
      here.insert(Point(*output, CellPoints(*output, c)[k]));
      there.insert(Point(*input, CellPoints(*input, was)[k]));
    }
    EXPECT_EQ(here, there) << c;
  }
}

// Points that are welded must all count.
TEST(KdClusterSimplificationMakers, ArraysOfClustersAreMeansOverAllTheirPoints)
{
  const PolyData input = MakePoints({ { 0, 0, 0 }, { 0, 0, 0 }, { 1, 0, 0 }, { 2, 0, 0 } });
  AddClusters(*input, "of", { 4, 4, 4, 9 });
  AddClusters(*input, "value", { 1, 2, 9, -5 });
  const Filter filter = MakeFilter(input, vtkKdClusterSimplification::Cluster);
  UseClusters(*filter, "of");
  filter->Update();
  vtkDataArray* const values = filter->GetOutput()->GetPointData()->GetArray("value");
  ASSERT_TRUE(values);
  ASSERT_EQ(values->GetNumberOfTuples(), 2);
  EXPECT_EQ(values->GetComponent(0, 0), 4);
  EXPECT_EQ(values->GetComponent(1, 0), -5);
}

}
