// SPDX-License-Identifier: BSD-3-Clause
#include "Testing/Fixtures/Invariants.h"
#include "Testing/Fixtures/Meshes.h"
#include "filters/core/Testing/BuiltLevels.h"
#include "filters/core/Weld.h"
#include "filters/core/levels/ClusterLevels.h"
#include "filters/program/TbbExecution.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numeric>
#include <set>

using namespace kdstream;
using namespace kdstream::fixtures;

namespace
{

using Built = BuiltLevels;

Built Build(const Mesh& mesh, const ClusterOptions& options = {},
  const KdTreeOptions& treeOptions = { 200, {}, 8 }, const Execution& execution = {})
{
  return BuildWith(mesh, options.coarsestDepth, treeOptions, execution,
    [&](const KdTree& tree, const TriangleBuckets& buckets)
    { return BuildClusterLevels(mesh.points, mesh.triangles, tree, buckets, options, execution); });
}

const ClusterOptions optionSets[] = { {}, { Representative::Mean, false, 0 },
  { Representative::Mean, true, 0 }, { Representative::Quadric, false, 0 } };

template <class Check>
void ForAll(const Check& check)
{
  for (const NamedMesh& named : AllMeshes())
  {
    for (const ClusterOptions& options : optionSets)
    {
      SCOPED_TRACE(named.name + (options.byComponents ? ", sheets" : "") +
                   (options.representative == Representative::Mean ? ", mean" : ", quadric"));
      check(named.mesh, options, Build(named.mesh, options));
    }
  }
}

}

TEST(ClusterLevels, AClusterLiesInOneCellAndACellHasAtMostFour)
{
  ForAll(
    [](const Mesh& mesh, const ClusterOptions& options, const Built& built)
    {
      for (unsigned d = 0; d <= built.tree.depths.finest; ++d)
      {
        const auto cell = CellOfVertex(built.tree, d);
        std::map<std::uint32_t, std::set<VertexId>> clustersOf;
        std::map<VertexId, std::uint32_t> cellOf;
        for (VertexId v = 0; v < mesh.points.size(); ++v)
        {
          const VertexId cluster = built.clusterAt[d][v];
          ASSERT_EQ(cellOf.try_emplace(cluster, cell[v]).first->second, cell[v]);
          clustersOf[cell[v]].insert(cluster);
        }
        ASSERT_EQ(cellOf.size(), built.levels.levels[d].positions.size())
          << "a cluster without vertices";
        for (const auto& entry : clustersOf)
        {
          ASSERT_LE(entry.second.size(), options.byComponents ? 4U : 1U);
        }
      }
    });
}

TEST(ClusterLevels, TrianglesAreTheImageOfTheOriginal)
{
  ForAll([](const Mesh& mesh, const ClusterOptions&, const Built& built)
    { ExpectImageOfOriginal(mesh, built); });
}

TEST(ClusterLevels, RepresentativesLieInTheBoxAndGeometricErrorsGrowUpwards)
{
  ForAll(
    [](const Mesh& mesh, const ClusterOptions&, const Built& built)
    {
      for (unsigned d = 0; d <= built.tree.depths.finest; ++d)
      {
        const ClusterLevel& level = built.levels.levels[d];
        std::vector<Box> boxes(level.positions.size());
        std::vector<VertexId> lowest(level.positions.size(), noVertex);
        for (VertexId v = 0; v < mesh.points.size(); ++v)
        {
          boxes[built.clusterAt[d][v]].Add(mesh.points[v]);
          lowest[built.clusterAt[d][v]] = std::min(lowest[built.clusterAt[d][v]], v);
        }
        ASSERT_EQ(lowest, level.lowest);
        for (std::size_t i = 0; i < boxes.size(); ++i)
        {
          ASSERT_TRUE(std::isfinite(level.geometricErrors[i]));
          for (std::size_t k = 0; k < 3; ++k)
          {
            ASSERT_GE(level.positions[i][k], boxes[i].lo[k]);
            ASSERT_LE(level.positions[i][k], boxes[i].hi[k]);
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

TEST(ClusterLevels, MeanIsThatOfTheVertices)
{
  const Mesh mesh = DisplacedSphere(4);
  const Built built = Build(mesh, { Representative::Mean, false, 0 });
  for (unsigned d = 0; d <= built.tree.depths.finest; ++d)
  {
    for (std::size_t c = 0; c < std::size_t{ 1 } << d; ++c)
    {
      const auto cell = built.tree.Cell(d, c);
      for (std::size_t k = 0; k < 3; ++k)
      {
        long double sum = 0;
        for (const VertexId v : cell)
        {
          sum += mesh.points[v][k];
        }
        EXPECT_NEAR(built.levels.levels[d].positions[c][k], double(sum / cell.size()), 1e-12);
      }
    }
  }
}

TEST(ClusterLevels, QuadricRepresentativesKeepCornersAndMeansRoundThem)
{
  // A cube of 6 × 40 × 40 quads. Measures how far the nearest representative is from each corner.
  Mesh cube;
  constexpr unsigned side = 40;
  for (std::size_t axis = 0; axis < 3; ++axis)
  {
    for (const double height : { 0.0, 1.0 })
    {
      const auto first = static_cast<VertexId>(cube.points.size());
      for (unsigned i = 0; i < (side + 1) * (side + 1); ++i)
      {
        Vec3 p;
        p[axis] = height;
        p[(axis + 1) % 3] = double(i % (side + 1)) / side;
        p[(axis + 2) % 3] = double(i / (side + 1)) / side;
        cube.points.push_back(p);
      }
      for (unsigned i = 0; i < side * side; ++i)
      {
        const VertexId a = first + i / side * (side + 1) + i % side;
        cube.triangles.push_back({ a, a + 1, a + side + 1 });
        cube.triangles.push_back({ a + 1, a + side + 2, a + side + 1 });
      }
    }
  }
  WeldVertices(cube);
  const auto farthestCorner = [&](Representative representative, unsigned depth)
  {
    const ClusterLevels levels = Build(cube, { representative, true, 0 }).levels;
    double farthest = 0;
    for (unsigned corner = 0; corner < 8; ++corner)
    {
      double nearest = INFINITY;
      for (const Vec3& p : levels.levels[depth].positions)
      {
        nearest = std::min(nearest,
          std::hypot(p[0] - (corner & 1), p[1] - ((corner >> 1) & 1), p[2] - ((corner >> 2) & 1)));
      }
      farthest = std::max(farthest, nearest);
    }
    return farthest;
  };
  for (const unsigned depth : { 5U, 7U })
  {
    EXPECT_LT(farthestCorner(Representative::Quadric, depth), 0.02) << depth;
    EXPECT_GT(farthestCorner(Representative::Mean, depth), 0.05) << depth;
  }
}

// The definition of finest clusters if a cell has at most four components. A cluster has the
// vertices that are connected by edges inside the cell, or are in the same place. All vertices
// without triangles form one cluster.
TEST(ClusterLevels, FinestClustersAreTheComponentsOfACell)
{
  for (const NamedMesh& named : AllMeshes())
  {
    SCOPED_TRACE(named.name);
    const Mesh& mesh = named.mesh;
    const Built built = Build(mesh);
    const unsigned finest = built.tree.depths.finest;
    const auto cell = CellOfVertex(built.tree, finest);
    std::map<std::uint32_t, std::set<Edge>> edges;
    std::vector<bool> touched(mesh.points.size(), false);
    for (const Triangle& t : mesh.triangles)
    {
      for (std::size_t k = 0; k < 3; ++k)
      {
        touched[t[k]] = true;
        if (cell[t[k]] == cell[t[(k + 1) % 3]])
        {
          edges[cell[t[k]]].insert({ t[k], t[(k + 1) % 3] });
        }
      }
    }
    for (std::size_t c = 0; c < std::size_t{ 1 } << finest; ++c)
    {
      const auto members = built.tree.Cell(finest, c);
      std::map<VertexId, VertexId> label;
      for (const VertexId v : members)
      {
        label[v] = v;
      }
      const auto join = [&](VertexId a, VertexId b)
      {
        const VertexId from = std::max(label[a], label[b]), to = std::min(label[a], label[b]);
        for (auto& entry : label)
        {
          entry.second = entry.second == from ? to : entry.second;
        }
      };
      for (const Edge& edge : edges[static_cast<std::uint32_t>(c)])
      {
        join(edge.first, edge.second);
      }
      for (const VertexId a : members)
      {
        for (const VertexId b : members)
        {
          if (mesh.points[a] == mesh.points[b])
          {
            join(a, b);
          }
        }
      }
      std::set<VertexId> surface;
      for (const VertexId v : members)
      {
        if (touched[v])
        {
          surface.insert(label[v]);
        }
      }
      for (const VertexId a : members)
      {
        for (const VertexId b : members)
        {
          if (!surface.contains(label[a]) && !surface.contains(label[b]))
          {
            join(a, b);
          }
        }
      }
      std::map<VertexId, std::set<VertexId>> components;
      std::map<VertexId, std::set<VertexId>> clusters;
      for (const VertexId v : members)
      {
        components[label[v]].insert(v);
        clusters[built.levels.finest[v]].insert(v);
      }
      std::set<std::set<VertexId>> expected, found;
      for (const auto& entry : components)
      {
        expected.insert(entry.second);
      }
      for (const auto& entry : clusters)
      {
        found.insert(entry.second);
      }
      if (components.size() <= 4)
      {
        ASSERT_EQ(found, expected) << "cell " << c;
      }
      else
      {
        ASSERT_EQ(found.size(), 4U) << "cell " << c;
        for (const auto& component : expected) // components are joined, never split
        {
          ASSERT_TRUE(std::any_of(found.begin(), found.end(),
            [&](const std::set<VertexId>& cluster) {
              return std::includes(
                cluster.begin(), cluster.end(), component.begin(), component.end());
            }));
        }
      }
    }
  }
}

TEST(ClusterLevels, OfTooManyComponentsTheNearestJoin)
{
  // One cell of six triangles, of which four are near another one.
  Mesh mesh;
  for (const double x : { 0.5, 10.5, 0.0, 10.0, 20.0, 30.0 })
  {
    const auto first = static_cast<VertexId>(mesh.points.size());
    mesh.points.insert(mesh.points.end(), { { x, 0, 0 }, { x, 0.1, 0 }, { x, 0, 0.1 } });
    mesh.triangles.push_back({ first, first + 1, first + 2 });
  }
  const Built built = Build(mesh, {}, { 200, {}, 64 });
  for (unsigned d = 0; d <= built.tree.depths.finest; ++d)
  {
    std::map<VertexId, std::set<std::uint32_t>> tens;
    for (VertexId v = 0; v < mesh.points.size(); ++v)
    {
      tens[built.clusterAt[d][v]].insert(static_cast<std::uint32_t>(mesh.points[v][0]) / 10);
    }
    for (const auto& entry : tens)
    {
      EXPECT_EQ(entry.second.size(), 1U) << "level " << d;
    }
  }
}

TEST(ClusterLevels, ComponentsKeepNestedSurfacesApart)
{
  // Two spheres of 16,386 vertices, a fiftieth of the radius apart. Clusters of whole cells merge
  // them, clusters by components do not.
  const Mesh mesh = NestedSpheres(6);
  const auto shared = [&](bool byComponents, unsigned depth)
  {
    const Built built = Build(mesh, { Representative::Quadric, byComponents, 0 }, { 2000, {}, 64 });
    std::set<VertexId> outer, inner, both;
    for (VertexId v = 0; v < mesh.points.size(); ++v)
    {
      (v < mesh.points.size() / 2 ? outer : inner).insert(built.clusterAt[depth][v]);
    }
    std::set_intersection(
      outer.begin(), outer.end(), inner.begin(), inner.end(), std::inserter(both, both.end()));
    return double(both.size()) / double(built.levels.levels[depth].positions.size());
  };
  for (const unsigned depth : { 8U, 11U })
  {
    EXPECT_LT(shared(true, depth), 0.01) << "level " << depth;
    EXPECT_GT(shared(false, depth), 0.3) << "level " << depth;
  }
}

TEST(ClusterLevels, CollapsedTrianglesStillConnect)
{
  // A ribbon one quad wide: soon every triangle is in two clusters, and only links show that
  // neighbours are connected.
  Mesh ribbon;
  for (VertexId i = 0; i < 4000; ++i)
  {
    ribbon.points.push_back({ double(i / 2), double(i % 2) * 0.01, 0 });
    if (i >= 2)
    {
      ribbon.triangles.push_back(
        i % 2 == 0 ? Triangle{ i - 2, i - 1, i } : Triangle{ i - 1, i - 2, i });
    }
  }
  const Built built = Build(ribbon);
  for (unsigned d = 0; d < built.tree.depths.finest; ++d)
  {
    EXPECT_EQ(built.levels.levels[d].positions.size(), std::size_t{ 1 } << d) << "level " << d;
  }
}

TEST(ClusterLevels, CoincidentVerticesConnectAcrossCells)
{
  // The ribbon again, where every triangle has its own vertices: triangles are connected only
  // because vertices are in the same place.
  Mesh ribbon;
  for (VertexId i = 0; i < 4000; ++i)
  {
    for (VertexId k = i; k < i + 3; ++k)
    {
      ribbon.points.push_back({ double(k / 2), double(k % 2) * 0.01, 0 });
    }
    ribbon.triangles.push_back({ 3 * i, 3 * i + 1, 3 * i + 2 });
  }
  const Built built = Build(ribbon);
  for (unsigned d = 0; d + 3 < built.tree.depths.finest; ++d)
  {
    EXPECT_EQ(built.levels.levels[d].positions.size(), std::size_t{ 1 } << d) << "level " << d;
  }
}

TEST(ClusterLevels, CloudsAndSoupsCoarsen)
{
  for (const Mesh& mesh : { Cloud(5), Soup(3000, 9) })
  {
    const Built built = Build(mesh);
    for (unsigned d = 0; d <= built.tree.depths.finest; ++d)
    {
      EXPECT_LE(built.levels.levels[d].positions.size(), std::size_t{ 4 } << d);
    }
  }
}

TEST(ClusterLevels, AreTheSameOnAnyNumberOfThreads)
{
  for (const NamedMesh& named : AllMeshes())
  {
    ExpectSameOnThreads(named,
      [&](const Execution& execution) {
        return Build(named.mesh, {}, { 200, {}, 8 }, execution);
      });
  }
}

TEST(ClusterLevels, StopAtTheDepthAskedFor)
{
  const ClusterLevels levels =
    Build(DisplacedSphere(4), { Representative::Quadric, true, 5 }).levels;
  EXPECT_TRUE(levels.levels[4].positions.empty());
  EXPECT_FALSE(levels.levels[5].positions.empty());
  EXPECT_TRUE(levels.levels[5].parents.empty());
}

TEST(Weld, JoinsBitEqualVerticesToTheLowestId)
{
  Mesh mesh{ { { 1, 0, 0 }, { 0, 1, 0 }, { 1, 0, 0 }, { 0, -0.0, 0 }, { 0, 0, 0 }, { 0, 1, 0 } },
    { { 0, 1, 2 }, { 3, 4, 5 } } };
  EXPECT_EQ(WeldVertices(mesh), 2U);
  EXPECT_EQ(mesh.points, (std::vector<Vec3>{ { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 0 }, { 0, 0, 0 } }));
  EXPECT_TRUE(std::signbit(mesh.points[2][1]));
  EXPECT_FALSE(std::signbit(mesh.points[3][1]));
  EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{ { 0, 1, 0 }, { 2, 3, 1 } }));
}
