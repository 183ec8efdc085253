// SPDX-License-Identifier: BSD-3-Clause
// The lights on a sphere: how bright each slope is, and how much the brightness changes from slope
// to slope.
#include "viewer/session/Geometry.h"
#include "viewer/session/appearance/SceneAppearance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace kdstream
{
namespace
{

// The shading of a place with a given normal, without highlights. light: 1 shows its full colour.
// relief: the steepest relative change of the light when the normal turns, for a radian.
struct Shade
{
  double light, relief;
};

Shade ShadeOf(const Vec3& normal)
{
  double light = sceneMaterial.ambient;
  Vec3 change{ 0, 0, 0 };
  for (const SceneLight& lightSource : sceneLights)
  {
    const Vec3 direction = Normalized(lightSource.position);
    const double facing = Dot(normal, direction);
    if (facing > 0)
    {
      light += sceneMaterial.diffuse * lightSource.intensity * facing;
      change =
        change + (direction - normal * facing) * (sceneMaterial.diffuse * lightSource.intensity);
    }
  }
  return { light, Length(change) / light };
}

bool IsAwayFromKey(const Vec3& normal)
{
  return Dot(normal, sceneLights[0].position) <= 0;
}

// The normals of the visible part of a sphere, without its outline.
std::vector<Vec3> SeenNormals()
{
  std::vector<Vec3> normals;
  for (double x = -1; x <= 1; x += 0.02)
  {
    for (double y = -1; y <= 1; y += 0.02)
    {
      if (x * x + y * y < 0.97)
      {
        normals.push_back({ x, y, std::sqrt(1 - x * x - y * y) });
      }
    }
  }
  return normals;
}

// One side is lit, and another one is not.
TEST(SceneAppearance, NothingIsBlackAndNothingIsBlown)
{
  double darkest = 2, brightestAway = 0, brightest = 0;
  for (const Vec3& normal : SeenNormals())
  {
    const double light = ShadeOf(normal).light;
    darkest = std::min(darkest, light);
    brightest = std::max(brightest, light);
    brightestAway = std::max(brightestAway, IsAwayFromKey(normal) ? light : 0);
  }
  EXPECT_GE(darkest, 0.14);
  EXPECT_LE(brightest, 1.05);
  EXPECT_LT(brightestAway, 0.5 * brightest);
}

// On the sides away from the key light, the light changes by at least 40 % a radian at nine of ten
// places, and by at least 70 % at half of them: as on the lit side.
TEST(SceneAppearance, SidesAwayFromTheKeyLightShowRelief)
{
  std::vector<double> dark, bright;
  for (const Vec3& normal : SeenNormals())
  {
    (IsAwayFromKey(normal) ? dark : bright).push_back(ShadeOf(normal).relief);
  }
  ASSERT_GT(dark.size(), 500U);
  std::sort(dark.begin(), dark.end());
  std::sort(bright.begin(), bright.end());
  EXPECT_GE(dark[dark.size() / 10], 0.4);
  EXPECT_GE(dark[dark.size() / 2], 0.7);
  EXPECT_GE(dark[dark.size() / 2], 0.9 * bright[bright.size() / 2]);
}

}
}
