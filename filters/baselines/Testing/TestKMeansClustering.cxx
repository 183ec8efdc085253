// SPDX-License-Identifier: BSD-3-Clause
// K-means clustering: the number, content and spread of clusters; and the parts of the algorithm.
#include "Testing/Fixtures/ErrorAt.h"
#include "Testing/Fixtures/Meshes.h"
#include "filters/baselines/FaceClustering.h"
#include "filters/baselines/KMeansClustering.h"
#include "filters/baselines/Testing/ClusterSizes.h"
#include "filters/core/NearestPoint.h"
#include "filters/core/Weld.h"
#include "filters/core/tree/PartitionMeasures.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <random>
#include <set>

using namespace kdstream;
using namespace kdstream::fixtures;

namespace
{

Result<Clustering> Cluster(const Mesh& mesh, std::uint32_t partitions, KMeansOptions options = {})
{
  options.partitions = partitions;
  return ClusterByKMeans(mesh.points, mesh.triangles, options);
}

// How many connected parts each label has; links join elements with the same label.
template <class Links>
std::map<std::uint32_t, int> PartsOf(const std::vector<std::uint32_t>& labels, const Links& links)
{
  std::vector<std::size_t> root(labels.size());
  std::iota(root.begin(), root.end(), std::size_t{ 0 });
  const auto find = [&](std::size_t i)
  {
    while (root[i] != i)
    {
      i = root[i] = root[root[i]];
    }
    return i;
  };
  for (const auto& [a, b] : links)
  {
    if (labels[a] == labels[b])
    {
      root[find(a)] = find(b);
    }
  }
  std::map<std::uint32_t, int> parts;
  for (std::size_t i = 0; i < labels.size(); ++i)
  {
    parts[labels[i]] += find(i) == i;
  }
  return parts;
}

using Links = std::vector<std::pair<std::size_t, std::size_t>>;

Links EdgesOf(const Mesh& mesh)
{
  Links edges;
  for (const Triangle& t : mesh.triangles)
  {
    edges.insert(edges.end(), { { t[0], t[1] }, { t[1], t[2] }, { t[2], t[0] } });
  }
  return edges;
}

Links NeighboursOf(const Mesh& mesh)
{
  std::map<std::pair<VertexId, VertexId>, std::vector<std::size_t>> of;
  Links neighbours;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
  {
    for (std::size_t k = 0; k < 3; ++k)
    {
      const std::pair<VertexId, VertexId> edge =
        std::minmax(mesh.triangles[i][k], mesh.triangles[i][(k + 1) % 3]);
      for (const std::size_t other : of[edge])
      {
        neighbours.emplace_back(other, i);
      }
      of[edge].push_back(i);
    }
  }
  return neighbours;
}

// A plate with a long triangle at each edge of its rim. Such a triangle is never a good pair: the
// plate becomes one cluster long before they join it, one in each round.
Mesh Star(unsigned side)
{
  Mesh mesh = GridPlate(side);
  std::map<std::pair<VertexId, VertexId>, int> uses;
  for (const Triangle& t : mesh.triangles)
  {
    for (std::size_t k = 0; k < 3; ++k)
    {
      ++uses[std::minmax(t[k], t[(k + 1) % 3])];
    }
  }
  for (const auto& [edge, count] : uses)
  {
    if (count == 1)
    {
      mesh.triangles.push_back(
        { edge.first, edge.second, static_cast<VertexId>(mesh.points.size()) });
      mesh.points.push_back({ mesh.points[edge.first][0], mesh.points[edge.first][1], 1e3 });
    }
  }
  return mesh;
}

}

TEST(KMeansClustering, ExactlyKNoneEmptyNumberedByFirstVertices)
{
  for (const NamedMesh& named : AllMeshes())
  {
    const auto n = static_cast<std::uint32_t>(named.mesh.points.size());
    for (const std::uint32_t k : { 1U, 2U, 3U, 7U, 60U, n / 2, n - 1, n })
    {
      if (k == 0 || k > n || (k > 60 && n > 4000))
      {
        continue;
      }
      SCOPED_TRACE(named.name + ", " + std::to_string(k));
      const auto found = Cluster(named.mesh, k);
      ASSERT_TRUE(found) << found.GetError().message;
      ASSERT_EQ(found->clusterOf.size(), n);
      EXPECT_EQ(found->clusters, k);
      const std::vector<std::uint32_t> sizes = SizesOf(*found);
      EXPECT_EQ(std::count(sizes.begin(), sizes.end(), 0U), 0);
      std::uint32_t next = 0;
      for (const std::uint32_t c : found->clusterOf)
      {
        ASSERT_LE(c, next);
        next += c == next;
      }
      EXPECT_EQ(Cluster(named.mesh, k)->clusterOf, found->clusterOf);
    }
  }
}

TEST(KMeansClustering, KFollowsFromVerticesPerPartition)
{
  const Mesh mesh = Torus(20, 10);
  for (const std::uint32_t most : { 1U, 3U, 66U, 67U, 199U, 200U, 201U, 100000U })
  {
    KMeansOptions options;
    options.verticesPerPartition = most;
    EXPECT_EQ(
      ClusterByKMeans(mesh.points, mesh.triangles, options)->clusters, (200 + most - 1) / most);
  }
}

TEST(KMeansClustering, ClustersOfAConnectedSurfaceAreConnectedAndOfLikeSize)
{
  for (const NamedMesh& named : ClosedMeshes())
  {
    if (named.name == "nested spheres")
    {
      continue;
    }
    for (const std::uint32_t k : { 2U, 16U, 50U })
    {
      SCOPED_TRACE(named.name + ", " + std::to_string(k));
      const auto found = Cluster(named.mesh, k);
      ASSERT_TRUE(found);
      for (const auto& [cluster, parts] : PartsOf(found->clusterOf, EdgesOf(named.mesh)))
      {
        EXPECT_EQ(parts, 1) << "cluster " << cluster;
      }
      const std::vector<std::uint32_t> sizes = SizesOf(*found);
      const double mean = double(named.mesh.points.size()) / k;
      EXPECT_LT(*std::max_element(sizes.begin(), sizes.end()), 2 * mean);
      EXPECT_GT(*std::min_element(sizes.begin(), sizes.end()), mean / 3);
    }
  }
}

TEST(KMeansClustering, EachPartOfTheCostDoesItsWork)
{
  const auto with = [&](
                      const Mesh& mesh, double compactness, double count, std::uint32_t iterations)
  {
    KMeansOptions options;
    options.compactnessWeight = compactness;
    options.countWeight = count;
    options.iterations = iterations;
    return MeasurePartitions(mesh.points, mesh.triangles, *Cluster(mesh, 64, options));
  };
  // A plate that gets denser towards one side, so that equal areas do not have equal counts.
  Mesh plate = GridPlate(70);
  for (Vec3& p : plate.points)
  {
    p[0] = p[0] * p[0] / 70;
  }
  EXPECT_LT(with(plate, 4, 1, 5)->vertices.standardDeviation,
    0.8 * with(plate, 4, 0, 5)->vertices.standardDeviation);
  const Mesh torus = Torus(160, 60);
  EXPECT_LT(with(torus, 4, 1, 5)->compactness.mean, with(torus, 0, 1, 5)->compactness.mean - 0.02);
  EXPECT_LT(with(torus, 4, 1, 5)->compactness.mean, with(torus, 4, 1, 1)->compactness.mean - 0.02);
}

// Distance is measured along the surface: with two plates that nearly touch, each cluster is on one
// plate.
TEST(KMeansClustering, DistanceIsAlongEdges)
{
  Mesh mesh = GridPlate(20);
  const auto vertices = static_cast<VertexId>(mesh.points.size());
  const std::vector<Triangle> triangles = mesh.triangles;
  for (VertexId v = 0; v < vertices; ++v)
  {
    mesh.points.push_back({ mesh.points[v][0], mesh.points[v][1], mesh.points[v][2] + 1e-3 });
  }
  for (const Triangle& t : triangles)
  {
    mesh.triangles.push_back({ t[0] + vertices, t[1] + vertices, t[2] + vertices });
  }
  const auto found = Cluster(mesh, 12);
  std::set<std::uint32_t> lower, upper;
  for (VertexId v = 0; v < vertices; ++v)
  {
    lower.insert(found->clusterOf[v]);
    upper.insert(found->clusterOf[v + vertices]);
  }
  EXPECT_EQ(lower.size() + upper.size(), 12U);
  EXPECT_EQ(lower.size(), 6U);
}

TEST(KMeansClustering, UnitsAndOffsetsDoNotCount)
{
  const Mesh mesh = DisplacedSphere(3);
  const auto expected = Cluster(mesh, 20);
  for (const double unit : { 1024.0, 0x1p-900, 0x1p120 })
  {
    Mesh other = mesh;
    for (Vec3& p : other.points)
    {
      p = { unit * p[0], unit * p[1], unit * p[2] };
    }
    EXPECT_EQ(Cluster(other, 20)->clusterOf, expected->clusterOf) << unit;
  }
}

TEST(KMeansClustering, WhatNoSeedReachesGoesToTheSeedNearestInSpace)
{
  // Three triangles along x for two seeds, and vertices that no triangle uses.
  Mesh mesh;
  for (const double x : { 0.0, 90.0, 190.0 })
  {
    const auto first = static_cast<VertexId>(mesh.points.size());
    mesh.points.insert(mesh.points.end(), { { x, 0, 0 }, { x + 1, 0, 0 }, { x, 1, 0 } });
    mesh.triangles.push_back({ first, first + 1, first + 2 });
  }
  mesh.triangles.push_back({ 0, 2, 1 }); // now the fullest two are at 0 and
  mesh.triangles.push_back({ 6, 7, 8 }); // at 190
  KMeansOptions once;
  once.iterations = 1;
  EXPECT_EQ(
    Cluster(mesh, 2, once)->clusterOf, (std::vector<std::uint32_t>{ 0, 0, 0, 0, 0, 0, 1, 1, 1 }));
  mesh.points.push_back({ 60, 0, 0 });
  mesh.points.push_back({ 400, 0, 0 });
  EXPECT_EQ(Cluster(mesh, 2, once)->clusterOf,
    (std::vector<std::uint32_t>{ 0, 0, 0, 0, 0, 0, 1, 1, 1, 0, 1 }));
}

// With only the distance in the cost, and after enough iterations that nothing moves, clusters are
// the geodesic Voronoi cells of their centres.
TEST(KMeansClustering, CellsOfTheNearestCentreAlongEdges)
{
  const Mesh mesh = DisplacedSphere(3);
  KMeansOptions options;
  options.iterations = 60;
  options.compactnessWeight = options.countWeight = 0;
  const auto found = Cluster(mesh, 6, options);
  std::vector<Vec3> mean(6, Vec3{});
  const std::vector<std::uint32_t> sizes = SizesOf(*found);
  for (std::size_t v = 0; v < mesh.points.size(); ++v)
  {
    for (std::size_t k = 0; k < 3; ++k)
    {
      mean[found->clusterOf[v]][k] += mesh.points[v][k] / sizes[found->clusterOf[v]];
    }
  }
  const auto length = [](const Vec3& a, const Vec3& b)
  { return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]); };
  std::vector<std::vector<double>> distance; // from each centre, found by relaxing all edges
  for (std::uint32_t c = 0; c < 6; ++c)
  {
    std::size_t centre = 0;
    double nearest = HUGE_VAL;
    for (std::size_t v = 0; v < mesh.points.size(); ++v)
    {
      if (found->clusterOf[v] == c && length(mesh.points[v], mean[c]) < nearest)
      {
        nearest = length(mesh.points[v], mean[c]);
        centre = v;
      }
    }
    distance.emplace_back(mesh.points.size(), HUGE_VAL);
    distance.back()[centre] = 0;
    for (bool changed = true; changed;)
    {
      changed = false;
      for (const auto& [a, b] : EdgesOf(mesh))
      {
        for (const auto& [from, to] : { std::pair{ a, b }, std::pair{ b, a } })
        {
          const double way = distance.back()[from] + length(mesh.points[from], mesh.points[to]);
          if (way < distance.back()[to])
          {
            distance.back()[to] = way;
            changed = true;
          }
        }
      }
    }
  }
  for (std::size_t v = 0; v < mesh.points.size(); ++v)
  {
    double least = HUGE_VAL;
    for (const std::vector<double>& of : distance)
    {
      least = std::min(least, of[v]);
    }
    ASSERT_LE(distance[found->clusterOf[v]][v], least + 1e-9) << "vertex " << v;
  }
}

TEST(KMeansClustering, SmallFragmentsGetNoSeeds)
{
  Mesh mesh = DisplacedSphere(4);
  for (unsigned i = 0; i < 60; ++i)
  {
    const auto a = static_cast<VertexId>(mesh.points.size());
    const double x = 0.01 * i;
    mesh.points.insert(
      mesh.points.end(), { { x, 0, 0 }, { x + 0.005, 0, 0 }, { x, 0.005, 0 }, { x, 0, 0.005 } });
    mesh.triangles.insert(mesh.triangles.end(),
      { { a, a + 2, a + 1 }, { a, a + 1, a + 3 }, { a, a + 3, a + 2 }, { a + 1, a + 2, a + 3 } });
  }
  const std::vector<std::uint32_t> sizes = SizesOf(*Cluster(mesh, 16));
  EXPECT_LT(*std::max_element(sizes.begin(), sizes.end()), 2 * mesh.points.size() / 16);
  EXPECT_GT(*std::min_element(sizes.begin(), sizes.end()), mesh.points.size() / 16 / 3);
}

TEST(KMeansClustering, ACloudIsClusteredInSpace)
{
  // Eight heaps of points at the corners of a cube: k-means must find them.
  std::mt19937 random(4);
  Mesh mesh;
  for (int i = 0; i < 800; ++i)
  {
    Vec3 p{ double(i & 1), double(i >> 1 & 1), double(i >> 2 & 1) };
    for (double& x : p)
    {
      x += 0.2 * double(random() >> 8) / double(1 << 24);
    }
    mesh.points.push_back(p);
  }
  const auto found = Cluster(mesh, 8);
  for (std::size_t i = 8; i < mesh.points.size(); ++i)
  {
    ASSERT_EQ(found->clusterOf[i], found->clusterOf[i % 8]);
  }
  EXPECT_EQ(SizesOf(*found), std::vector<std::uint32_t>(8, 100));
}

TEST(KMeansClustering, RepeatedVerticesDoNotCutTheSurface)
{
  // Every triangle has vertices of its own: the clusters must be those of the welded surface.
  const Mesh welded = DisplacedSphere(3);
  Mesh soup;
  for (const Triangle& t : welded.triangles)
  {
    const auto first = static_cast<VertexId>(soup.points.size());
    soup.points.insert(
      soup.points.end(), { welded.points[t[0]], welded.points[t[1]], welded.points[t[2]] });
    soup.triangles.push_back({ first, first + 1, first + 2 });
  }
  const auto found = Cluster(soup, 12);
  const std::vector<VertexId> place = FirstCoincident(soup.points, Coincidence::BitEqual);
  std::size_t apart = 0;
  for (VertexId v = 0; v < place.size(); ++v)
  {
    apart += found->clusterOf[v] != found->clusterOf[place[v]];
  }
  EXPECT_LT(double(apart), 0.02 * double(place.size()));
  Links links = EdgesOf(soup);
  for (VertexId v = 0; v < place.size(); ++v)
  {
    links.emplace_back(v, place[v]);
  }
  std::map<std::uint32_t, int> parts = PartsOf(found->clusterOf, links);
  EXPECT_EQ(parts.size(), 12U);
}

TEST(KMeansClustering, SaysWhatIsWrong)
{
  const Mesh two{ { { 0, 0, 0 }, { 1, 0, 0 } }, {} };
  const auto isRefused =
    [](const Mesh& mesh, const KMeansOptions& options, ErrorCode code, std::string_view what)
  { return fixtures::FailsAt(ClusterByKMeans(mesh.points, mesh.triangles, options), code, what); };
  constexpr ErrorCode wrong = ErrorCode::InvalidArgument;
  EXPECT_TRUE(isRefused({}, {}, wrong, "no vertices"));
  KMeansOptions options;
  options.verticesPerPartition = 0;
  EXPECT_TRUE(isRefused(two, options, wrong, "vertices per partition"));
  options.partitions = 0;
  EXPECT_TRUE(isRefused(two, options, wrong, "number of partitions"));
  options.partitions = 3;
  EXPECT_TRUE(isRefused(two, options, wrong, "partitions 3"));
  options.partitions = 2;
  options.iterations = 0;
  EXPECT_TRUE(isRefused(two, options, wrong, "iterations"));
  options.iterations = 1;
  for (const double bad : { -1.0, std::nan(""), HUGE_VAL })
  {
    for (double KMeansOptions::*weight : { &KMeansOptions::distanceWeight,
           &KMeansOptions::compactnessWeight, &KMeansOptions::countWeight })
    {
      KMeansOptions weights = options;
      weights.*weight = bad;
      EXPECT_TRUE(isRefused(two, weights, wrong, "weights"));
    }
  }
  options.distanceWeight = 0;
  EXPECT_TRUE(isRefused(two, options, wrong, "distance"));
  EXPECT_TRUE(isRefused(
    { { { 0, 0, -1e308 }, { 0, 0, 1e308 } }, {} }, {}, ErrorCode::InvalidInput, "along z,"));
}

TEST(KMeansClustering, StopsWhenCancelled)
{
  const Mesh mesh = Torus(30, 20);
  int calls = 0;
  Execution execution;
  execution.progress = [&](std::string_view, double)
  {
    ++calls;
    return true;
  };
  KMeansOptions options;
  options.partitions = 7;
  ASSERT_TRUE(ClusterByKMeans(mesh.points, mesh.triangles, options, execution));
  const int all = calls;
  EXPECT_GT(all, 6);
  for (int stop = 0; stop < all; ++stop)
  {
    int left = stop;
    execution.progress = [&](std::string_view, double) { return left-- > 0; };
    const auto found = ClusterByKMeans(mesh.points, mesh.triangles, options, execution);
    ASSERT_FALSE(found);
    EXPECT_EQ(found.GetError().code, ErrorCode::Cancelled);
  }
}

TEST(FaceClustering, AsManyAsWantedEachConnected)
{
  for (const NamedMesh& named : AllMeshes())
  {
    if (named.mesh.triangles.empty())
    {
      continue;
    }
    const Links neighbours = NeighboursOf(named.mesh);
    const std::vector<std::uint32_t> one(named.mesh.triangles.size(), 0);
    const auto components = static_cast<std::uint32_t>(PartsOf(one, neighbours).begin()->second);
    const auto faces = static_cast<std::uint32_t>(named.mesh.triangles.size());
    for (const std::uint32_t wanted : { 0U, 1U, 5U, 100U, faces, faces + 1 })
    {
      SCOPED_TRACE(named.name + ", " + std::to_string(wanted));
      const auto found = ClusterFaces(named.mesh.points, named.mesh.triangles, wanted);
      ASSERT_TRUE(found);
      EXPECT_EQ(found->clusters, std::min(faces, std::max({ wanted, components, 1U })));
      const auto parts = PartsOf(found->clusterOf, neighbours);
      EXPECT_EQ(parts.size(), found->clusters);
      for (const auto& [cluster, count] : parts)
      {
        ASSERT_EQ(count, 1) << "cluster " << cluster;
      }
      std::uint32_t next = 0;
      for (const std::uint32_t c : found->clusterOf)
      {
        ASSERT_LE(c, next);
        next += c == next;
      }
    }
  }
}

TEST(FaceClustering, ClustersAreOfLikeSizeAndCompact)
{
  const Mesh mesh = Torus(96, 48);
  const auto found = ClusterFaces(mesh.points, mesh.triangles, 40);
  std::vector<std::uint32_t> sizes(found->clusters, 0);
  for (const std::uint32_t c : found->clusterOf)
  {
    ++sizes[c];
  }
  const double mean = double(mesh.triangles.size()) / 40;
  EXPECT_LT(*std::max_element(sizes.begin(), sizes.end()), 3 * mean);
  EXPECT_GT(*std::min_element(sizes.begin(), sizes.end()), mean / 4);
}

TEST(FaceClustering, RoundsAreFewOnStarsToo)
{
  const Mesh mesh = Star(65);
  int rounds = 0;
  Execution execution;
  execution.progress = [&](std::string_view, double)
  {
    ++rounds;
    return true;
  };
  const auto found = ClusterFaces(mesh.points, mesh.triangles, 2, execution);
  EXPECT_EQ(found->clusters, 2U);
  EXPECT_LE(rounds, 60);
}

TEST(NearestPoint, IsTheNearestAndOfEqualsTheLowest)
{
  std::mt19937 random(11);
  for (const std::size_t count : { 1U, 2U, 3U, 50U, 400U })
  {
    std::vector<Vec3> points(count);
    for (Vec3& p : points)
    {
      p = { double(random() % 6), double(random() % 6), double(random() % 3) }; // many are equal
    }
    const NearestPoint nearest(points);
    for (int query = 0; query < 300; ++query)
    {
      const Vec3 place{ double(random() % 15) / 2, double(random() % 15) / 2,
        double(random() % 9) / 2 };
      std::pair<double, std::uint32_t> best{ HUGE_VAL, 0 };
      for (std::uint32_t i = 0; i < points.size(); ++i)
      {
        const double x = points[i][0] - place[0], y = points[i][1] - place[1],
                     z = points[i][2] - place[2];
        best = std::min(best, { x * x + y * y + z * z, i });
      }
      ASSERT_EQ(nearest.Find(place), best.second);
    }
  }
}
