// SPDX-License-Identifier: BSD-3-Clause
// vtkPCLSurfaceReconstruction: surfaces of sampled spheres, difficult clouds, and its use in a
// pipeline.
#include "filters/adapter/Testing/FilterTools.h"
#include "filters/adapter/Testing/SmpBackend.h"

#include "vtkPCLSurfaceReconstruction.h"

#include <gtest/gtest.h>
#include <vtkFloatArray.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <random>
#include <set>

namespace
{

using namespace kdstream::testing;
using Place = std::array<double, 3>;

constexpr double pi = 3.14159265358979323846;

double Dot(const Place& a, const Place& b)
{
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

Place Minus(const Place& a, const Place& b)
{
  return { a[0] - b[0], a[1] - b[1], a[2] - b[2] };
}

Place Cross(const Place& u, const Place& v)
{
  return { u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0] };
}

double Length(const Place& a)
{
  return std::sqrt(Dot(a, a));
}

// Points that are spread evenly over a sphere, along a spiral.
std::vector<Place> Spiral(int count, const Place& centre = {}, double radius = 1)
{
  std::vector<Place> points;
  for (int i = 0; i < count; ++i)
  {
    const double z = 1 - 2 * (i + 0.5) / count, r = std::sqrt(1 - z * z);
    const double a = i * pi * (3 - std::sqrt(5.0));
    points.push_back({ centre[0] + radius * r * std::cos(a), centre[1] + radius * r * std::sin(a),
      centre[2] + radius * z });
  }
  return points;
}

std::vector<Place> RandomSphere(int count, unsigned seed)
{
  std::mt19937 random(seed);
  std::vector<Place> points;
  while (static_cast<int>(points.size()) < count)
  {
    const auto draw = [&]() { return (double(random()) / double(random.max())) * 2 - 1; };
    const Place p{ draw(), draw(), draw() };
    const double length = Length(p);
    if (length < 1 && length > 0.1)
    {
      points.push_back({ p[0] / length, p[1] / length, p[2] / length });
    }
  }
  return points;
}

struct EdgeCounts
{
  std::size_t all = 0, boundary = 0, crowded = 0;
};

EdgeCounts CountEdges(vtkPolyData& mesh)
{
  std::map<std::pair<vtkIdType, vtkIdType>, int> uses;
  for (vtkIdType c = 0; c < mesh.GetNumberOfCells(); ++c)
  {
    const Ids ids = CellPoints(mesh, c);
    for (std::size_t k = 0; k < 3; ++k)
    {
      ++uses[std::minmax(ids[k], ids[(k + 1) % 3])];
    }
  }
  EdgeCounts counts;
  counts.all = uses.size();
  for (const auto& use : uses)
  {
    counts.boundary += use.second == 1;
    counts.crowded += use.second > 2;
  }
  return counts;
}

// The share of triangles whose normal points away from a place.
double ShareOutward(vtkPolyData& mesh, const Place& centre)
{
  vtkIdType outward = 0;
  for (vtkIdType c = 0; c < mesh.GetNumberOfCells(); ++c)
  {
    const Ids ids = CellPoints(mesh, c);
    const Place a = Point(mesh, ids[0]);
    const Place normal = Cross(Minus(Point(mesh, ids[1]), a), Minus(Point(mesh, ids[2]), a));
    outward += Dot(normal, Minus(a, centre)) > 0;
  }
  return double(outward) / double(mesh.GetNumberOfCells());
}

// The largest distance from a sphere, over all corners and centres of triangles.
double DistanceToSphere(vtkPolyData& mesh, const Place& centre, double radius)
{
  double farthest = 0;
  for (vtkIdType c = 0; c < mesh.GetNumberOfCells(); ++c)
  {
    Place middle{};
    for (const vtkIdType id : CellPoints(mesh, c))
    {
      const Place p = Minus(Point(mesh, id), centre);
      farthest = std::max(farthest, std::abs(Length(p) - radius));
      for (std::size_t k = 0; k < 3; ++k)
      {
        middle[k] += p[k] / 3;
      }
    }
    farthest = std::max(farthest, std::abs(Length(middle) - radius));
  }
  return farthest;
}

void ExpectUnitNormals(vtkPolyData& mesh)
{
  vtkDataArray* const normals = mesh.GetPointData()->GetNormals();
  ASSERT_TRUE(normals);
  EXPECT_EQ(normals->GetName(), std::string("Normals"));
  ASSERT_EQ(normals->GetNumberOfTuples(), mesh.GetNumberOfPoints());
  std::set<vtkIdType> used;
  for (vtkIdType c = 0; c < mesh.GetNumberOfCells(); ++c)
  {
    for (const vtkIdType id : CellPoints(mesh, c))
    {
      used.insert(id);
    }
  }
  for (const vtkIdType id : used)
  {
    EXPECT_NEAR(Length({ normals->GetComponent(id, 0), normals->GetComponent(id, 1),
                  normals->GetComponent(id, 2) }),
      1, 1e-5);
  }
}

using Filter = vtkPCLSurfaceReconstruction;

PolyData Reconstruct(Filter& filter, const PolyData& input)
{
  filter.SetInputData(input);
  filter.Update();
  return filter.GetOutput();
}

TEST(PCLSurfaceReconstruction, GreedySphereKeepsThePoints)
{
  for (const int type : { VTK_FLOAT, VTK_DOUBLE })
  {
    // The centre is far from the origin: floats would be half a unit apart there.
    const Place centre = type == VTK_FLOAT ? Place{ 1, 2, 3 } : Place{ 4e6, 5e6, 100 };
    const PolyData input = MakePoints(Spiral(4000, centre, 10), type);
    AddIds(*input);
    vtkNew<Filter> filter;
    const PolyData output = Reconstruct(*filter, input);
    EXPECT_EQ(output->GetPoints()->GetDataType(), type);
    ASSERT_EQ(output->GetNumberOfPoints(), 4000);
    for (vtkIdType i = 0; i < 4000; ++i)
    {
      ASSERT_EQ(Point(*output, i), Point(*input, i));
    }
    EXPECT_TRUE(output->GetPointData()->HasArray("Point"));
    EXPECT_GT(output->GetNumberOfCells(), 7800) << "a closed one has 7996";
    const EdgeCounts edges = CountEdges(*output);
    EXPECT_LT(edges.boundary, edges.all / 200);
    EXPECT_LT(edges.crowded, edges.all / 200);
    EXPECT_EQ(ShareOutward(*output, centre), 1);
    EXPECT_LT(DistanceToSphere(*output, centre, 10), 0.05);
    ExpectUnitNormals(*output);
  }
}

TEST(PCLSurfaceReconstruction, PoissonSphereIsClosed)
{
  for (const int type : { VTK_FLOAT, VTK_DOUBLE })
  {
    const Place centre = type == VTK_FLOAT ? Place{ 1, 2, 3 } : Place{ 4e6, 5e6, 100 };
    vtkNew<Filter> filter;
    filter->SetMethodToPoisson();
    const PolyData output = Reconstruct(*filter, MakePoints(Spiral(4000, centre, 10), type));
    EXPECT_EQ(output->GetPoints()->GetDataType(), type);
    EXPECT_GT(output->GetNumberOfCells(), 1000);
    const EdgeCounts edges = CountEdges(*output);
    EXPECT_EQ(edges.boundary, 0U);
    EXPECT_EQ(edges.crowded, 0U);
    EXPECT_GT(ShareOutward(*output, centre), 0.999);
    EXPECT_LT(DistanceToSphere(*output, centre, 10), 0.05);
    ExpectUnitNormals(*output);
    vtkDataArray* const normals = output->GetPointData()->GetNormals();
    for (vtkIdType i = 0; i < output->GetNumberOfPoints(); ++i)
    {
      Place normal{};
      normals->GetTuple(i, normal.data());
      const Place way = Minus(Point(*output, i), centre);
      ASSERT_GT(Dot(normal, way) / Length(way), 0.9);
    }
  }
}

TEST(PCLSurfaceReconstruction, RandomlySampledSphere)
{
  const PolyData input = MakePoints(RandomSphere(8000, 1));
  vtkNew<Filter> filter;
  const PolyData greedy = Reconstruct(*filter, input);
  const EdgeCounts edges = CountEdges(*greedy);
  EXPECT_LT(edges.boundary, edges.all / 50);
  EXPECT_LT(DistanceToSphere(*greedy, {}, 1), 0.02);
  EXPECT_GT(ShareOutward(*greedy, {}), 0.99);
  vtkNew<Filter> poisson;
  poisson->SetMethodToPoisson();
  const PolyData closed = Reconstruct(*poisson, input);
  EXPECT_EQ(CountEdges(*closed).boundary, 0U);
  EXPECT_LT(DistanceToSphere(*closed, {}, 1), 0.02);
}

TEST(PCLSurfaceReconstruction, InputNormalsSayWhatIsOutside)
{
  const std::vector<Place> points = Spiral(2000);
  const PolyData input = MakePoints(points);
  vtkNew<vtkFloatArray> inward;
  inward->SetName("N");
  inward->SetNumberOfComponents(3);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (std::size_t i = 0; i < points.size(); ++i)
  {
    const Place& p = points[i];
    // Some points have no normal, and get the side of their neighbours.
    const float tuple[] = { i % 5 == 0 ? nan : float(-p[0]), float(-p[1]),
      i % 7 == 0 ? nan : float(-p[2]) };
    inward->InsertNextTypedTuple(tuple);
  }
  input->GetPointData()->SetNormals(inward);
  for (const int method : { Filter::GREEDY, Filter::POISSON })
  {
    vtkNew<Filter> filter;
    filter->SetMethod(method);
    EXPECT_LT(ShareOutward(*Reconstruct(*filter, input), {}), 0.001) << method;
    filter->UseInputNormalsOff();
    filter->Update();
    EXPECT_GT(ShareOutward(*filter->GetOutput(), {}), 0.999) << method;
  }
}

TEST(PCLSurfaceReconstruction, GreedyTrianglesAreTurnedAsTheirNormals)
{
  // A cube: PCL's own orientation is wrong in places at its edges.
  std::mt19937 random(8);
  std::vector<Place> points;
  for (unsigned i = 0; i < 6000; ++i)
  {
    Place p{};
    for (double& v : p)
    {
      v = double(random()) / double(random.max());
    }
    p[i % 3] = i % 2;
    points.push_back(p);
  }
  vtkNew<Filter> filter;
  filter->SetMaximumSurfaceAngle(120);
  const PolyData output = Reconstruct(*filter, MakePoints(points));
  vtkDataArray* const normals = output->GetPointData()->GetNormals();
  for (vtkIdType c = 0; c < output->GetNumberOfCells(); ++c)
  {
    const Ids ids = CellPoints(*output, c);
    const Place a = Point(*output, ids[0]);
    const Place area = Cross(Minus(Point(*output, ids[1]), a), Minus(Point(*output, ids[2]), a));
    double agreement = 0;
    for (const vtkIdType id : ids)
    {
      Place normal{};
      normals->GetTuple(id, normal.data());
      agreement += Dot(area, normal);
    }
    EXPECT_GE(agreement, -1e-6 * Length(area)) << c;
  }
}

TEST(PCLSurfaceReconstruction, NormalsTowardsTheViewPoint)
{
  // A scanner inside a room sees the inner side of its walls.
  vtkNew<Filter> filter;
  filter->SetOrientation(Filter::TOWARDS_VIEWPOINT);
  filter->SetViewPoint(7, 0, 0);
  const PolyData input = MakePoints(Spiral(2000, { 7, 0, 0 }));
  EXPECT_LT(ShareOutward(*Reconstruct(*filter, input), { 7, 0, 0 }), 0.001);
  filter->SetOrientation(Filter::NEIGHBORS_AGREE);
  filter->Update();
  EXPECT_GT(ShareOutward(*filter->GetOutput(), { 7, 0, 0 }), 0.999);
}

TEST(PCLSurfaceReconstruction, EachPartHasItsOutside)
{
  std::vector<Place> points = Spiral(1500);
  for (const Place& p : Spiral(1500, { 10, 0, -3 }))
  {
    points.push_back(p);
  }
  vtkNew<Filter> filter;
  const PolyData output = Reconstruct(*filter, MakePoints(points));
  vtkIdType outward = 0;
  for (vtkIdType c = 0; c < output->GetNumberOfCells(); ++c)
  {
    const Ids ids = CellPoints(*output, c);
    const Place a = Point(*output, ids[0]);
    const Place normal = Cross(Minus(Point(*output, ids[1]), a), Minus(Point(*output, ids[2]), a));
    const Place centre = a[0] > 5 ? Place{ 10, 0, -3 } : Place{};
    outward += Dot(normal, Minus(a, centre)) > 0;
  }
  EXPECT_EQ(outward, output->GetNumberOfCells());
}

TEST(PCLSurfaceReconstruction, PoissonPassesTheDataOfTheNearestPoint)
{
  const std::vector<Place> points = Spiral(3000);
  const PolyData input = MakePoints(points);
  vtkNew<vtkFloatArray> height;
  height->SetName("Height");
  for (const Place& p : points)
  {
    height->InsertNextValue(float(p[2]));
  }
  input->GetPointData()->AddArray(height);
  vtkNew<Filter> filter;
  filter->SetMethodToPoisson();
  const PolyData output = Reconstruct(*filter, input);
  vtkDataArray* const passed = output->GetPointData()->GetArray("Height");
  ASSERT_TRUE(passed);
  for (vtkIdType i = 0; i < output->GetNumberOfPoints(); ++i)
  {
    ASSERT_NEAR(passed->GetComponent(i, 0), Point(*output, i)[2], 0.06);
  }
}

TEST(PCLSurfaceReconstruction, TrimmingTakesAwayWhatNoPointIsNearTo)
{
  // Half a sphere: Poisson's surface continues below it.
  std::vector<Place> points = Spiral(6000);
  points.resize(3000);
  const PolyData input = MakePoints(points);
  vtkNew<Filter> filter;
  filter->SetMethodToPoisson();
  const vtkIdType whole = Reconstruct(*filter, input)->GetNumberOfCells();
  double bounds[6];
  filter->GetOutput()->GetBounds(bounds);
  const double lowest = bounds[4];
  filter->SetTrimDistance(3);
  filter->Update();
  EXPECT_LT(filter->GetOutput()->GetNumberOfCells(), whole);
  EXPECT_GT(CountEdges(*filter->GetOutput()).boundary, 0U);
  filter->GetOutput()->GetBounds(bounds);
  EXPECT_GT(bounds[4], lowest + 0.01);
  EXPECT_GT(bounds[4], -0.25) << "three spacings, and a triangle more";
  ExpectUnitNormals(*filter->GetOutput());
}

TEST(PCLSurfaceReconstruction, ALongestEdgeIsKept)
{
  const PolyData input = MakePoints(Spiral(2000)); // about 0.08 apart
  vtkNew<Filter> filter;
  filter->SetSearchRadius(0.09);
  const PolyData output = Reconstruct(*filter, input);
  EXPECT_GT(output->GetNumberOfCells(), 0);
  for (vtkIdType c = 0; c < output->GetNumberOfCells(); ++c)
  {
    const Ids ids = CellPoints(*output, c);
    for (std::size_t k = 0; k < 3; ++k)
    {
      EXPECT_LE(Length(Minus(Point(*output, ids[k]), Point(*output, ids[(k + 1) % 3]))), 0.0901);
    }
  }
  filter->SetSearchRadius(0.01);
  filter->Update();
  EXPECT_EQ(filter->GetOutput()->GetNumberOfCells(), 0) << "no two points are so near";
}

TEST(PCLSurfaceReconstruction, RepeatedPointsCountOnce)
{
  std::vector<Place> points = Spiral(1500);
  const std::vector<Place> once = points;
  points.insert(points.end(), once.begin(), once.end());
  points.insert(points.end(), 1000, once[17]);
  vtkNew<Filter> filter;
  const PolyData output = Reconstruct(*filter, MakePoints(points));
  EXPECT_EQ(output->GetNumberOfPoints(), 4000);
  vtkNew<Filter> plain;
  const PolyData expected = Reconstruct(*plain, MakePoints(once));
  ASSERT_EQ(output->GetNumberOfCells(), expected->GetNumberOfCells());
  for (vtkIdType c = 0; c < output->GetNumberOfCells(); ++c)
  {
    ASSERT_EQ(CellPoints(*output, c), CellPoints(*expected, c));
  }
}

TEST(PCLSurfaceReconstruction, AnyUnit)
{
  for (const double scale : { 1e-12, 1e-30, 1e9, 1e25, 1e100 })
  {
    for (const int method : { Filter::GREEDY, Filter::POISSON })
    {
      vtkNew<Filter> filter;
      filter->SetMethod(method);
      const PolyData output = Reconstruct(*filter, MakePoints(Spiral(1000, {}, scale)));
      EXPECT_GT(output->GetNumberOfCells(), 900) << scale << " " << method;
      EXPECT_LT(DistanceToSphere(*output, {}, scale), 0.03 * scale) << scale << " " << method;
    }
  }
}

TEST(PCLSurfaceReconstruction, HardCloudsGiveASurfaceOrSayWhyNot)
{
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const struct
  {
    std::vector<Place> points;
    const char* error;
  } cases[] = {
    { { { 0, 0, 0 } }, "needs three points in different places; there are 1" },
    { { { 0, 0, 0 }, { 1, 0, 0 } }, "needs three points in different places; there are 2" },
    { std::vector<Place>(500, { 4, 5, 6 }), "needs three points in different places; there are 1" },
    { { { 0, 0, 0 }, { 1, 2, 3 }, { 2, 4, 6 }, { 3, 6, 9 }, { 7, 14, 21 } },
      "all points lie on one line" },
    { { { 0, 0, 0 }, { 0, nan, 0 }, { 1, 1, 1 } }, "point 1: a coordinate is not finite" },
    { { { -1e308, 0, 0 }, { 1e308, 1, 0 }, { 0, 1, 1 } }, "exceeds the range of doubles" },
    { { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 } }, nullptr },
    { { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 }, { 1, 1, 0 }, { 0.5, 0.5, 1 } }, nullptr },
    { { { 0, 0, 0 }, { 1e-30, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1e30 } },
      "all points lie on one line" },
  };
  for (const int method : { Filter::GREEDY, Filter::POISSON })
  {
    for (const auto& c : cases)
    {
      SCOPED_TRACE(c.error ? c.error : "no error");
      vtkNew<Filter> filter;
      filter->SetMethod(method);
      Reconstruct(*filter, MakePoints(Spiral(100)));
      FilterObserver observer(filter);
      const PolyData output = Reconstruct(*filter, MakePoints(c.points));
      if (c.error)
      {
        EXPECT_NE(observer.error.find(c.error), std::string::npos) << observer.error;
        EXPECT_TRUE(observer.failed);
        EXPECT_EQ(output->GetNumberOfPoints(), 0);
        EXPECT_EQ(output->GetNumberOfCells(), 0);
      }
      else
      {
        EXPECT_EQ(observer.error, "");
      }
    }
    vtkNew<Filter> filter;
    filter->SetMethod(method);
    FilterObserver observer(filter);
    for (const PolyData& empty : { PolyData::New(), MakePoints({}) })
    {
      EXPECT_EQ(Reconstruct(*filter, empty)->GetNumberOfCells(), 0);
      EXPECT_EQ(observer.error, "");
    }
  }
}

TEST(PCLSurfaceReconstruction, RandomClouds)
{
  std::mt19937 random(3);
  const auto draw = [&](unsigned kinds) { return double(random() % kinds); };
  for (unsigned trial = 0; trial < 24; ++trial)
  {
    std::vector<Place> points;
    const auto count = 3 + random() % 200;
    const unsigned kinds = trial % 3 == 0 ? 3 : trial % 3 == 1 ? 10 : 100000;
    for (unsigned i = 0; i < count; ++i)
    {
      points.push_back({ draw(kinds), draw(kinds), trial % 2 == 0 ? 0 : draw(kinds) });
    }
    for (const int method : { Filter::GREEDY, Filter::POISSON })
    {
      vtkNew<Filter> filter;
      filter->SetMethod(method);
      FilterObserver observer(filter);
      const PolyData output = Reconstruct(*filter, MakePoints(points));
      for (vtkIdType c = 0; c < output->GetNumberOfCells(); ++c)
      {
        for (const vtkIdType id : CellPoints(*output, c))
        {
          ASSERT_LT(id, output->GetNumberOfPoints());
        }
      }
    }
  }
}

TEST(PCLSurfaceReconstruction, SameOnEveryBackendAndNumberOfThreads)
{
  for (const int method : { Filter::GREEDY, Filter::POISSON })
  {
    std::string first;
    for (const std::string& backend : smpBackends)
    {
      for (const int threads : { 8, 1 })
      {
        if (UseSmpBackend(backend, threads))
        {
          vtkNew<Filter> filter;
          filter->SetMethod(method);
          const std::string text =
            Describe(*Reconstruct(*filter, MakePoints(RandomSphere(3000, 5))));
          first = first.empty() ? text : first;
          EXPECT_TRUE(text == first) << backend << ", " << threads << " threads";
        }
      }
    }
  }
}

TEST(PCLSurfaceReconstruction, ProgressRisesAndAbortIsNotAnError)
{
  for (const double at : { 2.0, 0.0, 0.2, 0.4 })
  {
    vtkNew<Filter> filter;
    FilterObserver observer(filter);
    observer.abortAt = at;
    const PolyData output = Reconstruct(*filter, MakePoints(Spiral(2000)));
    EXPECT_EQ(observer.error, "");
    EXPECT_FALSE(observer.failed);
    EXPECT_TRUE(std::is_sorted(observer.progress.begin(), observer.progress.end()));
    EXPECT_EQ(output->GetNumberOfPoints(), at < 1 ? 0 : 2000) << at;
    EXPECT_GE(observer.progress.size(), at < 1 ? 1U : 5U);
    observer.StopAborting();
    filter->Update();
    EXPECT_EQ(filter->GetOutput()->GetNumberOfPoints(), 2000);
  }
}

TEST(PCLSurfaceReconstruction, RunsAgainOnlyWhenSomethingChanged)
{
  vtkNew<Filter> filter;
  const PolyData input = MakePoints(Spiral(300));
  FilterObserver observer(filter);
  Reconstruct(*filter, input);
  filter->Update();
  filter->SetMethod(filter->GetMethod());
  filter->SetDepth(0);
  filter->SetViewPoint(0, 0, 0);
  filter->Update();
  EXPECT_EQ(observer.runs, 1);
  int runs = 1;
  const auto expectRun = [&]()
  {
    filter->Update();
    EXPECT_EQ(observer.runs, ++runs);
  };
  filter->SetMethodToPoisson();
  expectRun();
  filter->SetDepth(5);
  expectRun();
  filter->SetSearchRadius(0.5);
  expectRun();
  filter->SetViewPoint(1, 0, 0);
  expectRun();
  input->Modified();
  expectRun();
}

TEST(PCLSurfaceReconstruction, EveryOptionCounts)
{
  const PolyData input = MakePoints(RandomSphere(1500, 2));
  const auto run = [&](int method, const auto& set)
  {
    vtkNew<Filter> filter;
    filter->SetMethod(method);
    set(*filter);
    return Describe(*Reconstruct(*filter, input));
  };
  const std::string greedy = run(Filter::GREEDY, [](Filter&) {});
  EXPECT_NE(greedy, run(Filter::GREEDY, [](Filter& f) { f.SetMu(1.5); }));
  EXPECT_NE(greedy, run(Filter::GREEDY, [](Filter& f) { f.SetSearchRadius(0.1); }));
  EXPECT_NE(greedy, run(Filter::GREEDY, [](Filter& f) { f.SetMaximumNumberOfNeighbors(8); }));
  EXPECT_NE(greedy, run(Filter::GREEDY, [](Filter& f) { f.SetMaximumSurfaceAngle(2); }));
  EXPECT_NE(greedy, run(Filter::GREEDY, [](Filter& f) { f.SetMinimumAngle(30); }));
  EXPECT_NE(greedy, run(Filter::GREEDY, [](Filter& f) { f.SetMaximumAngle(80); }));
  EXPECT_NE(greedy, run(Filter::GREEDY, [](Filter& f) { f.SetNumberOfNeighbors(30); }));
  EXPECT_NE(greedy, run(Filter::GREEDY, [](Filter& f) { f.SetNormalRadius(0.4); }));
  const std::string poisson = run(Filter::POISSON, [](Filter&) {});
  EXPECT_NE(poisson, run(Filter::POISSON, [](Filter& f) { f.SetDepth(4); }));
  EXPECT_NE(poisson, run(Filter::POISSON, [](Filter& f) { f.SetSamplesPerNode(5); }));
  EXPECT_NE(poisson, run(Filter::POISSON, [](Filter& f) { f.SetPointWeight(0); }));
  EXPECT_NE(poisson, run(Filter::POISSON, [](Filter& f) { f.SetTrimDistance(0.01); }));
}

TEST(PCLSurfaceReconstruction, OptionsAreClampedAndPrinted)
{
  vtkNew<Filter> filter;
  EXPECT_EQ(filter->GetMethod(), Filter::GREEDY);
  filter->SetMethod(17);
  EXPECT_EQ(filter->GetMethod(), Filter::POISSON);
  filter->SetNumberOfNeighbors(0);
  EXPECT_EQ(filter->GetNumberOfNeighbors(), 3);
  filter->SetDepth(99);
  EXPECT_EQ(filter->GetDepth(), 12);
  EXPECT_STREQ(filter->GetMethodAsString(), "Poisson");
  EXPECT_STREQ(filter->GetOrientationAsString(), "NeighborsAgree");
  {
    FilterObserver observer(filter);
    filter->SetSearchRadius(-1);
    filter->SetMaximumAngle(std::numeric_limits<double>::quiet_NaN());
    EXPECT_NE(observer.error.find("SearchRadius must be from 0 to "), std::string::npos);
    EXPECT_NE(
      observer.error.find("MaximumAngle must be from 0 to 180, not nan"), std::string::npos);
  }
  EXPECT_EQ(filter->GetSearchRadius(), 0);
  EXPECT_EQ(filter->GetMaximumAngle(), 120);
  EXPECT_EQ(
    NotFiniteTakenBy<Filter>(*filter, "ViewPoint", &Filter::SetViewPoint, &Filter::GetViewPoint),
    "");
  filter->SetNormalRadius(0.5);
  filter->SetOrientation(Filter::TOWARDS_VIEWPOINT);
  filter->SetViewPoint(1, 2, 3);
  filter->SetSearchRadius(0.25);
  filter->SetMu(2.5);
  filter->SetMaximumNumberOfNeighbors(50);
  filter->SetMaximumSurfaceAngle(30);
  filter->SetMinimumAngle(5);
  filter->SetMaximumAngle(100);
  filter->SetSamplesPerNode(2);
  filter->SetPointWeight(3);
  filter->SetTrimDistance(4);
  filter->UseInputNormalsOff();
  std::ostringstream text;
  filter->Print(text);
  for (const char* line : { "Method: Poisson\n", "UseInputNormals: off\n", "NumberOfNeighbors: 3\n",
         "NormalRadius: 0.5\n", "Orientation: TowardsViewPoint\n", "ViewPoint: (1, 2, 3)\n",
         "SearchRadius: 0.25\n", "Mu: 2.5\n", "MaximumNumberOfNeighbors: 50\n",
         "MaximumSurfaceAngle: 30\n", "MinimumAngle: 5\n", "MaximumAngle: 100\n", "Depth: 12\n",
         "SamplesPerNode: 2\n", "PointWeight: 3\n", "TrimDistance: 4\n" })
  {
    EXPECT_NE(text.str().find(line), std::string::npos) << line;
  }
}

}
