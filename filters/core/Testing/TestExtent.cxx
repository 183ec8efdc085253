// SPDX-License-Identifier: BSD-3-Clause
#include "Testing/Fixtures/ErrorAt.h"
#include "Testing/Fixtures/Meshes.h"
#include "filters/core/Extent.h"
#include "filters/core/levels/Levels.h"
#include "filters/core/tree/KdTree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

using namespace kdstream;
using namespace kdstream::fixtures;

namespace
{

// Puts the mesh on a grid, with a longest side of exactly 1 (or 0), so that multiplying by a power
// of two does not round.
Mesh OnGrid(Mesh mesh)
{
  Box box;
  for (const Vec3& p : mesh.points)
  {
    box.Add(p);
  }
  const double side =
    std::max({ box.hi[0] - box.lo[0], box.hi[1] - box.lo[1], box.hi[2] - box.lo[2], 0x1p-20 });
  for (Vec3& p : mesh.points)
  {
    for (std::size_t k = 0; k < 3; ++k)
    {
      p[k] = std::round((p[k] - box.lo[k]) / side * 0x1p20) / 0x1p20;
    }
  }
  mesh.scalarType = ScalarType::Float64;
  return mesh;
}

// Triangles as large as their box, which share vertices; most vertices are near the corners of the
// box.
Mesh LargeTriangles(unsigned vertices, unsigned triangles)
{
  std::mt19937 random(23);
  Mesh mesh;
  for (unsigned v = 0; v < vertices; ++v)
  {
    const unsigned corner = v % 8;
    const double inside = 0.01 * double(random() % 16);
    mesh.points.push_back({ corner & 1 ? 1 - inside : 0.0, corner & 2 ? 1.0 : inside,
      corner & 4 ? 1.0 - inside : inside });
  }
  mesh.points[0] = { 0, 0, 0 };
  mesh.points[7] = { 1, 1, 1 };
  const auto any = [&] { return static_cast<VertexId>(random() % vertices); };
  for (unsigned t = 0; t < triangles; ++t)
  {
    mesh.triangles.push_back({ any(), any(), any() });
  }
  return OnGrid(std::move(mesh));
}

Mesh Cube()
{
  Mesh mesh;
  for (unsigned corner = 0; corner < 8; ++corner)
  {
    mesh.points.push_back({ double(corner & 1), double(corner >> 1 & 1), double(corner >> 2) });
  }
  mesh.triangles = { { 0, 2, 1 }, { 1, 2, 3 }, { 4, 5, 6 }, { 5, 7, 6 }, { 0, 1, 4 }, { 1, 5, 4 },
    { 2, 6, 3 }, { 3, 6, 7 }, { 0, 4, 2 }, { 2, 4, 6 }, { 1, 3, 5 }, { 3, 7, 5 } };
  mesh.scalarType = ScalarType::Float64;
  return mesh;
}

Vec3 Times(const Vec3& p, double scale)
{
  return { scale * p[0], scale * p[1], scale * p[2] };
}

Mesh Times(Mesh mesh, double scale)
{
  for (Vec3& p : mesh.points)
  {
    p = Times(p, scale);
  }
  return mesh;
}

ClusterLevels LevelsOf(const Mesh& mesh, const LevelOptions& options)
{
  const KdTree tree = *BuildKdTree(mesh.points, { 100, {}, 2 });
  const auto partition = CellOfVertex(tree, tree.depths.partition);
  const TriangleBuckets buckets = BucketTriangles(mesh.triangles,
    std::size_t{ 1 } << tree.depths.partition, [&](VertexId v) { return partition[v]; });
  return *BuildLevels(mesh, tree, buckets, options);
}

void ExpectScaled(const ClusterLevels& one, const ClusterLevels& other, double scale)
{
  ASSERT_EQ(one.levels.size(), other.levels.size());
  for (std::size_t d = 0; d < one.levels.size(); ++d)
  {
    SCOPED_TRACE("level " + std::to_string(d));
    const ClusterLevel &a = one.levels[d], &b = other.levels[d];
    ASSERT_EQ(a.positions.size(), b.positions.size());
    EXPECT_EQ(a.parents, b.parents);
    EXPECT_EQ(a.triangles, b.triangles);
    for (std::size_t i = 0; i < a.positions.size(); ++i)
    {
      ASSERT_EQ(Times(a.positions[i], scale), b.positions[i]) << "cluster " << i;
      ASSERT_EQ(scale * a.geometricErrors[i], b.geometricErrors[i]) << "cluster " << i;
      ASSERT_TRUE(std::isfinite(static_cast<float>(b.geometricErrors[i]))) << "cluster " << i;
    }
  }
}

}

TEST(Extent, LevelsOfTheLargestMeshAreThoseOfASmallOne)
{
  std::vector<NamedMesh> meshes = AllMeshes();
  for (NamedMesh& named : meshes)
  {
    named.mesh = OnGrid(std::move(named.mesh));
  }
  meshes.push_back({ "cube", Cube() });
  meshes.push_back({ "large triangles", LargeTriangles(700, 5000) });
  meshes.push_back({ "all large", LargeTriangles(64, 200000) });
  for (const NamedMesh& named : meshes)
  {
    const Mesh largest = Times(named.mesh, mostExtent);
    for (const LevelMaker maker : { LevelMaker::Collapse, LevelMaker::Cluster })
    {
      SCOPED_TRACE(named.name + (maker == LevelMaker::Collapse ? ", collapse" : ", cluster"));
      LevelOptions options;
      options.maker = maker;
      ExpectScaled(LevelsOf(named.mesh, options), LevelsOf(largest, options), mostExtent);
    }
  }
}

TEST(Extent, WhatSpansMoreIsRefused)
{
  const double more = std::nextafter(mostExtent, INFINITY);
  for (std::size_t k = 0; k < 3; ++k)
  {
    Box box{ { 1, 2, 3 }, { 1, 2, 3 } };
    box.lo[k] = 0;
    box.hi[k] = mostExtent;
    EXPECT_TRUE(CheckExtent(box));
    for (const double hi : { more, 1e306, 1.7e308 })
    {
      box.hi[k] = hi;
      box.lo[k] = hi > more ? -hi : 0;
      const Status status = CheckExtent(box);
      EXPECT_TRUE(
        fixtures::FailsAt(status, ErrorCode::InvalidInput, std::string("along ") + "xyz"[k] + ","))
        << hi;
    }
  }
  EXPECT_TRUE(CheckExtent(Box{}));
  // Far away is not large.
  EXPECT_TRUE(CheckExtent({ { 1.7e308, 0, 0 }, { 1.7e308, 1, 1 } }));
}
