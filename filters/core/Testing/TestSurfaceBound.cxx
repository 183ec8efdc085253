// SPDX-License-Identifier: BSD-3-Clause
#include "filters/core/Testing/BuiltLevels.h"
#include "filters/core/TriangleDistance.h"
#include "filters/core/VectorMath.h"
#include "filters/core/pieces/SurfaceBound.h"

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

// Points where there are no triangles.
std::vector<Triangle> TrianglesOf(const Mesh& mesh)
{
  std::vector<Triangle> triangles = mesh.triangles;
  for (VertexId v = 0; v < mesh.points.size() && mesh.triangles.empty(); ++v)
  {
    triangles.push_back({ v, v, v });
  }
  return triangles;
}

SearchedPart WholeOf(const Mesh& mesh)
{
  return { mesh.points, TrianglesOf(mesh) };
}

// In balls of six points that follow each other, around the first.
MeasuredPart Measured(const Mesh& mesh, std::span<const Triangle> triangles)
{
  std::vector<Vec3> centres;
  std::vector<std::int32_t> ballOf;
  for (std::size_t v = 0; v < mesh.points.size(); ++v)
  {
    if (v % 6 == 0)
    {
      centres.push_back(mesh.points[v]);
    }
    ballOf.push_back(std::int32_t(v / 6));
  }
  return { mesh.points, triangles, ballOf, centres };
}

// How far one part, or nothing, is from another surface.
Result<double> Farthest(
  const Mesh& mesh, std::span<const Triangle> triangles, const LevelSurface& to, double enough)
{
  MeasuredPart from = Measured(mesh, triangles);
  return FarthestPoint(from, to, enough);
}

// In parts of so many triangles.
std::vector<std::vector<Triangle>> PartsOf(const Mesh& mesh, std::size_t size)
{
  const std::vector<Triangle> all = TrianglesOf(mesh);
  std::vector<std::vector<Triangle>> parts;
  for (std::size_t first = 0; first < all.size(); first += size)
  {
    const auto begin = all.begin() + std::ptrdiff_t(first);
    parts.emplace_back(begin, begin + std::ptrdiff_t(std::min(size, all.size() - first)));
  }
  return parts;
}

Status NothingElse(const Vec3&, double&)
{
  return {};
}

double BoundOf(const Mesh& one, const Mesh& other, double enough = 0, double smallest = 0)
{
  const SearchedPart to = WholeOf(other);
  return *Farthest(one, TrianglesOf(one), { to, NothingElse, smallest }, enough);
}

// From all parts of one mesh in some order to those of the other, of which each looks at one first.
double BoundOfParts(const Mesh& one, const Mesh& other, std::size_t size, unsigned seed,
  double smallest = 0, double enough = 0)
{
  const std::vector<std::vector<Triangle>> from = PartsOf(one, size);
  std::vector<SearchedPart> to;
  for (const std::vector<Triangle>& part : PartsOf(other, size))
  {
    to.emplace_back(other.points, part);
  }
  std::vector<std::size_t> order(from.size());
  std::iota(order.begin(), order.end(), std::size_t{ 0 });
  std::shuffle(order.begin(), order.end(), std::mt19937(seed));
  const auto others = [&](const Vec3& place, double& squared)
  {
    std::for_each(
      to.begin(), to.end(), [&](const SearchedPart& part) { part.Nearest(place, 0, squared); });
    return Status{};
  };
  for (const std::size_t i : order)
  {
    enough = *Farthest(one, from[i], { to[i * to.size() / from.size()], others, smallest }, enough);
  }
  return enough;
}

// What is told without a closer look.
double LargestDeviation(const ClusterLevel& level)
{
  return *std::max_element(level.deviations.begin(), level.deviations.end());
}

// Of all triangles, one after the other.
double BruteDistance(const Mesh& mesh, const Vec3& place)
{
  double squared = INFINITY;
  for (const Triangle& t : TrianglesOf(mesh))
  {
    squared = std::min(
      squared, SquaredToTriangle(place, mesh.points[t[0]], mesh.points[t[1]], mesh.points[t[2]]));
  }
  return std::sqrt(squared);
}

double SearchedDistance(const SearchedPart& part, const Vec3& place)
{
  double squared = INFINITY;
  part.Nearest(place, 0, squared);
  return std::sqrt(squared);
}

// The farthest of some random points of one mesh from the other; few are looked at without a
// search.
double SampledDistance(const Mesh& one, const Mesh& other, unsigned samples)
{
  constexpr unsigned few = 100;
  const SearchedPart to = WholeOf(other);
  std::mt19937 random(samples);
  std::uniform_real_distribution<double> unit(0, 1);
  double farthest = 0;
  for (unsigned i = 0; i < samples; ++i)
  {
    Vec3 place = one.points[random() % one.points.size()];
    if (!one.triangles.empty())
    {
      const Triangle& t = one.triangles[random() % one.triangles.size()];
      const double r = unit(random), s = unit(random) * (1 - r);
      for (std::size_t k = 0; k < 3; ++k)
      {
        place[k] =
          one.points[t[0]][k] * (1 - r - s) + one.points[t[1]][k] * r + one.points[t[2]][k] * s;
      }
    }
    farthest = std::max(
      farthest, samples <= few ? BruteDistance(other, place) : SearchedDistance(to, place));
  }
  return farthest;
}

Mesh Square(double height, double side = 2)
{
  return { { { 0, 0, height }, { side, 0, height }, { side, side, height }, { 0, side, height } },
    { { 0, 1, 2 }, { 0, 2, 3 } } };
}

Mesh Both(Mesh mesh, const Mesh& second)
{
  const auto first = static_cast<VertexId>(mesh.points.size());
  mesh.points.insert(mesh.points.end(), second.points.begin(), second.points.end());
  for (const Triangle& t : second.triangles)
  {
    mesh.triangles.push_back({ first + t[0], first + t[1], first + t[2] });
  }
  return mesh;
}

}

TEST(SurfaceBound, OfParallelSquaresIsTheirDistance)
{
  const double bound = BoundOf(Square(0), Square(0.25));
  EXPECT_GE(bound, 0.25);
  EXPECT_LE(bound, 0.25 * 1.15);
}

TEST(SurfaceBound, OfTheSameFlatSurfaceIsNearlyNothing)
{
  const Mesh plate = GridPlate(20);
  Box box;
  std::for_each(plate.points.begin(), plate.points.end(), [&](const Vec3& p) { box.Add(p); });
  const double side = box.hi[0] - box.lo[0];
  Mesh turned = plate;
  for (std::size_t t = 0; t + 1 < turned.triangles.size(); t += 2)
  {
    std::reverse(turned.triangles[t].begin(), turned.triangles[t].end());
  }
  EXPECT_LE(BoundOf(plate, turned), 1e-9 * side);
  const Mesh coarse{ { box.lo, { box.hi[0], box.lo[1], box.lo[2] }, box.hi,
                       { box.lo[0], box.hi[1], box.lo[2] } },
    { { 0, 1, 2 }, { 0, 2, 3 } } };
  EXPECT_LE(BoundOf(plate, coarse), side / 200);
}

TEST(SurfaceBound, FindsTheNearestTriangle)
{
  const Mesh sphere = DisplacedSphere(3);
  const SearchedPart part = WholeOf(sphere);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> unit(-2, 2);
  for (unsigned i = 0; i < 300; ++i)
  {
    const Vec3 place{ unit(random), unit(random), unit(random) };
    double squared = INFINITY;
    const std::uint32_t found = part.Nearest(place, 0, squared);
    EXPECT_EQ(std::sqrt(squared), BruteDistance(sphere, place));
    EXPECT_EQ(part.SquaredTo(found, place), squared);
    EXPECT_EQ(part.Nearest(place, 0, squared), SearchedPart::none) << "none is nearer";
  }
}

TEST(SurfaceBound, BallsHoldTheirTriangles)
{
  const Mesh soup = Soup(300, 4);
  std::vector<Vec3> centres(7, { 9, 9, 9 });
  std::vector<std::int32_t> ballOf; // nothing is in 0, 2 and 4
  for (VertexId v = 0; v < soup.points.size(); ++v)
  {
    ballOf.push_back(std::vector<std::int32_t>{ -1, 1, 3, 5, 6, 1000 }[v * v % 11 % 6]);
    centres[v % 3 * 2 + 1] = soup.points[v];
  }
  MeasuredPart part(soup.points, soup.triangles, ballOf, centres);
  ASSERT_EQ(part.Levels().size(), 3U);
  EXPECT_EQ(part.Levels()[1].size(), 2U);
  ASSERT_EQ(part.Levels()[2].size(), 1U);
  EXPECT_EQ(part.GroupOf(1, 1), (std::pair<std::size_t, std::size_t>(4, 7)));
  std::multiset<Triangle> found, expected;
  for (std::size_t i = 0; i < centres.size(); ++i)
  {
    EXPECT_EQ(part.TrianglesOf(i).empty(), part.Levels()[0][i].radius < 0);
    for (const Triangle& t : part.TrianglesOf(i))
    {
      found.insert(t);
      EXPECT_EQ(std::min({ ballOf[t[0]], ballOf[t[1]], ballOf[t[2]] }), std::int32_t(i));
      std::size_t ball = i;
      for (const std::vector<MeasuredPart::Ball>& level : part.Levels())
      {
        for (const VertexId v : t)
        {
          EXPECT_LE(std::sqrt(SquaredDistance(part.At(v), level[ball].centre)), level[ball].radius);
        }
        ball /= 4;
      }
    }
  }
  for (const Triangle& t : soup.triangles)
  {
    if (std::min({ ballOf[t[0]], ballOf[t[1]], ballOf[t[2]] }) >= 0)
    {
      expected.insert(t);
    }
  }
  EXPECT_GT(expected.size(), 100U);
  EXPECT_EQ(found, expected);
}

TEST(SurfaceBound, CountsWhatTheOtherSurfaceLacks)
{
  const Mesh sphere = DisplacedSphere(4);
  const Mesh both = Both(sphere, DisplacedSphere(2, { 10, 0, 0 }, 0.1));
  const double sampled = SampledDistance(both, sphere, 5000);
  EXPECT_GT(sampled, 8);
  for (const double bound : { BoundOf(both, sphere), BoundOfParts(both, sphere, 50, 1) })
  {
    EXPECT_GE(bound, sampled);
    EXPECT_LE(bound, 1.16 * sampled);
  }
  EXPECT_LE(BoundOf(sphere, both), 1e-9) << "one way alone";
}

TEST(SurfaceBound, LooksBetweenTheCorners)
{
  // All corners of the square are on the valley; its middle is not.
  const Mesh valley{ { { 0, 0, 0 }, { 2, 0, 0 }, { 2, 2, 0 }, { 0, 2, 0 }, { 1, 1, -1 } },
    { { 0, 1, 4 }, { 1, 2, 4 }, { 2, 3, 4 }, { 3, 0, 4 } } };
  const double sampled = SampledDistance(Square(0), valley, 5000);
  EXPECT_GT(sampled, 0.6);
  EXPECT_GE(BoundOf(Square(0), valley), sampled);
  EXPECT_LE(BoundOf(Square(0), valley), 1.3 * sampled);
}

TEST(SurfaceBound, IsNeverBelowWhatSamplesFind)
{
  for (const NamedMesh& named : MeshesToCollapse())
  {
    const BuiltLevels built = BuildAllLevels(named.mesh);
    const double size = Length(Minus(built.tree.boxes[1].hi, built.tree.boxes[1].lo)) +
                        Length(built.tree.boxes[1].hi); // what is rounded
    for (std::size_t depth = 0; depth < built.levels.levels.size(); depth += 3)
    {
      SCOPED_TRACE(named.name + ", level " + std::to_string(depth));
      const ClusterLevel& level = built.levels.levels[depth];
      const Mesh coarse{ level.positions, level.triangles };
      const double sampled = SampledDistance(named.mesh, coarse, 60);
      const double spacing = WholeOf(coarse).Spacing();
      EXPECT_GE(BoundOf(named.mesh, coarse), sampled * (1 - 1e-9) - 1e-14 * size);
      EXPECT_GE(BoundOfParts(named.mesh, coarse, 500, 1, spacing / 2, LargestDeviation(level)),
        sampled * (1 - 1e-9) - 1e-14 * size);
    }
  }
}

TEST(SurfaceBound, IsNotMuchMoreThanTheDistance)
{
  for (const NamedMesh& named : ClosedMeshes())
  {
    const BuiltLevels built = BuildAllLevels(named.mesh);
    for (std::size_t depth = 4; depth < built.levels.levels.size(); depth += 3)
    {
      SCOPED_TRACE(named.name + ", level " + std::to_string(depth));
      const ClusterLevel& level = built.levels.levels[depth];
      const Mesh coarse{ level.positions, level.triangles };
      const double sampled = SampledDistance(named.mesh, coarse, 10000);
      const double smallest = 0.5 * WholeOf(coarse).Spacing();
      EXPECT_LE(BoundOf(named.mesh, coarse), 2 * sampled);
      EXPECT_LE(BoundOf(named.mesh, coarse, 0, smallest), std::max(2 * sampled, 2 * smallest));
    }
  }
}

// Also where what is symmetric is equally far.
TEST(SurfaceBound, IsTheSameInAnyOrderOfParts)
{
  const Mesh fine = DisplacedSphere(5), coarse = DisplacedSphere(3);
  const Mesh torus = Torus(60, 30), rough = Torus(12, 6), plate = GridPlate(64);
  const auto check = [](const Mesh& one, const Mesh& other, double smallest)
  {
    const double bound = BoundOfParts(one, other, 100, 0, smallest);
    for (unsigned seed = 1; seed < 6; ++seed)
    {
      EXPECT_EQ(BoundOfParts(one, other, 100, seed, smallest), bound);
    }
    return bound;
  };
  for (const double smallest : { 0.0, 0.05 })
  {
    check(fine, coarse, smallest);
    check(torus, rough, smallest);
    check(plate, GridPlate(16), smallest);
    const double far = check(Both(fine, DisplacedSphere(2, { 4, 0, 0 }, 0.3)), coarse, smallest);
    EXPECT_EQ(BoundOfParts(fine, coarse, 100, 1, smallest, far), far) << "if that is more";
  }
}

TEST(SurfaceBound, OfPointsIsThatOfTheFarthest)
{
  const Mesh cloud = Cloud(3);
  Mesh half = cloud;
  half.points.resize(cloud.points.size() / 2);
  double farthest = 0;
  for (const Vec3& p : cloud.points)
  {
    farthest = std::max(farthest, BruteDistance(half, p));
  }
  EXPECT_GE(BoundOfParts(cloud, half, 40, 2), farthest);
  EXPECT_LE(BoundOfParts(cloud, half, 40, 2), farthest * (1 + 1e-9));
}

TEST(SurfaceBound, OfNothingIsNothingAndErrorsEndIt)
{
  EXPECT_EQ(BoundOf(Mesh{}, Square(0)), 0);
  const SearchedPart nothing = WholeOf({});
  const auto stop = [](const Vec3&, double&) {
    return Status(Error{ ErrorCode::InputOutput, "cannot be read" });
  };
  const Result<double> stopped = Farthest(Square(0), Square(0).triangles, { nothing, stop }, 0);
  EXPECT_EQ(stopped.GetError().code, ErrorCode::InputOutput);
}
