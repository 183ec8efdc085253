// SPDX-License-Identifier: BSD-3-Clause
// Octree clustering compared with a recursion on exact numbers, and properties that hold for any
// input.
#include "Testing/Fixtures/ErrorAt.h"
#include "Testing/Fixtures/Meshes.h"
#include "filters/baselines/OctreeClustering.h"
#include "filters/baselines/Testing/ClusterSizes.h"
#include "filters/core/Weld.h"
#include "filters/program/TbbExecution.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <random>

using namespace kdstream;
using namespace kdstream::fixtures;

namespace
{

std::vector<Box> BoxesOf(const std::vector<Vec3>& points, const Clustering& clustering)
{
  std::vector<Box> boxes(clustering.clusters);
  for (std::size_t v = 0; v < points.size(); ++v)
  {
    boxes[clustering.clusterOf[v]].Add(points[v]);
  }
  return boxes;
}

double SideOf(const std::vector<Vec3>& points)
{
  const Box box = BoxOfPoints(points);
  return std::max({ box.hi[0] - box.lo[0], box.hi[1] - box.lo[1], box.hi[2] - box.lo[2] });
}

// Points with integer coordinates in a cube of side 2^exponent, which include both ends; many
// places occur twice. Halves are exact.
std::vector<Vec3> Lattice(std::size_t count, unsigned exponent, std::uint32_t seed)
{
  std::mt19937 random(seed);
  const double side = std::ldexp(1, int(exponent));
  std::vector<Vec3> points{ { 0, 0, 0 }, { side, side, side } };
  while (points.size() < count)
  {
    Vec3 p{};
    for (double& x : p)
    {
      // Denser towards 0, so that leaves have different depths.
      const double unit = double(random() >> 8) / double(1 << 24);
      x = std::floor(unit * unit * side);
    }
    points.push_back(p);
    if (random() % 4 == 0)
    {
      points.push_back(p);
    }
  }
  return points;
}

// The leaves as the paper describes them: a cell [lo, lo + side) of more than `most` vertices is
// split at its centre.
void SplitPlainly(const std::vector<Vec3>& points, const std::vector<VertexId>& cell,
  const Vec3& lo, double side, unsigned depth, std::uint32_t most, Clustering& clustering)
{
  if (cell.empty())
  {
    return;
  }
  if (cell.size() <= most || depth == octreeDeepest)
  {
    for (const VertexId v : cell)
    {
      clustering.clusterOf[v] = clustering.clusters;
    }
    ++clustering.clusters;
    return;
  }
  for (unsigned child = 0; child < 8; ++child)
  {
    Vec3 corner = lo;
    for (unsigned k = 0; k < 3; ++k)
    {
      corner[k] += (child >> k & 1) != 0 ? side / 2 : 0;
    }
    std::vector<VertexId> inside;
    for (const VertexId v : cell)
    {
      bool in = true;
      for (std::size_t k = 0; k < 3; ++k)
      {
        in = in && (points[v][k] >= lo[k] + side / 2) == (corner[k] > lo[k]);
      }
      if (in)
      {
        inside.push_back(v);
      }
    }
    SplitPlainly(points, inside, corner, side / 2, depth + 1, most, clustering);
  }
}

}

TEST(OctreeClustering, IsTheRecursionOnEightEqualCubes)
{
  for (const std::uint32_t seed : { 1U, 2U, 3U })
  {
    const std::vector<Vec3> points = Lattice(1500, 10, seed);
    std::vector<VertexId> all(points.size());
    std::iota(all.begin(), all.end(), VertexId{ 0 });
    for (const std::uint32_t most : { 1U, 2U, 5U, 40U, 700U, 5000U })
    {
      SCOPED_TRACE(std::to_string(seed) + ", " + std::to_string(most));
      Clustering expected;
      expected.clusterOf.resize(points.size());
      SplitPlainly(points, all, { 0, 0, 0 }, 1024, 0, most, expected);
      const auto found = ClusterByOctree(points, { most, {} });
      ASSERT_TRUE(found);
      EXPECT_EQ(found->clusters, expected.clusters);
      EXPECT_EQ(found->clusterOf, expected.clusterOf);
      EXPECT_EQ(found->verticesPerPartition, most);
    }
  }
}

TEST(OctreeClustering, TheRootIsTheCubeAroundTheCentreOfTheBox)
{
  // A box of 8 × 2 × 1. Cubes of side 4 cut x at 4, and y and z through the middle.
  const std::vector<Vec3> points{ { 0, 0, 0 }, { 8, 2, 1 }, { 3, 0.9, 0.4 }, { 4, 1, 0.5 },
    { 3, 1, 0.4 }, { 3, 0.9, 0.5 } };
  const auto found = ClusterByOctree(points, { 2, {} });
  ASSERT_TRUE(found);
  EXPECT_EQ(found->clusterOf, (std::vector<std::uint32_t>{ 0, 3, 0, 3, 1, 2 }));
  EXPECT_EQ(found->depth, 1U);
}

TEST(OctreeClustering, ClustersAreSmallFullAndApart)
{
  for (const NamedMesh& named : AllMeshes())
  {
    const std::vector<Vec3>& points = named.mesh.points;
    for (const std::uint32_t most : { 1U, 7U, 100U, 2000U })
    {
      SCOPED_TRACE(named.name + ", " + std::to_string(most));
      const auto found = ClusterByOctree(points, { most, {} });
      ASSERT_TRUE(found);
      ASSERT_EQ(found->clusterOf.size(), points.size());
      const std::vector<std::uint32_t> sizes = SizesOf(*found);
      const std::vector<Box> boxes = BoxesOf(points, *found);
      const double side = SideOf(points), deepest = std::ldexp(side, -int(octreeDeepest));
      for (std::size_t c = 0; c < sizes.size(); ++c)
      {
        ASSERT_GT(sizes[c], 0U);
        if (sizes[c] > most)
        {
          ASSERT_LE(SideOf({ boxes[c].lo, boxes[c].hi }), deepest * 1.001);
        }
      }
      for (std::size_t a = 0; a < std::min<std::size_t>(boxes.size(), 300); ++a)
      {
        for (std::size_t b = a + 1; b < std::min<std::size_t>(boxes.size(), 300); ++b)
        {
          bool apart = false;
          for (std::size_t k = 0; k < 3; ++k)
          {
            const double rounding = 1e-9 * side;
            apart = apart || boxes[a].hi[k] < boxes[b].lo[k] + rounding ||
                    boxes[b].hi[k] < boxes[a].lo[k] + rounding;
          }
          ASSERT_TRUE(apart) << "clusters " << a << " and " << b << " overlap";
        }
      }
    }
  }
}

TEST(OctreeClustering, VerticesInOnePlaceStayTogether)
{
  std::vector<Vec3> points(1000, { 1, 2, 3 });
  const auto one = ClusterByOctree(points, { 1, {} });
  ASSERT_TRUE(one);
  EXPECT_EQ(one->clusters, 1U);
  EXPECT_EQ(one->depth, octreeDeepest);
  points.push_back({ 1, 2, 4 });
  points.push_back({ 1, 2, 4 });
  const auto two = ClusterByOctree(points, { 1, {} });
  ASSERT_TRUE(two);
  EXPECT_EQ(SizesOf(*two), (std::vector<std::uint32_t>{ 1000, 2 }));
  EXPECT_EQ(ClusterByOctree(points, { 1, 500U })->clusters, 2U);
}

TEST(OctreeClustering, SearchFindsTheNearestNumberOfAllN)
{
  std::vector<NamedMesh> meshes{ { "lattice", { Lattice(400, 8, 5), {} } },
    { "sphere", DisplacedSphere(3) }, { "plate", GridPlate(12) },
    { "two", { { { 0, 0, 0 }, { 1, 0, 0 } }, {} } } };
  for (const NamedMesh& named : meshes)
  {
    const std::vector<Vec3>& points = named.mesh.points;
    const auto n = static_cast<std::uint32_t>(points.size());
    std::vector<std::uint32_t> counts; // for every N
    for (std::uint32_t most = 1; most <= n; ++most)
    {
      counts.push_back(ClusterByOctree(points, { most, {} })->clusters);
    }
    for (std::uint32_t wanted = 1; wanted <= n; wanted += 1 + wanted / 20)
    {
      SCOPED_TRACE(named.name + ", " + std::to_string(wanted));
      std::uint32_t nearest = counts.back();
      for (const std::uint32_t count : counts)
      {
        const auto distance = [&](std::uint32_t c) { return c > wanted ? c - wanted : wanted - c; };
        if (distance(count) < distance(nearest) ||
            (distance(count) == distance(nearest) && count < nearest))
        {
          nearest = count;
        }
      }
      const auto found = ClusterByOctree(points, { 2000, wanted });
      ASSERT_TRUE(found);
      EXPECT_EQ(found->clusters, nearest);
      const auto again = ClusterByOctree(points, { found->verticesPerPartition, {} });
      EXPECT_EQ(again->clusterOf, found->clusterOf);
    }
  }
}

TEST(OctreeClustering, IsTheSameOnAnyNumberOfThreads)
{
  for (const NamedMesh& named : AllMeshes())
  {
    SCOPED_TRACE(named.name);
    for (const OctreeOptions& options : { OctreeOptions{ 9, {} }, OctreeOptions{ 1, 1U } })
    {
      const auto serial = ClusterByOctree(named.mesh.points, options);
      for (const unsigned threads : { 1U, 2U, 8U })
      {
        const auto parallel =
          ClusterByOctree(named.mesh.points, options, MakeTbbExecution(threads));
        EXPECT_EQ(serial->clusterOf, parallel->clusterOf);
      }
    }
  }
}

TEST(OctreeClustering, SaysWhatIsWrong)
{
  const auto isRefused = [](const std::vector<Vec3>& points, const OctreeOptions& options,
                           ErrorCode code, std::string_view what)
  { return fixtures::FailsAt(ClusterByOctree(points, options), code, what); };
  constexpr ErrorCode wrong = ErrorCode::InvalidArgument;
  const std::vector<Vec3> two{ { 0, 0, 0 }, { 1, 0, 0 } };
  EXPECT_TRUE(isRefused({}, {}, wrong, "no vertices"));
  EXPECT_TRUE(isRefused(two, { 0, {} }, wrong, "vertices per partition"));
  EXPECT_TRUE(isRefused(two, { 1, 0U }, wrong, "number of partitions"));
  EXPECT_TRUE(isRefused(two, { 1, 3U }, wrong, "partitions 3"));
  EXPECT_TRUE(
    isRefused({ { 0, -1e308, 0 }, { 0, 1e308, 0 } }, {}, ErrorCode::InvalidInput, "along y,"));
}

TEST(OctreeClustering, StopsWhenCancelled)
{
  for (const int calls : { 0, 1 })
  {
    for (const OctreeOptions& options : { OctreeOptions{ 9, {} }, OctreeOptions{ 1, 50U } })
    {
      int left = calls;
      Execution execution;
      execution.progress = [&](std::string_view, double) { return left-- > 0; };
      const auto found = ClusterByOctree(Torus(40, 40).points, options, execution);
      ASSERT_FALSE(found);
      EXPECT_EQ(found.GetError().code, ErrorCode::Cancelled);
    }
  }
}
