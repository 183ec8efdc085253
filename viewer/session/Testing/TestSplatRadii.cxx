// SPDX-License-Identifier: BSD-3-Clause
#include "viewer/session/appearance/SplatRadii.h"

#include "filters/core/tree/KdTree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace kdstream
{
namespace
{

void Add(Surface& cloud, const Vec3& point, Resolution resolution = Resolution::Original())
{
  cloud.points.push_back(point);
  cloud.sources.push_back({ resolution, 0 });
}

// Adds squares of 8 x 8 points, one after the other, as the k-d tree orders points.
void AddSquares(Surface& cloud, int squares, double spacing, double y, Resolution resolution)
{
  for (int i = 0; i < 64 * squares; ++i)
  {
    Add(cloud, { (i / 64 * 8 + i % 8) * spacing, y + (i / 8 % 8) * spacing, 0.0 }, resolution);
  }
}

TEST(SplatRadii, CloseUpSquareGrids)
{
  for (const double spacing : { 1e-9, 0.5, 3e6 })
  {
    Surface cloud;
    AddSquares(cloud, 10, spacing, 0, Resolution::Original());
    for (const float radius : SplatRadii(cloud))
    {
      // At least half a diagonal, so that there are no gaps.
      EXPECT_GT(radius, 0.7072 * spacing);
      EXPECT_LT(radius, spacing);
    }
  }
}

TEST(SplatRadii, CloseUpScatteredPoints)
{
  std::mt19937 random(3);
  std::uniform_real_distribution<double> place(0.0, 8.0);
  Surface cloud;
  for (int square = 0; square < 50; ++square)
  {
    for (int i = 0; i < 64; ++i)
    {
      Add(cloud, { 8.0 * square + place(random), place(random), 0.0 });
    }
  }
  const std::vector<float> radii = SplatRadii(cloud);
  // Counts the places of the plane, away from its border, that no splat covers.
  std::uniform_real_distribution<double> along(8.0, 392.0), across(1.0, 7.0);
  int holes = 0;
  for (int i = 0; i < 2000; ++i)
  {
    const Vec3 at{ along(random), across(random), 0.0 };
    bool covered = false;
    for (std::size_t k = 0; k < radii.size() && !covered; ++k)
    {
      covered = std::hypot(cloud.points[k][0] - at[0], cloud.points[k][1] - at[1]) <= radii[k];
    }
    holes += covered ? 0 : 1;
  }
  EXPECT_LT(holes, 2000 / 6);
  EXPECT_LT(*std::max_element(radii.begin(), radii.end()), 1.3);
}

TEST(SplatRadii, FollowTheResolution)
{
  Surface cloud;
  AddSquares(cloud, 3, 1.0, 0, Resolution::Level(9));
  AddSquares(cloud, 3, 0.1, 20, Resolution::Original());
  const std::vector<float> radii = SplatRadii(cloud);
  EXPECT_NEAR(radii.front() / radii.back(), 10.0, 1e-4);
  EXPECT_EQ(radii[3 * 64 - 1], radii.front());
  EXPECT_EQ(radii[3 * 64], radii.back());
}

// The density may change within a resolution, but a stray run does not get huge splats, and a run
// of coincident points does not vanish.
TEST(SplatRadii, HoldStrayPointsBack)
{
  Surface cloud;
  AddSquares(cloud, 5, 1.0, 0, Resolution::Original());
  AddSquares(cloud, 1, 3.0, 100, Resolution::Original());
  AddSquares(cloud, 1, 1000.0, 200, Resolution::Original());
  for (int i = 0; i < 64; ++i)
  {
    Add(cloud, { 5, 5, 5 });
  }
  Add(cloud, { 1e6, 1e6, 1e6 });
  const std::vector<float> radii = SplatRadii(cloud);
  const float usual = radii.front();
  EXPECT_NEAR(radii[5 * 64], 3 * usual, 1e-4);
  EXPECT_NEAR(radii[6 * 64], 4 * usual, 1e-4);
  EXPECT_NEAR(radii[7 * 64], usual / 4, 1e-4);
  EXPECT_NEAR(radii[8 * 64], usual / 4, 1e-4);
}

// A scanned ball of uniform density. Where the tree's order jumps from one side to the other, a run
// has points of both sides.
Surface BallInTreeOrder(std::size_t count)
{
  std::mt19937 random(11);
  std::normal_distribution<double> normal;
  std::vector<Vec3> points;
  for (std::size_t i = 0; i < count; ++i)
  {
    const Vec3 way{ normal(random), normal(random), normal(random) };
    const double length = std::hypot(way[0], way[1], way[2]);
    points.push_back({ way[0] / length, way[1] / length, way[2] / length });
  }
  const Result<KdTree> tree = BuildKdTree(points, {});
  Surface cloud;
  for (const VertexId id : tree->order)
  {
    Add(cloud, points[id]);
  }
  return cloud;
}

float LargestToMiddle(std::vector<float> radii)
{
  std::sort(radii.begin(), radii.end());
  return radii.back() / radii[radii.size() / 2];
}

TEST(SplatRadii, NoRunAcrossCellsIsABalloon)
{
  for (const std::size_t count : { 40'000, 40'003, 39'873, 65'536 })
  {
    EXPECT_LT(LargestToMiddle(SplatRadii(BallInTreeOrder(count))), 1.5F) << count;
  }
}

// A few points of one resolution among those of another, as at the borders in a cut.
TEST(SplatRadii, ShortRunsAreDrawnAsTheirNeighbours)
{
  Surface cloud = BallInTreeOrder(40'000);
  std::mt19937 random(5);
  for (std::size_t i = 0; i < cloud.points.size();)
  {
    const bool original = random() % 2 == 0;
    for (std::size_t end = i + 1 + random() % 300; i < end && i < cloud.points.size(); ++i)
    {
      cloud.sources[i].resolution = original ? Resolution::Original() : Resolution::Level(13);
    }
  }
  EXPECT_LT(LargestToMiddle(SplatRadii(cloud)), 1.5F);
}

TEST(SplatRadii, OfPartsAreThoseOfTheWhole)
{
  const Surface ball = BallInTreeOrder(5'000);
  SurfacePartList parts;
  std::vector<PartNormals::Normals> normals;
  for (std::size_t begin = 0; begin < ball.points.size(); begin += 700)
  {
    const std::size_t count = std::min<std::size_t>(700, ball.points.size() - begin);
    const auto first = static_cast<std::ptrdiff_t>(begin), last = first + std::ptrdiff_t(count);
    SurfacePart part;
    part.piece.node = static_cast<NodeId>(begin);
    part.surface.points.assign(ball.points.begin() + first, ball.points.begin() + last);
    part.surface.sources.assign(ball.sources.begin() + first, ball.sources.begin() + last);
    part.own.resize(count);
    parts.push_back(std::make_shared<const SurfacePart>(std::move(part)));
    normals.push_back(std::make_shared<const std::vector<Vec3>>(count));
  }
  EXPECT_EQ(SplatRadii(DrawnSurface(parts, normals)), SplatRadii(ball));
}

TEST(SplatRadii, AreFiniteForAnyCloud)
{
  EXPECT_TRUE(SplatRadii(Surface{}).empty());
  Surface cloud;
  Add(cloud, { 4e6, 5e6, 6e6 });
  EXPECT_EQ(SplatRadii(cloud), std::vector<float>{ 0 });
  Add(cloud, { 4e6, 5e6, 6e6 });
  EXPECT_EQ(SplatRadii(cloud), (std::vector<float>{ 0, 0 }));
  Add(cloud, { 4e6, 5e6, 6e6 + 2 });
  Add(cloud, { 4e6, 5e6, 6e6 - 1 }, Resolution::Level(3));
  for (const float radius : SplatRadii(cloud))
  {
    EXPECT_GE(radius, 0);
    EXPECT_TRUE(std::isfinite(radius));
  }
}

}
}
