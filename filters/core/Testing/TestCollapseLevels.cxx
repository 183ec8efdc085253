// SPDX-License-Identifier: BSD-3-Clause
#include "Testing/Fixtures/Folds.h"
#include "Testing/Fixtures/Invariants.h"
#include "Testing/Fixtures/Meshes.h"
#include "filters/core/MeshDistance.h"
#include "filters/core/TriangleDistance.h"
#include "filters/core/Weld.h"
#include "filters/core/levels/CollapseLevels.h"
#include "filters/core/pieces/Piece.h"
#include "filters/core/pieces/VertexTree.h"
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

struct Built
{
  KdTree tree;
  TriangleBuckets buckets;
  ClusterLevels levels;
  // For each original vertex its cluster, by depth.
  std::vector<std::vector<VertexId>> clusterAt;
};

Built Build(const Mesh& mesh, const LevelOptions& options = {},
  const KdTreeOptions& treeOptions = { 200, {}, 8 }, const Execution& execution = {})
{
  Built built;
  built.tree = *BuildKdTree(mesh.points, treeOptions, execution);
  const auto partition = CellOfVertex(built.tree, built.tree.depths.partition);
  built.buckets = BucketTriangles(mesh.triangles, std::size_t{ 1 } << built.tree.depths.partition,
    [&](VertexId v) { return partition[v]; });
  built.levels = *BuildCollapseLevels(mesh, built.tree, built.buckets, options, execution);
  built.clusterAt.resize(built.levels.levels.size());
  built.clusterAt.back() = built.levels.finest;
  for (std::size_t d = built.levels.levels.size() - 1; d-- > options.coarsestDepth;)
  {
    for (const VertexId cluster : built.clusterAt[d + 1])
    {
      built.clusterAt[d].push_back(built.levels.levels[d + 1].parents[cluster]);
    }
  }
  return built;
}

// Many triangles on one edge.
Mesh Fan(unsigned blades)
{
  Mesh mesh{ { { 0, 0, 0 }, { 0, 0, 1 } }, {} };
  for (VertexId i = 0; i < blades; ++i)
  {
    mesh.points.push_back({ std::cos(0.1 * i), std::sin(0.1 * i), 0.01 * i });
    mesh.triangles.push_back({ 0, 1, i + 2 });
  }
  return mesh;
}

// Millimetres of detail far from the origin, as surveyors have it.
Mesh Surveyed()
{
  Mesh mesh = GridPlate(40);
  mesh.scalarType = ScalarType::Float64;
  std::mt19937 random(4);
  for (Vec3& p : mesh.points)
  {
    p = { 4e6 + 0.01 * p[0], 5e6 + 0.01 * p[1], 300 + double(random() % 1000) * 1e-6 };
  }
  return mesh;
}

Mesh HalfIsolated()
{
  Mesh mesh = DisplacedSphere(4);
  const Mesh cloud = DisplacedSphere(4, { 0.3, 0, 0 }, 0.7);
  mesh.points.insert(mesh.points.end(), cloud.points.begin(), cloud.points.end());
  return Shuffled(mesh, 5);
}

std::vector<NamedMesh> Meshes()
{
  std::vector<NamedMesh> meshes = AllMeshes();
  meshes.push_back({ "tetrahedra", Tetrahedra(5000) });
  meshes.push_back({ "fan", Fan(300) });
  meshes.push_back({ "surveyed", Surveyed() });
  meshes.push_back({ "half isolated", HalfIsolated() });
  return meshes;
}

template <class Check>
void ForAll(const Check& check)
{
  for (const NamedMesh& named : Meshes())
  {
    for (const KdTreeOptions& tree : { KdTreeOptions{ 200, {}, 8 }, { 30, {}, 1 } })
    {
      for (const bool sheets : { true, false })
      {
        SCOPED_TRACE(named.name + ", " + std::to_string(tree.verticesPerPartition) +
                     (sheets ? ", sheets" : ""));
        LevelOptions options;
        options.sheets = sheets;
        check(named.mesh, Build(named.mesh, options, tree));
      }
    }
  }
}

}

TEST(CollapseLevels, TrianglesAreTheImageOfTheOriginal)
{
  ForAll(
    [](const Mesh& mesh, const Built& built)
    {
      for (unsigned d = 0; d <= built.tree.depths.finest; ++d)
      {
        std::set<Triangle> image;
        for (const Triangle& t : mesh.triangles)
        {
          const Triangle m{ built.clusterAt[d][t[0]], built.clusterAt[d][t[1]],
            built.clusterAt[d][t[2]] };
          if (m[0] != m[1] && m[1] != m[2] && m[2] != m[0])
          {
            image.insert(RotateLowestFirst(m));
          }
        }
        ASSERT_EQ(
          std::vector<Triangle>(image.begin(), image.end()), built.levels.levels[d].triangles)
          << "level " << d;
      }
    });
}

// Before representatives moved, up to 0.5 % of these meshes' finest triangles faced the wrong way,
// and up to 0.7 % of all of the plate's.
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
      const Built built = Build(named.mesh, {}, tree);
      const std::vector<FoldCount> counts = CountFolds(named.mesh, built.levels);
      const FoldCount& finest = counts.back();
      EXPECT_LE(double(finest.opposed), 0.001 * double(finest.triangles));
      FoldCount all;
      for (const FoldCount& level : counts)
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
    [](const Mesh& mesh, const Built& built)
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
    [](const Mesh& mesh, const Built& built)
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

TEST(CollapseLevels, DeviationsGrowUpwardsAndPositionsStayInTheModel)
{
  ForAll(
    [](const Mesh&, const Built& built)
    {
      const Box& box = built.tree.boxes[1];
      for (unsigned d = 0; d <= built.tree.depths.finest; ++d)
      {
        const ClusterLevel& level = built.levels.levels[d];
        for (std::size_t i = 0; i < level.positions.size(); ++i)
        {
          ASSERT_TRUE(std::isfinite(level.deviations[i]));
          for (std::size_t k = 0; k < 3; ++k)
          {
            ASSERT_GE(level.positions[i][k], box.lo[k]);
            ASSERT_LE(level.positions[i][k], box.hi[k]);
            ASSERT_FALSE(level.positions[i][k] == 0 && std::signbit(level.positions[i][k]));
          }
          if (d > 0)
          {
            ASSERT_GE(built.levels.levels[d - 1].deviations[level.parents[i]], level.deviations[i]);
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
    const Built built = Build(named.mesh);
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
  for (const NamedMesh& named : Meshes())
  {
    SCOPED_TRACE(named.name);
    const Built serial = Build(named.mesh);
    for (const unsigned threads : { 1U, 2U, 8U })
    {
      const Built parallel = Build(named.mesh, {}, { 200, {}, 8 }, MakeTbbExecution(threads));
      ASSERT_EQ(serial.levels.finest, parallel.levels.finest);
      for (std::size_t d = 0; d < serial.levels.levels.size(); ++d)
      {
        ASSERT_EQ(serial.levels.levels[d].positions, parallel.levels.levels[d].positions);
        ASSERT_EQ(serial.levels.levels[d].deviations, parallel.levels.levels[d].deviations);
        ASSERT_EQ(serial.levels.levels[d].triangles, parallel.levels.levels[d].triangles);
        ASSERT_EQ(serial.levels.levels[d].parents, parallel.levels.levels[d].parents);
      }
    }
  }
}

TEST(CollapseLevels, AreNearerToTheSurfaceThanClusters)
{
  for (const Mesh& mesh : { DisplacedSphere(5), Torus(128, 64) })
  {
    const Built built = Build(mesh);
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
  // 4,000 km away the same levels, to a thousandth of the detail.
  const Mesh far = Surveyed();
  Mesh near = far;
  for (Vec3& p : near.points)
  {
    p = { p[0] - 4e6, p[1] - 5e6, p[2] - 300 };
  }
  const Built there = Build(far), here = Build(near);
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
  const Built built = Build(plate);
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

// No merge turns a triangle over. But partitions do not see each other's moves, the finest level is
// made by clusters, and turns add up: slivers may.
// A closed surface whose vertices are split along seams, as texture coordinates and hard edges
// split them: every vertex on some rings and some arcs is there twice, once for the triangles on
// each side.
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

// Edges of a single triangle.
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

// Coincident vertices of one partition are one cluster in every level: nothing opens between them.
TEST(CollapseLevels, SeamsStayClosed)
{
  for (const NamedMesh& named : ClosedMeshes())
  {
    SCOPED_TRACE(named.name);
    const Mesh split = SplitAlongSeams(named.mesh, 7);
    const Built built = Build(split, {}, { 1U << 20, {}, 8 }); // one partition
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

TEST(CollapseLevels, NormalsDoNotFlip)
{
  const Mesh sphere = DisplacedSphere(6);
  const Built built = Build(sphere, {}, { 2000, {}, 8 });
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

namespace
{

// A flat plate painted as a checkerboard of 8 × 8 fields whose borders lie between vertices.
Mesh Checkerboard()
{
  constexpr unsigned side = 95;
  Mesh plate = GridPlate(side);
  Attribute colors;
  colors.name = "RGB";
  colors.type = AttributeType::UInt8;
  colors.components = 3;
  for (const Vec3& p : plate.points)
  {
    const auto field = static_cast<unsigned>(p[0]) / 12 + static_cast<unsigned>(p[1]) / 12;
    const auto value = static_cast<std::uint8_t>(field % 2 == 0 ? 20 : 230);
    colors.values.insert(colors.values.end(), { value, value, value });
  }
  plate.attributes.push_back(std::move(colors));
  return plate;
}

// How far the painted level's colours are from the board's, as RMS over the board's vertices: a
// colour at a place is that of the corner of the triangle there which is nearest in the plane.
double ColorError(const Mesh& board, const ClusterLevel& level, const std::vector<VertexId>& of)
{
  std::vector<double> sum(level.positions.size(), 0), count(level.positions.size(), 0);
  for (std::size_t v = 0; v < of.size(); ++v)
  {
    sum[of[v]] += board.attributes[0].Get(v, 0);
    count[of[v]] += 1;
  }
  double squares = 0;
  for (std::size_t v = 0; v < of.size(); ++v)
  {
    const double d = board.attributes[0].Get(v, 0) - sum[of[v]] / count[of[v]];
    squares += d * d;
  }
  return std::sqrt(squares / double(of.size()));
}

}

TEST(CollapseLevels, ColoursKeepTheirEdges)
{
  const Mesh board = Checkerboard();
  Mesh plain = board;
  plain.attributes.clear();
  const Built painted = Build(board), bare = Build(plain);
  for (const unsigned d : { 6U, 7U, 8U })
  {
    EXPECT_LT(ColorError(board, painted.levels.levels[d], painted.clusterAt[d]),
      0.5 * ColorError(board, bare.levels.levels[d], bare.clusterAt[d]))
      << "level " << d;
  }
}

TEST(CollapseLevels, OneColourChangesNothing)
{
  const Mesh plain = DisplacedSphere(4);
  Mesh painted = plain;
  Attribute colors;
  colors.name = "RGBA";
  colors.type = AttributeType::UInt8;
  colors.components = 4;
  colors.values.assign(4 * plain.points.size(), 100);
  painted.attributes.push_back(colors);
  const Built a = Build(plain), b = Build(painted);
  for (std::size_t d = 0; d < a.levels.levels.size(); ++d)
  {
    EXPECT_EQ(a.levels.levels[d].positions, b.levels.levels[d].positions);
    EXPECT_EQ(a.levels.levels[d].triangles, b.levels.levels[d].triangles);
  }
}

TEST(CollapseLevels, AttributesThatAreNoNumbersDoNoHarm)
{
  Mesh mesh = DisplacedSphere(4);
  Attribute normals;
  normals.name = "Normals";
  normals.type = AttributeType::Float64;
  normals.components = 3;
  normals.values.resize(mesh.points.size() * normals.TupleSize());
  for (std::size_t v = 0; v < mesh.points.size(); ++v)
  {
    for (std::size_t k = 0; k < 3; ++k)
    {
      normals.Set(v, k, v % 7 == 0 ? NAN : v % 11 == 0 ? 1e300 : mesh.points[v][k]);
    }
  }
  mesh.attributes.push_back(normals);
  const Built built = Build(mesh);
  for (const ClusterLevel& level : built.levels.levels)
  {
    for (const Vec3& p : level.positions)
    {
      ASSERT_TRUE(std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]));
    }
  }
  EXPECT_LE(built.levels.levels[6].positions.size(), 100U);
}

TEST(CollapseLevels, StopWhereTheyAreTold)
{
  const Mesh sphere = DisplacedSphere(4);
  LevelOptions options;
  options.coarsestDepth = 5;
  const ClusterLevels levels = Build(sphere, options).levels;
  EXPECT_TRUE(levels.levels[4].positions.empty());
  EXPECT_FALSE(levels.levels[5].positions.empty());
  EXPECT_TRUE(levels.levels[5].parents.empty());

  const Built built = Build(sphere);
  options = {};
  options.mostClusters = 100;
  EXPECT_EQ(BuildCollapseLevels(sphere, built.tree, built.buckets, options).GetError().code,
    ErrorCode::LimitExceeded);
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

TEST(CollapseTo, MeetsAnyTarget)
{
  for (const NamedMesh& named : Meshes())
  {
    SCOPED_TRACE(named.name);
    const Built built = Build(named.mesh);
    const ClusterLevel& finest = built.levels.levels.back();
    for (const CollapseTarget& target : { CollapseTarget{ 1, 0 }, { 7, 0 }, { 100, 0 }, { 501, 0 },
           { 0, 1 }, { 0, 5 }, { 0, 300 }, { 300, 40 }, { 1000000, 0 } })
    {
      SCOPED_TRACE(std::to_string(target.triangles) + " " + std::to_string(target.points));
      const auto made = CollapseTo(named.mesh, built.tree, built.buckets, {}, target);
      ASSERT_TRUE(made) << made.GetError().message;
      const ClusterLevel& level = made->level;
      if (target.triangles > 0)
      {
        EXPECT_LE(level.triangles.size(), target.triangles);
      }
      if (target.points > 0)
      {
        EXPECT_LE(level.positions.size(), target.points);
      }
      ASSERT_EQ(made->clusterOf.size(), named.mesh.points.size());
      EXPECT_EQ(ImageOfTriangles(named.mesh.triangles, made->clusterOf), level.triangles);
      EXPECT_LE(level.positions.size(), finest.positions.size());
    }
  }
}

TEST(CollapseTo, MeetsItExactlyOnAManifold)
{
  const Mesh sphere = DisplacedSphere(5);
  const Built built = Build(sphere);
  for (const std::size_t triangles : { 1600U, 1000U, 702U, 100U, 20U })
  {
    EXPECT_EQ(
      CollapseTo(sphere, built.tree, built.buckets, {}, { triangles, 0 })->level.triangles.size(),
      triangles);
  }
  for (const std::size_t points : { 900U, 333U, 50U })
  {
    EXPECT_EQ(
      CollapseTo(sphere, built.tree, built.buckets, {}, { 0, points })->level.positions.size(),
      points);
  }
  EXPECT_EQ(CollapseTo(sphere, built.tree, built.buckets, {}, {}).GetError().message,
    "a target of 0 triangles and 0 points: one of them must be at least 1");
}
