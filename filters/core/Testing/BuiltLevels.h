// SPDX-License-Identifier: BSD-3-Clause
// Builds levels by edge collapse, and the meshes that tests build them from.
#pragma once

#include "Testing/Fixtures/Meshes.h"
#include "filters/core/TriangleBuckets.h"
#include "filters/core/levels/CollapseLevels.h"
#include "filters/core/tree/KdTree.h"
#include "filters/program/TbbExecution.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <set>
#include <vector>

namespace kdstream::fixtures
{

struct BuiltLevels
{
  KdTree tree;
  TriangleBuckets buckets;
  ClusterLevels levels;
  // For each original vertex its cluster, by depth.
  std::vector<std::vector<VertexId>> clusterAt;
};

// makeLevels(tree, buckets) builds the levels; buckets: the triangles by partition.
template <class MakeLevels>
BuiltLevels BuildWith(const Mesh& mesh, unsigned coarsestDepth, const KdTreeOptions& treeOptions,
  const Execution& execution, const MakeLevels& makeLevels)
{
  BuiltLevels built;
  built.tree = *BuildKdTree(mesh.points, treeOptions, execution);
  const auto partition = CellOfVertex(built.tree, built.tree.depths.partition);
  built.buckets = BucketTriangles(mesh.triangles, std::size_t{ 1 } << built.tree.depths.partition,
    [&](VertexId v) { return partition[v]; });
  built.levels = *makeLevels(built.tree, built.buckets);
  built.clusterAt.resize(built.levels.levels.size());
  built.clusterAt.back() = built.levels.finest;
  for (std::size_t d = built.levels.levels.size() - 1; d-- > coarsestDepth;)
  {
    for (const VertexId cluster : built.clusterAt[d + 1])
    {
      built.clusterAt[d].push_back(built.levels.levels[d + 1].parents[cluster]);
    }
  }
  return built;
}

// Expects build(execution) to give the same levels on any number of threads as on one.
template <class Build>
void ExpectSameOnThreads(const NamedMesh& named, const Build& build)
{
  SCOPED_TRACE(named.name);
  const BuiltLevels serial = build(Execution{});
  for (const unsigned threads : { 1U, 2U, 8U })
  {
    const BuiltLevels parallel = build(MakeTbbExecution(threads));
    ASSERT_EQ(serial.levels.finest, parallel.levels.finest);
    for (std::size_t d = 0; d < serial.levels.levels.size(); ++d)
    {
      const ClusterLevel &a = serial.levels.levels[d], &b = parallel.levels.levels[d];
      ASSERT_EQ(a.positions, b.positions);
      ASSERT_EQ(a.geometricErrors, b.geometricErrors);
      ASSERT_EQ(a.triangles, b.triangles);
      ASSERT_EQ(a.parents, b.parents);
    }
  }
}

// Expects the triangles of each level to be those of the mesh whose corners lie in three different
// clusters.
inline void ExpectImageOfOriginal(const Mesh& mesh, const BuiltLevels& built)
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
    ASSERT_EQ(std::vector<Triangle>(image.begin(), image.end()), built.levels.levels[d].triangles)
      << "level " << d;
  }
}

inline BuiltLevels BuildAllLevels(const Mesh& mesh, const LevelOptions& options = {},
  const KdTreeOptions& treeOptions = { 200, {}, 8 }, const Execution& execution = {})
{
  return BuildWith(mesh, options.coarsestDepth, treeOptions, execution,
    [&](const KdTree& tree, const TriangleBuckets& buckets)
    { return BuildCollapseLevels(mesh, tree, buckets, options, execution); });
}

// Many triangles on one edge.
inline Mesh Fan(unsigned blades)
{
  Mesh mesh{ { { 0, 0, 0 }, { 0, 0, 1 } }, {} };
  for (VertexId i = 0; i < blades; ++i)
  {
    mesh.points.push_back({ std::cos(0.1 * i), std::sin(0.1 * i), 0.01 * i });
    mesh.triangles.push_back({ 0, 1, i + 2 });
  }
  return mesh;
}

// Millimetres of detail far from the origin, as in a surveyor's coordinates.
inline Mesh Surveyed()
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

inline Mesh HalfIsolated()
{
  Mesh mesh = DisplacedSphere(4);
  const Mesh cloud = DisplacedSphere(4, { 0.3, 0, 0 }, 0.7);
  mesh.points.insert(mesh.points.end(), cloud.points.begin(), cloud.points.end());
  return Shuffled(mesh, 5);
}

inline std::vector<NamedMesh> MeshesToCollapse()
{
  std::vector<NamedMesh> meshes = AllMeshes();
  meshes.push_back({ "tetrahedra", Tetrahedra(5000) });
  meshes.push_back({ "fan", Fan(300) });
  meshes.push_back({ "surveyed", Surveyed() });
  meshes.push_back({ "half isolated", HalfIsolated() });
  return meshes;
}

}
