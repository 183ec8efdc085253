// SPDX-License-Identifier: BSD-3-Clause
#include "Testing/Fixtures/FoldOvers.h"
#include "Testing/Fixtures/Invariants.h"
#include "filters/core/MeshDistance.h"
#include "filters/core/Testing/BuiltLevels.h"
#include "filters/core/VectorMath.h"
#include "filters/core/levels/CollapseRound.h"
#include "filters/core/pieces/Piece.h"
#include "filters/program/TbbExecution.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <set>

using namespace kdstream;
using namespace kdstream::fixtures;

namespace
{

template <class Check>
void ForAll(const Check& check)
{
  for (const NamedMesh& named : MeshesToCollapse())
  {
    for (const KdTreeOptions& tree : { KdTreeOptions{ 200, {}, 8 }, { 30, {}, 1 } })
    {
      for (const bool byComponents : { true, false })
      {
        SCOPED_TRACE(named.name + ", " + std::to_string(tree.verticesPerPartition) +
                     (byComponents ? ", sheets" : ""));
        LevelOptions options;
        options.byComponents = byComponents;
        check(named.mesh, BuildAllLevels(named.mesh, options, tree));
      }
    }
  }
}

}

TEST(CollapseLevels, TrianglesAreTheImageOfTheOriginal)
{
  ForAll(ExpectImageOfOriginal);
}

// Before FoldOverRepair moved representatives, up to 0.5 % of the triangles of these meshes' finest
// levels faced the wrong way, and up to 0.7 % of all triangles of the plate.
TEST(CollapseLevels, HardlyAnyTriangleFacesTheWrongWay)
{
  const std::vector<NamedMesh> meshes{ { "sphere", DisplacedSphere(6) },
    { "height field", HeightField(100) }, { "shuffled height field", Shuffled(HeightField(70), 3) },
    { "thin plate", ThinPlate(70) }, { "torus", Torus(120, 60) },
    { "nested spheres", NestedSpheres(5) } };
  for (const NamedMesh& named : meshes)
  {
    for (const KdTreeOptions& tree : { KdTreeOptions{ 200, {}, 8 }, { 1800, {}, 8 } })
    {
      SCOPED_TRACE(named.name + ", " + std::to_string(tree.verticesPerPartition));
      const BuiltLevels built = BuildAllLevels(named.mesh, {}, tree);
      const std::vector<FoldOverCount> counts = CountFoldOvers(named.mesh, built.levels);
      const FoldOverCount& finest = counts.back();
      EXPECT_LE(double(finest.opposed), 0.001 * double(finest.triangles));
      FoldOverCount all;
      for (const FoldOverCount& level : counts)
      {
        all.opposed += level.triangles >= 500 ? level.opposed : 0;
        all.triangles += level.triangles >= 500 ? level.triangles : 0;
      }
      EXPECT_LE(double(all.opposed), 0.002 * double(all.triangles));
    }
  }
}

TEST(CollapseLevels, NestAndHoldNoMoreThanAPieceMay)
{
  ForAll(
    [](const Mesh& mesh, const BuiltLevels& built)
    {
      const TreeDepths& depths = built.tree.depths;
      const auto partition = CellOfVertex(built.tree, depths.partition);
      for (unsigned d = 0; d <= depths.finest; ++d)
      {
        const ClusterLevel& level = built.levels.levels[d];
        const auto cell = CellOfVertex(built.tree, d);
        std::vector<VertexId> lowest(level.positions.size(), noVertex);
        for (VertexId v = 0; v < mesh.points.size(); ++v)
        {
          const VertexId cluster = built.clusterAt[d][v];
          lowest[cluster] = std::min(lowest[cluster], v);
        }
        ASSERT_EQ(lowest, level.lowest);
        for (std::size_t i = 1; i < lowest.size(); ++i)
        {
          ASSERT_LT(
            std::pair(cell[lowest[i - 1]], lowest[i - 1]), std::pair(cell[lowest[i]], lowest[i]))
            << "order";
        }
        for (VertexId v = 0; d >= depths.stitch && v < mesh.points.size(); ++v)
        {
          ASSERT_EQ(partition[v], partition[lowest[built.clusterAt[d][v]]]);
        }
        const unsigned nodeDepth = PieceDepth(Resolution::Level(d), depths);
        std::map<std::uint32_t, std::size_t> held;
        for (const VertexId v : lowest)
        {
          ++held[cell[v] >> (d - nodeDepth)];
        }
        for (const auto& entry : held)
        {
          ASSERT_LE(entry.second, std::size_t{ 4 } << (d - nodeDepth)) << "level " << d;
        }
      }
    });
}

TEST(CollapseLevels, LooseClustersAreOneACell)
{
  ForAll(
    [](const Mesh& mesh, const BuiltLevels& built)
    {
      for (unsigned d = 0; d < built.tree.depths.finest && !mesh.triangles.empty(); ++d)
      {
        const ClusterLevel& level = built.levels.levels[d];
        const auto cell = CellOfVertex(built.tree, d);
        std::vector<bool> touched(level.positions.size(), false);
        for (const Triangle& t : level.triangles)
        {
          touched[t[0]] = touched[t[1]] = touched[t[2]] = true;
        }
        std::set<std::uint32_t> cells;
        for (std::size_t i = 0; i < touched.size(); ++i)
        {
          ASSERT_TRUE(touched[i] || cells.insert(cell[level.lowest[i]]).second) << "level " << d;
        }
      }
    });
}

TEST(CollapseLevels, GeometricErrorsGrowUpwardsAndPositionsStayInTheModel)
{
  ForAll(
    [](const Mesh&, const BuiltLevels& built)
    {
      const Box& box = built.tree.boxes[1];
      for (unsigned d = 0; d <= built.tree.depths.finest; ++d)
      {
        const ClusterLevel& level = built.levels.levels[d];
        for (std::size_t i = 0; i < level.positions.size(); ++i)
        {
          ASSERT_TRUE(std::isfinite(level.geometricErrors[i]));
          for (std::size_t k = 0; k < 3; ++k)
          {
            ASSERT_GE(level.positions[i][k], box.lo[k]);
            ASSERT_LE(level.positions[i][k], box.hi[k]);
            ASSERT_FALSE(level.positions[i][k] == 0 && std::signbit(level.positions[i][k]));
          }
          if (d > 0)
          {
            ASSERT_GE(built.levels.levels[d - 1].geometricErrors[level.parents[i]],
              level.geometricErrors[i]);
          }
        }
      }
    });
}

TEST(CollapseLevels, HaveAboutTwoToTheDepth)
{
  for (const NamedMesh& named : ClosedMeshes())
  {
    SCOPED_TRACE(named.name);
    const BuiltLevels built = BuildAllLevels(named.mesh);
    for (unsigned d = 3; d < built.tree.depths.finest; ++d)
    {
      const auto count = double(built.levels.levels[d].positions.size());
      EXPECT_GE(count, 0.9 * double(1U << d)) << "level " << d;
      EXPECT_LE(count, 1.05 * double(1U << d) + 40) << "level " << d;
    }
  }
}

TEST(CollapseLevels, AreTheSameOnAnyNumberOfThreads)
{
  for (const NamedMesh& named : MeshesToCollapse())
  {
    ExpectSameOnThreads(named,
      [&](const Execution& execution) {
        return BuildAllLevels(named.mesh, {}, { 200, {}, 8 }, execution);
      });
  }
}

TEST(CollapseLevels, AreNearerToTheSurfaceThanClusters)
{
  for (const Mesh& mesh : { DisplacedSphere(5), Torus(128, 64) })
  {
    const BuiltLevels built = BuildAllLevels(mesh);
    const auto clusters =
      *BuildClusterLevels(mesh.points, mesh.triangles, built.tree, built.buckets, {});
    for (unsigned d = 7; d < built.tree.depths.finest; ++d)
    {
      const auto away = [&](const ClusterLevel& level)
      {
        const Mesh coarse{ level.positions, level.triangles };
        return MeasureDistance(mesh, coarse, { 5000, 1 })->rmsForward;
      };
      EXPECT_LT(away(built.levels.levels[d]), 0.75 * away(clusters.levels[d])) << "level " << d;
    }
  }
}

TEST(CollapseLevels, ChangeWithTheDetailNotWithThePlace)
{
  // 4,000 km from the origin the levels are the same, up to a thousandth of the detail.
  const Mesh far = Surveyed();
  Mesh near = far;
  for (Vec3& p : near.points)
  {
    p = { p[0] - 4e6, p[1] - 5e6, p[2] - 300 };
  }
  const BuiltLevels there = BuildAllLevels(far), here = BuildAllLevels(near);
  for (unsigned d = 6; d <= there.tree.depths.finest; ++d)
  {
    const ClusterLevel &a = there.levels.levels[d], &b = here.levels.levels[d];
    const auto mesh = [](const ClusterLevel& level, const Vec3& offset)
    {
      Mesh m{ level.positions, level.triangles };
      for (Vec3& p : m.points)
      {
        p = Minus(p, offset);
      }
      return m;
    };
    const auto away = *MeasureDistance(mesh(b, {}), mesh(a, { 4e6, 5e6, 300 }), { 2000, 1 });
    const auto detail = *MeasureDistance(near, mesh(b, {}), { 2000, 1 });
    EXPECT_LT(away.rmsForward, 0.2 * detail.rmsForward + 1e-8) << "level " << d;
  }
}

TEST(CollapseLevels, BoundariesOfPlatesStayInPlace)
{
  const Mesh plate = GridPlate(60);
  const BuiltLevels built = BuildAllLevels(plate);
  for (unsigned d = 4; d <= built.tree.depths.finest; ++d)
  {
    const ClusterLevel& level = built.levels.levels[d];
    double area = 0;
    for (const Triangle& t : level.triangles)
    {
      const Vec3 u = Minus(level.positions[t[1]], level.positions[t[0]]);
      const Vec3 v = Minus(level.positions[t[2]], level.positions[t[0]]);
      area += (u[0] * v[1] - u[1] * v[0]) / 2;
    }
    EXPECT_NEAR(area, 3600, 1e-6) << "level " << d;
    for (const Edge& edge : BoundaryEdges(level.triangles))
    {
      for (const VertexId v : { edge.first, edge.second })
      {
        const Vec3& p = level.positions[v];
        EXPECT_LT(
          std::min({ std::abs(p[0]), std::abs(60 - p[0]), std::abs(p[1]), std::abs(60 - p[1]) }),
          1e-8)
          << "level " << d;
      }
    }
    for (const Vec3& p : level.positions)
    {
      EXPECT_EQ(p[2], plate.points[0][2]);
    }
  }
}

namespace
{

// A closed surface whose vertices are split along seams, as texture coordinates and hard edges do
// it. Every vertex on some rings and some arcs exists twice, once for the triangles on each side.
Mesh SplitAlongSeams(const Mesh& mesh, std::uint32_t seed)
{
  Mesh split = mesh;
  std::mt19937 random(seed);
  std::vector<VertexId> twin(mesh.points.size(), noVertex);
  for (VertexId v = 0; v < mesh.points.size(); ++v)
  {
    if (random() % 3 == 0)
    {
      twin[v] = static_cast<VertexId>(split.points.size());
      split.points.push_back(mesh.points[v]);
    }
  }
  for (Triangle& t : split.triangles)
  {
    for (VertexId& corner : t)
    {
      corner = twin[corner] != noVertex && random() % 2 == 0 ? twin[corner] : corner;
    }
  }
  return split;
}

// The number of edges that belong to a single triangle.
std::size_t OpenEdges(const std::vector<Triangle>& triangles)
{
  std::map<std::pair<VertexId, VertexId>, std::size_t> uses;
  for (const Triangle& t : triangles)
  {
    for (std::size_t k = 0; k < 3; ++k)
    {
      ++uses[std::minmax(t[k], t[(k + 1) % 3])];
    }
  }
  return static_cast<std::size_t>(
    std::count_if(uses.begin(), uses.end(), [](const auto& edge) { return edge.second == 1; }));
}

}

// Coincident vertices of one partition are one cluster in every level: nothing opens between them.
TEST(CollapseLevels, SeamsStayClosed)
{
  for (const NamedMesh& named : ClosedMeshes())
  {
    SCOPED_TRACE(named.name);
    const Mesh split = SplitAlongSeams(named.mesh, 7);
    const BuiltLevels built = BuildAllLevels(split, {}, { 1U << 20, {}, 8 }); // one partition
    for (std::size_t d = 0; d < built.levels.levels.size(); ++d)
    {
      EXPECT_EQ(OpenEdges(built.levels.levels[d].triangles), 0U) << "level " << d;
    }
    for (VertexId v = 0; v < split.points.size(); ++v)
    {
      for (VertexId w = v + 1; w < split.points.size() && split.points.size() < 3000; ++w)
      {
        ASSERT_TRUE(
          split.points[v] != split.points[w] || built.levels.finest[v] == built.levels.finest[w]);
      }
    }
  }
}

// No merge flips a triangle. But slivers can flip, because partitions do not know each other's
// moves, the finest level is made by clusters, and rotations accumulate.
TEST(CollapseLevels, NormalsDoNotFlip)
{
  const Mesh sphere = DisplacedSphere(6);
  const BuiltLevels built = BuildAllLevels(sphere, {}, { 2000, {}, 8 });
  for (unsigned d = 6; d <= built.tree.depths.finest; ++d)
  {
    const ClusterLevel& level = built.levels.levels[d];
    double area = 0, flipped = 0;
    for (const Triangle& t : level.triangles)
    {
      const Vec3 &a = level.positions[t[0]], &b = level.positions[t[1]], &c = level.positions[t[2]];
      const Vec3 n = Cross(Minus(b, a), Minus(c, a));
      const bool inwards =
        Dot(n, { a[0] + b[0] + c[0], a[1] + b[1] + c[1], a[2] + b[2] + c[2] }) < 0;
      area += std::sqrt(Dot(n, n));
      flipped += inwards ? std::sqrt(Dot(n, n)) : 0;
    }
    EXPECT_LE(flipped, 4e-3 * area) << "level " << d;
  }
}

TEST(CollapseLevels, AreMadeInPartsWhereClustersOrTrianglesAreMany)
{
  const TreeDepths depths{ 13, 17, 21 };
  EXPECT_TRUE(CollapsesInParts(depths, 17, 100, 200));
  EXPECT_TRUE(CollapsesInParts(depths, 16, 100, 200));
  EXPECT_FALSE(CollapsesInParts(depths, 15, 80000, 160000));
  EXPECT_TRUE(CollapsesInParts(depths, 15, 90000, 180000));
  EXPECT_TRUE(CollapsesInParts(depths, 13, 60000, 830000));
  EXPECT_FALSE(CollapsesInParts(depths, 12, 11000, 490000));
  EXPECT_FALSE(CollapsesInParts(depths, 12, 80000, 0));
}

TEST(CollapseLevels, StopWhereSpecified)
{
  const Mesh sphere = DisplacedSphere(4);
  LevelOptions options;
  options.coarsestDepth = 5;
  const ClusterLevels levels = BuildAllLevels(sphere, options).levels;
  EXPECT_TRUE(levels.levels[4].positions.empty());
  EXPECT_FALSE(levels.levels[5].positions.empty());
  EXPECT_TRUE(levels.levels[5].parents.empty());

  const BuiltLevels built = BuildAllLevels(sphere);
  for (unsigned after = 0; after < 8; ++after)
  {
    Execution stop;
    unsigned calls = 0;
    stop.progress = [&](std::string_view step, double fraction)
    {
      EXPECT_EQ(step, "levels");
      EXPECT_LE(fraction, 1);
      return calls++ < after;
    };
    EXPECT_EQ(BuildCollapseLevels(sphere, built.tree, built.buckets, {}, stop).GetError().code,
      ErrorCode::Cancelled);
  }
}
