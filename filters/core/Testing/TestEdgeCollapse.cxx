// SPDX-License-Identifier: BSD-3-Clause
#include "Testing/Fixtures/Invariants.h"
#include "Testing/Fixtures/Meshes.h"
#include "filters/core/TriangleDistance.h"
#include "filters/core/Weld.h"
#include "filters/core/collapse/EdgeCollapse.h"
#include "filters/core/levels/ClusterLevels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <set>

using namespace kdstream;
using namespace kdstream::fixtures;

namespace
{

CollapsePart PartOf(const Mesh& mesh)
{
  CollapsePart part;
  part.positions = mesh.points;
  part.quadrics.resize(mesh.points.size());
  part.triangles = mesh.triangles;
  part.bounds = BoxOfPoints(mesh.points);
  const std::vector<Edge> boundary = BoundaryEdges(mesh.triangles);
  const std::set<Edge> isBoundary(boundary.begin(), boundary.end());
  for (const Triangle& t : mesh.triangles)
  {
    for (std::size_t k = 0; k < 3; ++k)
    {
      const VertexId a = t[k], b = t[(k + 1) % 3], c = t[(k + 2) % 3];
      part.quadrics[a].Add(Quadric::OfTriangle(mesh.points[a], mesh.points[b], mesh.points[c]));
      if (isBoundary.contains(std::minmax(a, b)))
      {
        part.quadrics[a].AddBoundary(mesh.points[a], mesh.points[b], mesh.points[c]);
        part.quadrics[b].AddBoundary(mesh.points[a], mesh.points[b], mesh.points[c]);
      }
    }
  }
  return part;
}

// The mesh after the recorded merges.
Mesh Replayed(const Mesh& mesh, const std::vector<Merge>& merges)
{
  Mesh result = mesh;
  std::vector<VertexId> into(mesh.points.size());
  std::iota(into.begin(), into.end(), VertexId{ 0 });
  for (const Merge& merge : merges)
  {
    EXPECT_EQ(into[merge.from], merge.from) << "merged twice";
    EXPECT_EQ(into[merge.to], merge.to) << "merged into what is gone";
    into[merge.from] = merge.to;
    result.points[merge.to] = merge.position;
  }
  for (std::size_t i = merges.size(); i-- > 0;)
  {
    into[merges[i].from] = into[merges[i].to];
  }
  result.triangles = ImageOfTriangles(mesh.triangles, into);
  return result;
}

Vec3 NormalOf(const Mesh& mesh, const Triangle& t)
{
  const Vec3& origin = mesh.points[t[0]];
  return Cross(Minus(mesh.points[t[1]], origin), Minus(mesh.points[t[2]], origin));
}

std::size_t CountVertices(const std::vector<Triangle>& triangles)
{
  std::set<VertexId> used;
  for (const Triangle& t : triangles)
  {
    used.insert(t.begin(), t.end());
  }
  return used.size();
}

}

TEST(EdgeCollapse, CountsWhatIsLeft)
{
  for (const NamedMesh& named : ClosedMeshes())
  {
    for (const double area : { 0.0, 1e-3 })
    {
      SCOPED_TRACE(named.name);
      CollapsePart part = PartOf(named.mesh);
      part.areaPerVertex = area;
      EdgeCollapse engine(std::move(part));
      const std::size_t before = CountVertices(named.mesh.triangles);
      EXPECT_EQ(engine.VertexCount(), before);
      EXPECT_TRUE(engine.Run(before / 4));
      const Mesh left = Replayed(named.mesh, engine.Merges());
      EXPECT_EQ(engine.VertexCount(), before / 4);
      EXPECT_EQ(CountVertices(left.triangles), before / 4);
      EXPECT_EQ(engine.TriangleCount(), left.triangles.size());
      EXPECT_TRUE(engine.Run(EdgeCollapse::any, left.triangles.size() / 2));
      EXPECT_LE(engine.TriangleCount(), left.triangles.size() / 2);
      EXPECT_GE(engine.TriangleCount() + 2, left.triangles.size() / 2);
      for (std::size_t i = 1; i < engine.Merges().size(); ++i)
      {
        ASSERT_GE(engine.Merges()[i].error, engine.Merges()[i - 1].error);
      }
    }
  }
}

TEST(EdgeCollapse, KeepsTheTopologyAndStopsThere)
{
  for (const NamedMesh& named : ClosedMeshes())
  {
    SCOPED_TRACE(named.name);
    const auto euler = [](const Mesh& mesh)
    {
      return static_cast<long>(CountVertices(mesh.triangles)) -
             static_cast<long>(mesh.triangles.size()) / 2;
    };
    EdgeCollapse engine(PartOf(named.mesh));
    EXPECT_FALSE(engine.Run(0));
    const Mesh left = Replayed(named.mesh, engine.Merges());
    EXPECT_EQ(euler(left), euler(named.mesh));
    EXPECT_TRUE(BoundaryEdges(left.triangles).empty());
    EXPECT_LE(engine.VertexCount(), 40U);
  }
}

TEST(EdgeCollapse, WithoutTopologyEverythingGoes)
{
  CollapsePart part = PartOf(Torus(30, 20));
  part.keepTopology = false;
  EdgeCollapse engine(std::move(part));
  engine.Run(6);
  EXPECT_LE(engine.VertexCount(), 6U); // a torus has at least 7
}

TEST(EdgeCollapse, NormalsDoNotFlip)
{
  const Mesh sphere = DisplacedSphere(5);
  EdgeCollapse engine(PartOf(sphere));
  ASSERT_TRUE(engine.Run(60));
  const Mesh left = Replayed(sphere, engine.Merges());
  for (const Triangle& t : left.triangles)
  {
    Vec3 middle{};
    for (const VertexId v : t)
    {
      for (std::size_t k = 0; k < 3; ++k)
      {
        middle[k] += left.points[v][k] / 3;
      }
    }
    EXPECT_GT(Dot(NormalOf(left, t), middle), 0); // outwards
  }
}

TEST(EdgeCollapse, FixedVerticesStay)
{
  const Mesh plate = GridPlate(30);
  CollapsePart part = PartOf(plate);
  for (const Vec3& p : plate.points)
  {
    part.fixed.push_back(p[0] >= 15);
  }
  EdgeCollapse engine(part);
  engine.Run(0);
  EXPECT_GT(engine.Merges().size(), 300U);
  for (const Merge& merge : engine.Merges())
  {
    EXPECT_FALSE(part.fixed[merge.from]);
    EXPECT_FALSE(part.fixed[merge.to]);
  }
}

TEST(EdgeCollapse, FixingLaterHolds)
{
  const Mesh sphere = DisplacedSphere(4);
  EdgeCollapse engine(PartOf(sphere));
  engine.Run(1000);
  const std::size_t before = engine.Merges().size();
  for (VertexId v = 0; v < sphere.points.size(); v += 2)
  {
    engine.Fix(v);
  }
  engine.Run(0);
  EXPECT_GT(engine.Merges().size(), before);
  for (std::size_t i = before; i < engine.Merges().size(); ++i)
  {
    EXPECT_EQ(engine.Merges()[i].from % 2, 1U);
    EXPECT_EQ(engine.Merges()[i].to % 2, 1U);
  }
}

TEST(EdgeCollapse, BoundariesStayInPlaceAndCornersToo)
{
  // Once flat, and once with noise inside, which makes collapses expensive there: the boundary must
  // not suffer.
  for (const double noise : { 0.0, 0.03 })
  {
    Mesh plate = GridPlate(24);
    std::mt19937 random(3);
    for (Vec3& p : plate.points)
    {
      const bool inside = p[0] > 0 && p[0] < 24 && p[1] > 0 && p[1] < 24;
      p[2] = inside ? noise * double(random() % 1000) / 1000 : 0;
    }
    EdgeCollapse engine(PartOf(plate));
    engine.Run(100);
    const Mesh left = Replayed(plate, engine.Merges());
    double area = 0; // seen from the corner at the origin
    for (const Edge& edge : BoundaryEdges(left.triangles))
    {
      const Vec3 &a = left.points[edge.first], &b = left.points[edge.second];
      for (const Vec3& p : { a, b })
      {
        const double away =
          std::min({ std::abs(p[0]), std::abs(p[0] - 24), std::abs(p[1]), std::abs(p[1] - 24) });
        EXPECT_LE(away, noise == 0 ? 1e-12 : 1e-3);
      }
      area += std::abs(a[0] * b[1] - a[1] * b[0]) / 2;
    }
    EXPECT_NEAR(area, 24 * 24, noise == 0 ? 1e-9 : 1e-2);
  }
}

TEST(EdgeCollapse, TrianglesOfAPlaneDoNotTurnOver)
{
  // In a plane no place has a cost: only the check of normals prevents flips.
  Mesh plate = GridPlate(30);
  std::mt19937 random(8);
  for (Vec3& p : plate.points)
  {
    p[0] += double(random() % 1000) / 1200;
    p[1] += double(random() % 1000) / 1200;
    p[2] = 0;
  }
  EdgeCollapse engine(PartOf(plate));
  for (const std::size_t count : { 700U, 400U, 200U, 100U })
  {
    engine.Run(count);
    const Mesh left = Replayed(plate, engine.Merges());
    for (const Triangle& t : left.triangles)
    {
      ASSERT_GT(NormalOf(left, t)[2], 0) << count << " vertices";
    }
  }
}

TEST(EdgeCollapse, DoesNotPinchTheBoundary)
{
  // A narrow ribbon that goes up and down: collapsing across is cheaper than along, but would tear
  // it.
  Mesh ribbon;
  std::mt19937 random(3);
  for (VertexId i = 0; i < 80; i += 2)
  {
    const double height = double(random() % 1000) / 100;
    ribbon.points.push_back({ double(i), 0, height });
    ribbon.points.push_back({ double(i), 0.1, height });
    if (i >= 2)
    {
      ribbon.triangles.push_back({ i - 2, i, i - 1 });
      ribbon.triangles.push_back({ i - 1, i, i + 1 });
    }
  }
  EdgeCollapse engine(PartOf(ribbon));
  engine.Run(40);
  const Mesh left = Replayed(ribbon, engine.Merges());
  std::map<VertexId, int> ends;
  for (const Edge& edge : BoundaryEdges(left.triangles))
  {
    ++ends[edge.first];
    ++ends[edge.second];
  }
  EXPECT_GE(ends.size(), 4U);
  for (const auto& entry : ends)
  {
    EXPECT_EQ(entry.second, 2) << "vertex " << entry.first;
  }
}

TEST(EdgeCollapse, ThePriceOfGoingBackKeepsLimbs)
{
  // A plate with a long thin spike: quadrics make collapsing its tip cheap, because the tip moves
  // along the planes of the sides.
  Mesh mesh = ThinPlate(20);
  const auto base = static_cast<VertexId>(mesh.points.size());
  constexpr double height = 5;
  for (VertexId i = 0; i < 3 * 11; ++i)
  {
    const double angle = 2.1 * (i % 3);
    mesh.points.push_back(
      { 0.5 + 1e-4 * std::cos(angle), 0.5 + 1e-4 * std::sin(angle), height * (i / 3) / 10.0 });
  }
  const auto side = [&](VertexId i, VertexId k) { return base + 3 * i + k % 3; };
  for (VertexId i = 0; i < 10; ++i)
  {
    for (VertexId k = 0; k < 3; ++k)
    {
      mesh.triangles.push_back({ side(i, k), side(i, k + 1), side(i + 1, k) });
      mesh.triangles.push_back({ side(i, k + 1), side(i + 1, k + 1), side(i + 1, k) });
    }
  }
  mesh.triangles.push_back({ side(0, 0), side(0, 2), side(0, 1) });
  mesh.triangles.push_back({ side(10, 0), side(10, 1), side(10, 2) });
  const auto top = [&](double area)
  {
    CollapsePart part = PartOf(mesh);
    part.areaPerVertex = area;
    part.keepTopology = false;
    EdgeCollapse engine(std::move(part));
    engine.Run(12);
    double highest = 0;
    const Mesh left = Replayed(mesh, engine.Merges());
    for (const Triangle& t : left.triangles)
    {
      for (const VertexId v : t)
      {
        highest = std::max(highest, left.points[v][2]);
      }
    }
    return highest;
  };
  EXPECT_GT(top(1), 0.9 * height);
  EXPECT_LT(top(0), 0.9 * height);
}

TEST(EdgeCollapse, AttributesHoldTheirEdges)
{
  // A flat plate, half black and half white: without a price merges cross the border.
  const Mesh plate = GridPlate(20);
  const auto mixed = [&](float scale)
  {
    CollapsePart part = PartOf(plate);
    part.components = 1;
    for (const Vec3& p : plate.points)
    {
      part.attributes.push_back(p[0] < 10.5 ? 0 : scale);
    }
    EdgeCollapse engine(part);
    engine.Run(60);
    std::size_t across = 0;
    for (const Merge& merge : engine.Merges())
    {
      across += (plate.points[merge.from][0] < 10.5) != (plate.points[merge.to][0] < 10.5);
    }
    return across;
  };
  EXPECT_EQ(mixed(1), 0U);
  EXPECT_GT(mixed(0), 0U) << "the plate says nothing";
}

TEST(EdgeCollapse, AnyTrianglesWillDo)
{
  // Edges of many triangles, duplicates and folds: whatever merges, the record must be consistent.
  for (const unsigned seed : { 1U, 2U, 3U, 4U, 5U, 6U, 7U, 8U })
  {
    std::mt19937 random(seed);
    Mesh mesh;
    for (unsigned i = 0; i < 60; ++i)
    {
      mesh.points.push_back({ double(random() % 5), double(random() % 5), double(random() % 5) });
    }
    for (unsigned i = 0; i < 300; ++i)
    {
      const Triangle t{ static_cast<VertexId>(random() % 60), static_cast<VertexId>(random() % 60),
        static_cast<VertexId>(random() % 60) };
      if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0])
      {
        mesh.triangles.push_back(t);
        mesh.triangles.push_back(i % 3 == 0 ? t : Triangle{ t[1], t[0], t[2] });
      }
    }
    for (const bool topology : { true, false })
    {
      CollapsePart part = PartOf(mesh);
      part.keepTopology = topology;
      part.areaPerVertex = 1;
      EdgeCollapse engine(std::move(part));
      engine.Run(0);
      const Mesh left = Replayed(mesh, engine.Merges());
      EXPECT_EQ(engine.VertexCount(), CountVertices(left.triangles));
    }
  }
}

// A flat tangle: each triangle has one neighbour of its first vertex and one arbitrary vertex, so
// that most merges would flip a triangle, and every vertex has far more edges than on a surface.
TEST(EdgeCollapse, KnotsTakeStepsInProportion)
{
  for (const unsigned triangles : { 17U, 60U }) // for each vertex
  {
    SCOPED_TRACE(triangles);
    Mesh knot = GridPlate(20);
    const std::size_t vertices = knot.points.size();
    std::mt19937 random(3);
    for (Vec3& p : knot.points)
    {
      p[0] += double(random() % 512) / 1024;
      p[1] += double(random() % 512) / 1024;
    }
    knot.triangles.clear();
    while (knot.triangles.size() < triangles * vertices)
    {
      const auto any = [&] { return static_cast<VertexId>(random() % vertices); };
      const VertexId a = any(), b = random() % 3 == 0 ? any() : a + 1, c = any();
      if (b < vertices && a != b && b != c && c != a)
      {
        knot.triangles.push_back({ a, b, c });
      }
    }
    CollapsePart part = PartOf(knot);
    part.quadrics.assign(vertices, {}); // no boundaries: all places cost the same
    for (const Triangle& t : knot.triangles)
    {
      for (const VertexId v : t)
      {
        part.quadrics[v].Add(
          Quadric::OfTriangle(knot.points[t[0]], knot.points[t[1]], knot.points[t[2]]));
      }
    }
    part.keepTopology = false;
    part.areaPerVertex = 1;
    EdgeCollapse engine(std::move(part));
    EXPECT_FALSE(engine.Run(vertices / 8));
    EXPECT_LT(engine.Steps(), 100000 * vertices);
  }
}

// Triangles between arbitrary vertices near each other, as among the clusters of a triangle soup:
// most merges would flip a triangle. The result has side³ vertices.
CollapsePart Tangle(unsigned side, std::size_t trianglesPerVertex)
{
  constexpr unsigned reach = 2;
  Mesh tangle;
  std::mt19937 random(7);
  for (unsigned i = 0; i < side * side * side; ++i)
  {
    Vec3 p{ double(i % side), double(i / side % side), double(i / side / side) };
    for (double& x : p)
    {
      x += double(random() % 1024) / 1024;
    }
    tangle.points.push_back(p);
  }
  const auto near = [&](VertexId v) -> VertexId
  {
    const unsigned places[] = { v % side, v / side % side, v / side / side };
    VertexId found = 0;
    for (std::size_t k = 3; k-- > 0;)
    {
      const auto step = static_cast<unsigned>(random() % (2 * reach + 1));
      found = found * side + std::clamp(places[k] + step, reach, side - 1 + reach) - reach;
    }
    return found;
  };
  while (tangle.triangles.size() < trianglesPerVertex * tangle.points.size())
  {
    const auto a = static_cast<VertexId>(random() % tangle.points.size());
    const VertexId b = near(a), c = near(a);
    if (a != b && b != c && c != a)
    {
      tangle.triangles.push_back({ a, b, c });
    }
  }
  CollapsePart part = PartOf(tangle);
  part.areaPerVertex = 1;
  return part;
}

// Retrying refused merges whenever a neighbour changes would never end. With a limit on retries a
// tangle must not take hundreds of times the steps of a surface, and must still find nearly all
// merges.
TEST(EdgeCollapse, TanglesTakeStepsAsSurfacesDo)
{
  CollapsePart part = Tangle(20, 2);
  const std::size_t vertices = part.positions.size(), triangles = part.triangles.size();
  EdgeCollapse engine(std::move(part));
  EXPECT_FALSE(engine.Run(vertices / 4));
  EXPECT_LT(engine.Steps(), 100 * (vertices + triangles));
  EXPECT_GT(engine.Merges().size(), 4600U); // 5,124 with unlimited retries
}

// A tangle so dense that hardly any edge can collapse: not even all edges are tried.
TEST(EdgeCollapse, HopelessTanglesAreGivenUp)
{
  CollapsePart part = Tangle(16, 8);
  const std::size_t vertices = part.positions.size(), triangles = part.triangles.size();
  EdgeCollapse engine(std::move(part));
  EXPECT_FALSE(engine.Run(vertices / 4));
  EXPECT_LT(engine.Steps(), 36 * (vertices + triangles)); // a factor of 61 if all edges are tried
}

// A surface has two triangles for each vertex. Seven must not allow more than twice the tries.
TEST(EdgeCollapse, TriesGrowWithVerticesNotWithTangledTriangles)
{
  CollapsePart part = Tangle(20, 7);
  const std::size_t vertices = part.positions.size();
  EdgeCollapse engine(std::move(part));
  EXPECT_FALSE(engine.Run(vertices / 4));
  EXPECT_LT(engine.Steps(), 80 * vertices); // a factor of 136 if all triangles counted
}

// Even denser tangles are not tried, unless they are so small that trying costs nothing.
TEST(EdgeCollapse, DenseTanglesAreNotTried)
{
  CollapsePart large = Tangle(12, 9);
  ASSERT_GT(large.triangles.size(), 4096U);
  EdgeCollapse engine(std::move(large));
  EXPECT_FALSE(engine.Run(100));
  EXPECT_EQ(engine.Steps(), 0U);
  EXPECT_TRUE(engine.Merges().empty());

  EdgeCollapse small(Tangle(5, 9));
  EXPECT_FALSE(small.Run(10));
  EXPECT_GT(small.Steps(), 0U);
}

// The hub of a fan, fixed or not: its triangles are visited once, not once for each neighbour.
TEST(EdgeCollapse, FansTakeStepsInProportion)
{
  for (const bool fixed : { false, true })
  {
    constexpr VertexId rim = 30000;
    Mesh fan{ { { 0, 0, 0 } }, {} };
    for (VertexId i = 1; i <= rim; ++i)
    {
      const double angle = i * (6.283185307179586 / rim);
      fan.points.push_back({ std::cos(angle), std::sin(angle), 0.01 * std::sin(5 * angle) });
      fan.triangles.push_back({ 0, i, i % rim + 1 });
    }
    CollapsePart part = PartOf(fan);
    part.areaPerVertex = 1e-4;
    part.fixed.assign(fan.points.size(), 0);
    part.fixed[0] = fixed ? 1 : 0;
    EdgeCollapse engine(std::move(part));
    EXPECT_TRUE(engine.Run(20));
    EXPECT_EQ(engine.VertexCount(), 20U);
    const Mesh left = Replayed(fan, engine.Merges());
    EXPECT_EQ(engine.TriangleCount(), left.triangles.size());
    EXPECT_LT(engine.Steps(), 500 * std::uint64_t{ rim });
  }
}
