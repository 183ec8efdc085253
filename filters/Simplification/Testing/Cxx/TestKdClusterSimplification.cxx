// SPDX-License-Identifier: BSD-3-Clause
// vtkKdClusterSimplification: comparison with the levels of core, threads, progress, abort, errors,
// re-execution.
#include "filters/adapter/Testing/FilterTools.h"
#include "filters/adapter/Testing/SmpBackend.h"
#include "filters/core/Weld.h"
#include "filters/core/levels/ClusterLevels.h"

#include <gtest/gtest.h>
#include <vtkKdClusterSimplification.h>

#include <algorithm>
#include <limits>
#include <set>

namespace
{

using namespace kdstream;
using namespace kdstream::testing;

struct Options
{
  Representative representative = Representative::Quadric;
  bool byComponents = true;
  bool weld = true;
  int cellVertices = 8;
  vtkIdType verticesPerPartition = 2000;
};

vtkSmartPointer<vtkKdClusterSimplification> MakeFilter(
  const PolyData& input, const Options& options)
{
  auto filter = vtkSmartPointer<vtkKdClusterSimplification>::New();
  filter->SetInputData(input);
  filter->SetMakerToCluster();
  filter->SetRepresentative(options.representative == Representative::Mean
                              ? vtkKdClusterSimplification::Mean
                              : vtkKdClusterSimplification::Quadric);
  filter->SetSheets(options.byComponents);
  filter->SetWeld(options.weld);
  filter->SetCellVertices(options.cellVertices);
  filter->SetVerticesPerPartition(options.verticesPerPartition);
  return filter;
}

// The levels that core makes of a triangle mesh, down to depth 0.
ClusterLevels LevelsByCore(vtkPolyData& input, const Options& options)
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
  if (options.weld)
  {
    WeldVertices(mesh);
  }
  KdTreeOptions tree;
  tree.cellVertices = static_cast<std::uint32_t>(options.cellVertices);
  tree.verticesPerPartition = static_cast<std::uint32_t>(options.verticesPerPartition);
  const Result<KdTree> built = BuildKdTree(mesh.points, tree);
  EXPECT_TRUE(built);
  const std::vector<std::uint32_t> cells = CellOfVertex(*built, built->depths.partition);
  const TriangleBuckets buckets = BucketTriangles(mesh.triangles,
    std::size_t{ 1 } << built->depths.partition, [&](VertexId v) { return cells[v]; });
  ClusterOptions cluster;
  cluster.representative = options.representative;
  cluster.byComponents = options.byComponents;
  Result<ClusterLevels> levels =
    BuildClusterLevels(mesh.points, mesh.triangles, *built, buckets, cluster);
  EXPECT_TRUE(levels);
  return std::move(*levels);
}

void ExpectLevel(vtkPolyData& output, const ClusterLevel& level, bool floats)
{
  ASSERT_EQ(output.GetNumberOfPoints(), vtkIdType(level.positions.size()));
  ASSERT_EQ(output.GetNumberOfCells(), vtkIdType(level.triangles.size()));
  EXPECT_EQ(output.GetPoints()->GetDataType(), floats ? VTK_FLOAT : VTK_DOUBLE);
  vtkDataArray* const geometricErrors = output.GetPointData()->GetArray("Deviation");
  ASSERT_TRUE(geometricErrors);
  for (std::size_t i = 0; i < level.positions.size(); ++i)
  {
    Vec3 expected = level.positions[i];
    for (double& x : expected)
    {
      x = floats ? double(float(x)) : x;
    }
    EXPECT_EQ(Point(output, vtkIdType(i)), expected);
    EXPECT_EQ(geometricErrors->GetTuple1(vtkIdType(i)), level.geometricErrors[i]);
  }
  for (std::size_t t = 0; t < level.triangles.size(); ++t)
  {
    const Triangle& expected = level.triangles[t];
    EXPECT_EQ(CellPoints(output, vtkIdType(t)), (Ids{ expected[0], expected[1], expected[2] }));
  }
}

TEST(KdClusterSimplification, EveryLevelIsCores)
{
  const std::vector<std::pair<PolyData, bool>> inputs{ { MakeSphere(60), true },
    { MakeSphere(30, VTK_DOUBLE), false }, { MakePlate(40), true },
    { MakeRepeatedPoint(20), true } };
  for (const auto& [input, floats] : inputs)
  {
    for (const Options& options :
      { Options{}, Options{ Representative::Mean, false, true, 8, 2000 },
        Options{ Representative::Quadric, true, false, 3, 2000 },
        Options{ Representative::Mean, true, true, 50, 20 } })
    {
      const ClusterLevels expected = LevelsByCore(*input, options);
      const auto filter = MakeFilter(input, options);
      for (int depth = 0; depth < int(expected.levels.size()); ++depth)
      {
        SCOPED_TRACE(depth);
        filter->SetDepth(depth);
        filter->Update();
        EXPECT_EQ(filter->GetFinestDepth(), int(expected.levels.size()) - 1);
        ExpectLevel(*filter->GetOutput(), expected.levels[std::size_t(depth)], floats);
      }
      filter->SetDepth(-1);
      filter->Update();
      ExpectLevel(*filter->GetOutput(), expected.levels.back(), floats);
    }
  }
}

TEST(KdClusterSimplification, OptionsChangeTheResult)
{
  const PolyData input = MakeSphere(60);
  std::set<std::string> results;
  const Options cases[] = { {}, { Representative::Mean }, { Representative::Quadric, false },
    { Representative::Quadric, true, false } };
  for (const Options& options : cases)
  {
    const auto filter = MakeFilter(input, options);
    filter->SetDepth(5);
    filter->Update();
    results.insert(Describe(*filter->GetOutput()));
  }
  EXPECT_EQ(results.size(), 4U);
  const auto uniform = MakeFilter(input, { Representative::Mean, false });
  uniform->SetDepth(7);
  uniform->Update();
  EXPECT_EQ(uniform->GetOutput()->GetNumberOfPoints(), 128);
}

TEST(KdClusterSimplification, SameOnEveryBackendAndNumberOfThreads)
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
      const auto filter =
        MakeFilter(MakeSphere(120), { Representative::Quadric, true, true, 8, 100 });
      filter->SetDepth(9);
      filter->Update();
      const std::string output = Describe(*filter->GetOutput());
      first = first.empty() ? output : first;
      EXPECT_TRUE(output == first) << backend << ", " << threads << " threads";
    }
  }
  EXPECT_GT(first.size(), 10000U);
}

TEST(KdClusterSimplification, OtherCells)
{
  const auto filter = MakeFilter(MakeAllCells(), { Representative::Mean, false });
  filter->SetCellVertices(1); // the 18 points that triangles use stay
  filter->Update();
  vtkPolyData* const output = filter->GetOutput();
  EXPECT_EQ(output->GetNumberOfPoints(), 18);
  EXPECT_EQ(output->GetNumberOfPolys(), 10) << "the triangles of polygons and strips";
  EXPECT_EQ(output->GetNumberOfCells(), 10) << "and nothing else";
  EXPECT_EQ(output->GetPointData()->GetNumberOfArrays(), 2) << "Deviation, and the input's";
  vtkDataArray* const cells = output->GetCellData()->GetArray("Cell");
  ASSERT_TRUE(cells);
  std::multiset<double> from;
  for (vtkIdType c = 0; c < 10; ++c)
  {
    from.insert(cells->GetComponent(c, 0));
  }
  EXPECT_EQ(from, (std::multiset<double>{ 4, 5, 5, 6, 6, 6, 8, 8, 8, 8 }));
}

TEST(KdClusterSimplification, PointSetsHaveAVertexForEveryPoint)
{
  const PolyData plate = MakePlate(32);
  const PolyData input = PolyData::New();
  input->SetPoints(plate->GetPoints());
  const auto filter = MakeFilter(input, {});
  filter->SetDepth(4);
  filter->Update();
  EXPECT_EQ(filter->GetOutput()->GetNumberOfPoints(), 16);
  EXPECT_EQ(filter->GetOutput()->GetNumberOfVerts(), 16);
  filter->SetInputData(MakePoints({ { 1, 2, 3 } }));
  filter->SetDepth(0);
  filter->Update();
  ASSERT_EQ(filter->GetOutput()->GetNumberOfPoints(), 1);
  EXPECT_EQ(Point(*filter->GetOutput(), 0), (Vec3{ 1, 2, 3 }));
}

TEST(KdClusterSimplification, EmptyInputs)
{
  const PolyData noPoints = PolyData::New(); // a null vtkPoints
  for (const PolyData& input : { noPoints, MakePoints({}) })
  {
    const auto filter = MakeFilter(input, {});
    FilterObserver observer(filter);
    filter->Update();
    EXPECT_EQ(observer.error, "");
    EXPECT_EQ(filter->GetOutput()->GetNumberOfPoints(), 0);
  }
}

TEST(KdClusterSimplification, ErrorsNameWhatIsWrongAndLeaveAnEmptyOutput)
{
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const PolyData outside = MakePlate(3);
  AddCell(outside->GetPolys(), { 0, 1, 9 });
  const PolyData offsets = MakePlate(3);
  offsets->SetPolys(MakeCells({ 0, 1000000 }, { 0, 1, 2 }));
  const struct
  {
    PolyData input;
    int depth;
    const char* message;
  } cases[] = {
    { MakePoints({ { 0, 0, 0 }, { 0, nan, 0 } }), 0, "point 1: a coordinate is not finite" },
    { outside, 0, "cell 8 uses point 9, but there are 9" },
    { offsets, 0, "cell 0 uses corners 0 to 1000000 of a list of 3" },
    { MakePlate(3), 4, "Depth 4 is below the finest level of this input, at depth 3" },
    { MakePoints({ { -1e308, 0, 0 }, { 1e308, 0, 0 } }), 0,
      "the mesh spans more than 2^127 (1.7e38) along x, the limit for computing levels" },
  };
  for (const auto& c : cases)
  {
    SCOPED_TRACE(c.message);
    const auto filter = MakeFilter(MakePlate(3), {});
    filter->Update();
    ASSERT_GT(filter->GetOutput()->GetNumberOfPoints(), 0);
    FilterObserver observer(filter);
    filter->SetInputData(c.input);
    filter->SetDepth(c.depth);
    filter->Update();
    EXPECT_NE(observer.error.find(c.message), std::string::npos) << observer.error;
    EXPECT_TRUE(observer.failed) << "the pipeline was not told";
    EXPECT_EQ(filter->GetOutput()->GetNumberOfPoints(), 0);
  }
}

TEST(KdClusterSimplification, ProgressRisesAndAbortLeavesAnEmptyOutput)
{
  const auto filter = MakeFilter(MakeSphere(70), {});
  filter->SetDepth(0);
  FilterObserver observer(filter);
  filter->Update();
  EXPECT_TRUE(std::is_sorted(observer.progress.begin(), observer.progress.end()));
  EXPECT_GT(observer.progress.size(), 8U);
  EXPECT_EQ(observer.progress.back(), 1.0);
  for (const double at : { 0.0, 0.2, 0.35, 0.6, 0.95 })
  {
    SCOPED_TRACE(at);
    observer.abortAt = at;
    filter->Modified();
    filter->Update();
    EXPECT_EQ(observer.error, "");
    EXPECT_FALSE(observer.failed);
    EXPECT_EQ(filter->GetOutput()->GetNumberOfPoints(), 0);
    observer.StopAborting();
    filter->Update();
    EXPECT_GT(filter->GetOutput()->GetNumberOfPoints(), 0);
  }
}

TEST(KdClusterSimplification, RunsAgainOnlyWhenSomethingChanged)
{
  const auto filter = MakeFilter(MakeSphere(20), {});
  FilterObserver observer(filter);
  filter->Update();
  filter->Update();
  filter->SetDepth(-1);
  filter->SetRepresentativeToQuadric();
  filter->SheetsOn();
  filter->WeldOn();
  filter->Update();
  EXPECT_EQ(observer.runs, 1);
  int runs = 1;
  const auto expectRun = [&](const char* what)
  {
    filter->Update();
    EXPECT_EQ(observer.runs, ++runs) << what;
  };
  filter->SetDepth(3);
  expectRun("Depth");
  filter->SetRepresentativeToMean();
  expectRun("Representative");
  filter->SheetsOff();
  expectRun("Sheets");
  filter->WeldOff();
  expectRun("Weld");
  filter->SetCellVertices(5);
  expectRun("CellVertices");
  filter->SetVerticesPerPartition(100);
  expectRun("VerticesPerPartition");
  filter->SetInputData(MakeSphere(21));
  expectRun("input");
}

TEST(KdClusterSimplification, OptionsAreClampedAndPrinted)
{
  vtkNew<vtkKdClusterSimplification> filter;
  EXPECT_EQ(filter->GetDepth(), -1);
  EXPECT_EQ(filter->GetRepresentative(), vtkKdClusterSimplification::Quadric);
  EXPECT_TRUE(filter->GetSheets());
  EXPECT_TRUE(filter->GetWeld());
  EXPECT_EQ(filter->GetCellVertices(), 8);
  EXPECT_EQ(filter->GetVerticesPerPartition(), 2000);
  EXPECT_EQ(filter->GetFinestDepth(), -1);
  filter->SetDepth(31);
  filter->SetRepresentative(7);
  filter->SetCellVertices(0);
  filter->SetVerticesPerPartition(0);
  {
    FilterObserver heard(filter);
    filter->SetDepth(-2);
    EXPECT_NE(
      heard.error.find("Depth must be from -1 to 30, not -2: it stays 30"), std::string::npos);
  }
  EXPECT_EQ(filter->GetDepth(), 30);
  EXPECT_EQ(filter->GetRepresentative(), vtkKdClusterSimplification::Mean);
  EXPECT_EQ(filter->GetCellVertices(), 1);
  EXPECT_EQ(filter->GetVerticesPerPartition(), 1);
  filter->SheetsOff();
  std::ostringstream text;
  filter->Print(text);
  for (const char* line : { "Depth: 30\n", "Representative: Mean\n", "Sheets: off\n", "Weld: on\n",
         "CellVertices: 1\n", "VerticesPerPartition: 1\n", "FinestDepth: -1\n" })
  {
    EXPECT_NE(text.str().find(line), std::string::npos) << line;
  }
}

}
