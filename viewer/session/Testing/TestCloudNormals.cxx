#include "viewer/session/CloudNormals.h"

#include "viewer/session/Geometry.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

namespace kdstream
{
namespace
{

Surface CloudOf(std::vector<Vec3> points)
{
  Surface cloud;
  cloud.sources.resize(points.size());
  cloud.points = std::move(points);
  return cloud;
}

Vec3 Widened(const std::array<float, 3>& v)
{
  return { v[0], v[1], v[2] };
}

TEST(CloudNormals, AreThoseOfAnyPlane)
{
  std::mt19937 random(5);
  std::normal_distribution<double> number;
  for (const double scale : { 1e-12, 1.0, 1e9 })
  {
    for (int plane = 0; plane < 20; ++plane)
    {
      const Vec3 normal = Normalized(Vec3{ number(random), number(random), number(random) });
      const Vec3 right = Normalized(Cross(normal, Vec3{ 1, 2, 3 }));
      const Vec3 up = Cross(normal, right);
      std::vector<Vec3> points;
      for (int i = 0; i < 200; ++i)
      {
        points.push_back((Vec3{ 5, 6, 7 } + right * number(random) + up * number(random)) * scale);
      }
      for (const auto& found : EstimateNormals(CloudOf(points)))
      {
        EXPECT_NEAR(std::abs(Dot(Widened(found), normal)), 1.0, 1e-5);
      }
    }
  }
}

TEST(CloudNormals, StandNoise)
{
  std::mt19937 random(6);
  std::uniform_real_distribution<double> place(0, 8), noise(-0.1, 0.1);
  std::vector<Vec3> points;
  for (int i = 0; i < 640; ++i)
  {
    points.push_back({ 8.0 * (i / 64) + place(random), place(random), noise(random) });
  }
  double worst = 1, sum = 0;
  for (const auto& found : EstimateNormals(CloudOf(points)))
  {
    worst = std::min<double>(worst, std::abs(found[2]));
    sum += std::abs(found[2]);
  }
  EXPECT_GT(worst, 0.85);
  EXPECT_GT(sum / 640, 0.99);
}

// On a ball, in runs of neighbours: within some degrees everywhere.
TEST(CloudNormals, FollowABall)
{
  std::vector<Vec3> points;
  for (int square = 0; square < 48; ++square)
  {
    for (int i = 0; i < 64; ++i)
    {
      const double u = (square % 8 * 8 + i % 8) / 64.0, v = (square / 8 * 8 + i / 8 + 0.5) / 48.0;
      const double height = 2 * v - 1, round = std::sqrt(1 - height * height);
      points.push_back({ round * std::cos(2 * M_PI * u), round * std::sin(2 * M_PI * u), height });
    }
  }
  const auto normals = EstimateNormals(CloudOf(points));
  double sum = 0;
  for (std::size_t i = 0; i < points.size(); ++i)
  {
    sum += std::abs(Dot(Widened(normals[i]), points[i]));
  }
  EXPECT_GT(sum / static_cast<double>(points.size()), 0.99);
}

TEST(CloudNormals, AreNothingWhereThereIsNoPlane)
{
  EXPECT_TRUE(EstimateNormals(Surface{}).empty());
  const Vec3 here{ 4e6, 5e6, 6e6 };
  std::vector<Vec3> line;
  for (int i = 0; i < 100; ++i)
  {
    line.push_back(here + Vec3{ 1, 2, -3 } * i);
  }
  for (const auto& points :
    { std::vector<Vec3>{ here }, std::vector<Vec3>(2, here), std::vector<Vec3>(100, here), line })
  {
    for (const auto& found : EstimateNormals(CloudOf(points)))
    {
      EXPECT_EQ(found, (std::array<float, 3>{ 0, 0, 0 }));
    }
  }
}

}
}
