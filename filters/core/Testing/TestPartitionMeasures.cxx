// SPDX-License-Identifier: BSD-3-Clause
// Partition measures: compared with values computed by hand, with simply counted edges, and in
// undefined cases.
#include "Testing/Fixtures/ErrorAt.h"
#include "Testing/Fixtures/Meshes.h"
#include "filters/baselines/OctreeClustering.h"
#include "filters/core/Weld.h"
#include "filters/core/tree/KdTree.h"
#include "filters/core/tree/PartitionMeasures.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>
#include <random>

using namespace kdstream;
using namespace kdstream::fixtures;

namespace
{

constexpr double pi = std::numbers::pi;

Clustering ByX(const Mesh& mesh, double x)
{
  Clustering clustering;
  clustering.clusters = 2;
  for (const Vec3& p : mesh.points)
  {
    clustering.clusterOf.push_back(p[0] < x ? 0 : 1);
  }
  return clustering;
}

Clustering One(const Mesh& mesh)
{
  return { std::vector<std::uint32_t>(mesh.points.size(), 0), 1 };
}

Clustering Random(const Mesh& mesh, std::uint32_t clusters, std::uint32_t seed)
{
  std::mt19937 random(seed);
  Clustering clustering{ {}, clusters };
  for (std::size_t v = 0; v < mesh.points.size(); ++v)
  {
    clustering.clusterOf.push_back(static_cast<std::uint32_t>(random() % clusters));
  }
  return clustering;
}

PartitionMeasures Measure(const Mesh& mesh, const Clustering& clustering)
{
  const auto found = MeasurePartitions(mesh.points, mesh.triangles, clustering);
  EXPECT_TRUE(found);
  return *found;
}

double Length(const Vec3& a, const Vec3& b)
{
  return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

}

TEST(PartitionMeasures, ASquareAsOne)
{
  const Mesh mesh = GridPlate(6);
  const PartitionMeasures found = Measure(mesh, One(mesh));
  ASSERT_EQ(found.partitions.size(), 1U);
  EXPECT_EQ(found.partitions[0].vertices, 49U);
  EXPECT_EQ(found.partitions[0].triangles, 72U);
  EXPECT_DOUBLE_EQ(found.partitions[0].area, 36);
  EXPECT_DOUBLE_EQ(found.partitions[0].boundaryLength, 24);
  EXPECT_DOUBLE_EQ(found.partitions[0].compactness, 16 / (4 * pi));
  EXPECT_EQ(found.measured, 1U);
}

TEST(PartitionMeasures, TwoHalvesWithTheTrianglesBetweenInBoth)
{
  // Columns 0-2 and 3-6; the quads between belong to both.
  const Mesh mesh = GridPlate(6);
  const PartitionMeasures found = Measure(mesh, ByX(mesh, 2.5));
  EXPECT_EQ(found.partitions[0].vertices, 21U);
  EXPECT_EQ(found.partitions[1].vertices, 28U);
  EXPECT_EQ(found.partitions[0].triangles, 36U);
  EXPECT_EQ(found.partitions[1].triangles, 48U);
  EXPECT_EQ(found.partitions[0].ownTriangles, 36U);
  EXPECT_EQ(found.partitions[1].ownTriangles, 36U);
  EXPECT_DOUBLE_EQ(found.partitions[0].area, 18);
  EXPECT_DOUBLE_EQ(found.partitions[1].area, 24);
  EXPECT_DOUBLE_EQ(found.partitions[0].boundaryLength, 18);
  EXPECT_DOUBLE_EQ(found.partitions[1].boundaryLength, 20);
  EXPECT_DOUBLE_EQ(found.partitions[0].compactness, 18 / (4 * pi));
  EXPECT_EQ(found.vertices.minimum, 21);
  EXPECT_EQ(found.vertices.maximum, 28);
  EXPECT_EQ(found.vertices.mean, 24.5);
  EXPECT_EQ(found.vertices.standardDeviation, 3.5);
  EXPECT_DOUBLE_EQ(found.vertices.ratio, 28.0 / 21);
}

TEST(PartitionMeasures, ATriangleOfThreePartitionsCountsInEach)
{
  const Mesh mesh{ { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 }, { 5, 5, 5 } }, { { 0, 1, 2 } } };
  const PartitionMeasures found = Measure(mesh, { { 2, 1, 3, 0 }, 4 });
  EXPECT_TRUE(std::isnan(found.partitions[0].compactness));
  for (const std::size_t i : { 1U, 2U, 3U })
  {
    EXPECT_EQ(found.partitions[i].triangles, 1U);
    EXPECT_EQ(found.partitions[i].ownTriangles, i == 1 ? 1U : 0U);
    EXPECT_EQ(found.partitions[i].area, 0.5);
    EXPECT_DOUBLE_EQ(found.partitions[i].boundaryLength, 2 + std::sqrt(2.0));
  }
  EXPECT_EQ(found.measured, 3U);
}

TEST(PartitionMeasures, IsWhatPlainCountingGives)
{
  for (const NamedMesh& named : AllMeshes())
  {
    SCOPED_TRACE(named.name);
    const Mesh& mesh = named.mesh;
    const std::vector<VertexId> place = FirstCoincident(mesh.points, Coincidence::ValueEqual);
    const Clustering clustering = *ClusterByOctree(mesh.points, { 150, {} });
    const PartitionMeasures found = Measure(mesh, clustering);
    std::uint64_t vertices = 0, own = 0;
    for (std::uint32_t p = 0; p < clustering.clusters; ++p)
    {
      std::map<std::pair<VertexId, VertexId>, int> uses;
      std::uint64_t triangles = 0;
      double area = 0;
      for (const Triangle& t : mesh.triangles)
      {
        if (clustering.clusterOf[t[0]] != p && clustering.clusterOf[t[1]] != p &&
            clustering.clusterOf[t[2]] != p)
        {
          continue;
        }
        ++triangles;
        const VertexId at[] = { place[t[0]], place[t[1]], place[t[2]] };
        if (at[0] == at[1] || at[1] == at[2] || at[2] == at[0])
        {
          continue;
        }
        const double a = Length(mesh.points[t[0]], mesh.points[t[1]]),
                     b = Length(mesh.points[t[1]], mesh.points[t[2]]),
                     c = Length(mesh.points[t[2]], mesh.points[t[0]]), s = (a + b + c) / 2;
        area += std::sqrt(std::max(0.0, s * (s - a) * (s - b) * (s - c)));
        for (std::size_t k = 0; k < 3; ++k)
        {
          ++uses[std::minmax(at[k], at[(k + 1) % 3])];
        }
      }
      double boundary = 0;
      for (const auto& [edge, count] : uses)
      {
        boundary += count == 1 ? Length(mesh.points[edge.first], mesh.points[edge.second]) : 0;
      }
      const PartitionMeasure& measure = found.partitions[p];
      ASSERT_EQ(measure.triangles, triangles);
      ASSERT_NEAR(measure.area, area, 1e-6 * area + 1e-12);
      ASSERT_NEAR(measure.boundaryLength, boundary, 1e-9 * boundary);
      if (measure.area > 0 && boundary > 0)
      {
        ASSERT_NEAR(
          measure.compactness, boundary * boundary / (4 * pi * area), 1e-6 * measure.compactness);
      }
      vertices += measure.vertices;
      own += measure.ownTriangles;
    }
    EXPECT_EQ(vertices, mesh.points.size());
    EXPECT_EQ(own, mesh.triangles.size());
  }
}

TEST(PartitionMeasures, DegenerateTrianglesHaveNoEdges)
{
  const Mesh mesh{ { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 } },
    { { 0, 1, 2 }, { 0, 0, 1 }, { 1, 2, 2 }, { 2, 2, 2 } } };
  const PartitionMeasures found = Measure(mesh, One(mesh));
  EXPECT_EQ(found.partitions[0].triangles, 4U);
  EXPECT_EQ(found.partitions[0].area, 0.5);
  EXPECT_DOUBLE_EQ(found.partitions[0].boundaryLength, 2 + std::sqrt(2.0));
}

TEST(PartitionMeasures, NothingIsDefinedWithoutAreaOrBoundary)
{
  const Mesh closed = DisplacedSphere(2);
  const PartitionMeasures whole = Measure(closed, One(closed));
  EXPECT_EQ(whole.partitions[0].boundaryLength, 0);
  EXPECT_GT(whole.partitions[0].area, 0);
  EXPECT_TRUE(std::isnan(whole.partitions[0].compactness));
  EXPECT_EQ(whole.measured, 0U);
  EXPECT_EQ(whole.compactness.mean, 0);

  Mesh line = GridPlate(2); // zero area: all on one line
  for (Vec3& p : line.points)
  {
    p[1] = p[0];
  }
  const PartitionMeasures flat = Measure(line, One(line));
  EXPECT_EQ(flat.partitions[0].triangles, 8U);
  EXPECT_EQ(flat.partitions[0].area, 0);
  EXPECT_TRUE(std::isnan(flat.partitions[0].compactness));

  Mesh cloud{ { { 0, 0, 0 }, { 1, 0, 0 } }, {} };
  const PartitionMeasures points = Measure(cloud, { { 0, 1 }, 2 });
  EXPECT_EQ(points.partitions[1].vertices, 1U);
  EXPECT_EQ(points.measured, 0U);
  EXPECT_TRUE(Measure({}, {}).partitions.empty());
}

TEST(PartitionMeasures, RepeatedVerticesMakeNoSlits)
{
  const Mesh plate = GridPlate(5);
  Mesh soup;
  const Clustering halves = ByX(plate, 2.5);
  Clustering soupHalves{ {}, 2 };
  for (const Triangle& t : plate.triangles)
  {
    const auto first = static_cast<VertexId>(soup.points.size());
    for (const VertexId v : t)
    {
      soup.points.push_back(plate.points[v]);
      soupHalves.clusterOf.push_back(halves.clusterOf[v]);
    }
    soup.triangles.push_back({ first, first + 1, first + 2 });
  }
  const PartitionMeasures expected = Measure(plate, halves), found = Measure(soup, soupHalves);
  for (const std::size_t i : { 0U, 1U })
  {
    EXPECT_DOUBLE_EQ(found.partitions[i].area, expected.partitions[i].area);
    EXPECT_DOUBLE_EQ(found.partitions[i].boundaryLength, expected.partitions[i].boundaryLength);
  }
}

TEST(PartitionMeasures, AnyInput)
{
  for (const NamedMesh& named : AllMeshes())
  {
    SCOPED_TRACE(named.name);
    const PartitionMeasures found = Measure(named.mesh, Random(named.mesh, 5, 3));
    std::size_t defined = 0;
    for (const PartitionMeasure& partition : found.partitions)
    {
      EXPECT_TRUE(std::isfinite(partition.area) && std::isfinite(partition.boundaryLength));
      const bool isDefined = !std::isnan(partition.compactness);
      EXPECT_EQ(isDefined, partition.area > 0 && partition.boundaryLength > 0);
      defined += isDefined;
    }
    EXPECT_EQ(found.measured, defined);
  }
}

TEST(PartitionMeasures, HugeAndTinyUnits)
{
  const Mesh mesh = GridPlate(3);
  for (const double unit : { 0x1p400, 0x1p-400 })
  {
    Mesh other = mesh;
    for (Vec3& p : other.points)
    {
      p = { unit * p[0], unit * p[1], 0 };
    }
    EXPECT_DOUBLE_EQ(Measure(other, One(other)).partitions[0].compactness, 16 / (4 * pi)) << unit;
  }
}

TEST(PartitionMeasures, SpreadOfNumbers)
{
  const double numbers[] = { 2, 4, 4, 4, 5, 5, 7, 9 };
  const Spread spread = SpreadOf(numbers);
  EXPECT_EQ(spread.minimum, 2);
  EXPECT_EQ(spread.maximum, 9);
  EXPECT_EQ(spread.mean, 5);
  EXPECT_EQ(spread.standardDeviation, 2);
  EXPECT_EQ(spread.ratio, 4.5);
  const double zero[] = { 0, 3 };
  EXPECT_EQ(SpreadOf(zero).ratio, HUGE_VAL);
  const double zeros[] = { 0, 0 };
  EXPECT_EQ(SpreadOf(zeros).ratio, 0);
}

TEST(PartitionMeasures, SaysWhatIsWrongAndStops)
{
  const Mesh mesh = GridPlate(1);
  const auto failsAt = [&](const Clustering& clustering, std::string_view place)
  {
    return fixtures::FailsAt(MeasurePartitions(mesh.points, mesh.triangles, clustering),
      ErrorCode::InvalidArgument, place);
  };
  EXPECT_TRUE(failsAt({ { 0, 0, 0 }, 1 }, "3 cluster ids"));
  EXPECT_TRUE(failsAt({ { 0, 0, 2, 0 }, 2 }, "vertex 2"));
  for (const int calls : { 0, 1 })
  {
    int left = calls;
    Execution execution;
    execution.progress = [&](std::string_view, double) { return left-- > 0; };
    const auto found = MeasurePartitions(mesh.points, mesh.triangles, One(mesh), execution);
    ASSERT_FALSE(found);
    EXPECT_EQ(found.GetError().code, ErrorCode::Cancelled);
  }
}
