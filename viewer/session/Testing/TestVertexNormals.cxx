// SPDX-License-Identifier: BSD-3-Clause
#include "viewer/session/appearance/VertexNormals.h"

#include <gtest/gtest.h>

#include <cmath>

namespace kdstream
{
namespace
{

void ExpectNear(const std::array<float, 3>& normal, double x, double y, double z)
{
  EXPECT_NEAR(normal[0], x, 1e-6);
  EXPECT_NEAR(normal[1], y, 1e-6);
  EXPECT_NEAR(normal[2], z, 1e-6);
}

TEST(VertexNormals, FollowTheOrientationOfATriangle)
{
  const std::vector<Vec3> points{ { 0, 0, 0 }, { 2, 0, 0 }, { 0, 3, 0 } };
  const std::vector<Triangle> up{ { 0, 1, 2 } };
  const std::vector<Triangle> down{ { 0, 2, 1 } };
  for (std::size_t i = 0; i < 3; ++i)
  {
    ExpectNear(ComputeVertexNormals(points, up)[i], 0, 0, 1);
    ExpectNear(ComputeVertexNormals(points, down)[i], 0, 0, -1);
  }
}

TEST(VertexNormals, WeightByArea)
{
  // At the origin there are a triangle of area 6 in the xy plane and one of area 2 in the yz plane.
  const std::vector<Vec3> points{ { 0, 0, 0 }, { 3, 0, 0 }, { 0, 4, 0 }, { 0, 0, 1 } };
  const std::vector<Triangle> triangles{ { 0, 1, 2 }, { 0, 2, 3 } };
  const double length = std::hypot(6.0, 2.0);
  ExpectNear(ComputeVertexNormals(points, triangles)[0], 2.0 / length, 0, 6.0 / length);
}

TEST(VertexNormals, AreZeroWhereThereIsNoDirection)
{
  const std::vector<Vec3> points{ { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 }, { 5, 5, 5 }, { 2, 2, 2 },
    { 3, 3, 3 } };
  // Two triangles back to back, and one without area.
  const std::vector<Triangle> triangles{ { 0, 1, 2 }, { 0, 2, 1 }, { 3, 4, 5 } };
  for (const auto& normal : ComputeVertexNormals(points, triangles))
  {
    ExpectNear(normal, 0, 0, 0);
  }
  EXPECT_TRUE(ComputeVertexNormals({}, {}).empty());
}

TEST(VertexNormals, DoNotDependOnOriginOrUnit)
{
  const std::vector<Vec3> points{ { 0, 0, 0 }, { 1, 0.5, 0 }, { 0.25, 1, 0.75 }, { -1, 0.5, 1 } };
  const std::vector<Triangle> triangles{ { 0, 1, 2 }, { 0, 2, 3 } };
  const auto expected = ComputeVertexNormals(points, triangles);
  std::vector<Vec3> moved = points;
  for (Vec3& p : moved)
  {
    p = { p[0] + 4194304.0, p[1] - 8388608.0, p[2] + 16777216.0 };
  }
  EXPECT_EQ(ComputeVertexNormals(moved, triangles), expected);
  for (const double unit : { 0x1p-300, 0x1p300 })
  {
    std::vector<Vec3> scaled = points;
    for (Vec3& p : scaled)
    {
      p = { p[0] * unit, p[1] * unit, p[2] * unit };
    }
    EXPECT_EQ(ComputeVertexNormals(scaled, triangles), expected) << unit;
  }
}

}
}
