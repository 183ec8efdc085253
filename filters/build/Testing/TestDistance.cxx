// SPDX-License-Identifier: BSD-3-Clause
// What a store tells of its levels is no less than what samples of the input find: how far they are
// from the level that comes out of the store.
#include "Testing/Fixtures/Meshes.h"
#include "Testing/Fixtures/TemporaryFolder.h"
#include "filters/build/Builder.h"
#include "filters/core/VectorMath.h"
#include "filters/core/pieces/SurfaceBound.h"
#include "filters/program/TbbExecution.h"
#include "filters/store/StoreMesh.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

using namespace kdstream;
using namespace kdstream::fixtures;

namespace
{

struct Way
{
  std::string name;
  BuildOptions options;
};

std::vector<Way> Ways()
{
  BuildOptions usual;
  usual.tree.verticesPerPartition = 150;
  std::vector<Way> ways{ { "collapse", usual }, { "lossless", usual }, { "clusters", usual },
    { "coarse grid", usual } };
  ways[1].options.bits = 0;
  ways[1].options.weld = false;
  ways[2].options.levels.maker = LevelMaker::Cluster;
  ways[3].options.bits = 8;
  return ways;
}

// Bodies of all sizes far from each other: the small ones vanish first.
Mesh Scattered()
{
  Mesh mesh = DisplacedSphere(5);
  for (unsigned i = 0; i < 12; ++i)
  {
    const double radius = 0.3 / (i + 1);
    const Mesh body =
      DisplacedSphere(i < 4 ? 2 : 0, { 2 + 0.8 * i, 0.1 * i * i, -1.0 * i }, radius);
    const auto first = static_cast<VertexId>(mesh.points.size());
    mesh.points.insert(mesh.points.end(), body.points.begin(), body.points.end());
    for (const Triangle& t : body.triangles)
    {
      mesh.triangles.push_back({ first + t[0], first + t[1], first + t[2] });
    }
  }
  return mesh;
}

}

class TestDistance : public ::testing::Test
{
protected:
  TemporaryFolder Folder;

  std::shared_ptr<Store> Build(const Mesh& mesh, const BuildOptions& options)
  {
    const std::filesystem::path file = this->Folder / "model.kds";
    const auto report = BuildStore(mesh, "mesh.ply", file, options, MakeTbbExecution(2));
    EXPECT_TRUE(report) << report.GetError().message;
    return *Store::Open(file);
  }

  static Mesh LevelOf(const Store& store, unsigned depth)
  {
    return *DrawStoreMesh(store, { store.Info().depths, Resolution::Level(depth) });
  }

  // The farthest of some random points of the input, and its vertices if it has no triangles.
  static double Sample(const Mesh& input, const Mesh& level, unsigned samples)
  {
    std::vector<Triangle> triangles = level.triangles;
    for (VertexId v = 0; v < level.points.size() && level.triangles.empty(); ++v)
    {
      triangles.push_back({ v, v, v });
    }
    const SearchedPart target(level.points, triangles);
    std::mt19937 random(samples);
    std::uniform_real_distribution<double> unit(0, 1);
    double farthest = 0;
    for (unsigned i = 0; i < samples; ++i)
    {
      Vec3 place = input.points[random() % input.points.size()];
      if (!input.triangles.empty())
      {
        const Triangle& t = input.triangles[random() % input.triangles.size()];
        const double r = unit(random), s = unit(random) * (1 - r);
        for (std::size_t k = 0; k < 3; ++k)
        {
          place[k] = input.points[t[0]][k] * (1 - r - s) + input.points[t[1]][k] * r +
                     input.points[t[2]][k] * s;
        }
      }
      double squared = INFINITY;
      target.Nearest(place, 0, squared);
      farthest = std::max(farthest, std::sqrt(squared));
    }
    return farthest;
  }
};

TEST_F(TestDistance, IsNoMoreThanAnyLevelTells)
{
  std::vector<NamedMesh> meshes = AllMeshes();
  meshes.push_back({ "scattered", Scattered() });
  meshes.push_back({ "tetrahedra", Tetrahedra(800) });
  for (const NamedMesh& named : meshes)
  {
    for (const Way& way : Ways())
    {
      const std::shared_ptr<Store> store = this->Build(named.mesh, way.options);
      for (unsigned depth = 0; depth < store->Info().levels.size(); ++depth)
      {
        SCOPED_TRACE(named.name + ", " + way.name + ", level " + std::to_string(depth));
        const Mesh level = LevelOf(*store, depth);
        ASSERT_FALSE(level.points.empty());
        const Box box = store->Info().box;
        const double rounded = 1e-14 * (Length(Minus(box.hi, box.lo)) + Length(box.hi));
        EXPECT_GE(store->Info().levels[depth].deviation * (1 + 1e-9) + rounded,
          Sample(named.mesh, level, 300));
      }
    }
  }
}

TEST_F(TestDistance, OfWhatVanishesCounts)
{
  const Mesh mesh = Scattered();
  const auto store = this->Build(mesh, Ways()[0].options);
  const double sampled = Sample(mesh, LevelOf(*store, 5), 50000);
  const Box box = store->Info().box;
  EXPECT_GT(sampled, 0.05 * Length(Minus(box.hi, box.lo)));
  EXPECT_GE(store->Info().levels[5].deviation, sampled);
  EXPECT_LE(store->Info().levels[5].deviation99, sampled / 2) << "viewers steer by this";
}

TEST_F(TestDistance, IsNotMuchLessThanLevelsTell)
{
  for (const NamedMesh& named : ClosedMeshes())
  {
    BuildOptions options = Ways()[0].options;
    options.bits = 20;
    const auto store = this->Build(named.mesh, options);
    for (unsigned depth = 6; depth < store->Info().levels.size(); ++depth)
    {
      SCOPED_TRACE(named.name + ", level " + std::to_string(depth));
      const Mesh level = LevelOf(*store, depth);
      const double spacing = SearchedPart(level.points, level.triangles).Spacing();
      const double sampled = Sample(named.mesh, level, 10000);
      EXPECT_LE(store->Info().levels[depth].deviation, 2 * sampled + 0.75 * spacing);
    }
  }
}
