// SPDX-License-Identifier: BSD-3-Clause
#include "Testing/Fixtures/ErrorAt.h"
#include "filters/core/Testing/BuiltLevels.h"

#include <gtest/gtest.h>

using namespace kdstream;
using namespace kdstream::fixtures;

TEST(CollapseTo, MeetsAnyTarget)
{
  for (const NamedMesh& named : MeshesToCollapse())
  {
    SCOPED_TRACE(named.name);
    const BuiltLevels built = BuildAllLevels(named.mesh);
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
  const BuiltLevels built = BuildAllLevels(sphere);
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
  EXPECT_TRUE(
    FailsAt(CollapseTo(sphere, built.tree, built.buckets, {}, {}), ErrorCode::InvalidArgument));
}
