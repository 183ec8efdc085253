// SPDX-License-Identifier: BSD-3-Clause
// Rays against triangles, compared with a search by another formula.
#include "viewer/session/Picker.h"

#include <gtest/gtest.h>

#include <random>

using namespace kdstream;

namespace
{

// Meets the triangle's plane, then asks on which sides of the edges the point lies.
std::optional<double> MeetByPlane(const Ray& ray, const Vec3& a, const Vec3& b, const Vec3& c)
{
  const Vec3 normal = Cross(b - a, c - a);
  const double slope = Dot(normal, ray.direction);
  if (slope == 0)
  {
    return std::nullopt;
  }
  const double t = Dot(normal, a - ray.origin) / slope;
  const Vec3 p = ray.origin + ray.direction * t;
  const bool inside = Dot(Cross(b - a, p - a), normal) >= 0 &&
                      Dot(Cross(c - b, p - b), normal) >= 0 &&
                      Dot(Cross(a - c, p - c), normal) >= 0;
  return inside && t > 0 ? std::optional(t) : std::nullopt;
}

TEST(TestPicker, FindsTheNearestOfRandomTriangles)
{
  std::mt19937 random(4);
  std::uniform_real_distribution<double> unit(-1, 1);
  const auto point = [&] { return Vec3{ unit(random), unit(random), unit(random) }; };
  std::size_t hits = 0;
  for (int trial = 0; trial < 100; ++trial)
  {
    Surface surface;
    for (VertexId i = 0; i < 60; ++i)
    {
      const Vec3 a = point();
      surface.points.push_back(a);
      surface.points.push_back(a + point() * 0.4);
      surface.points.push_back(a + point() * 0.4);
      surface.triangles.push_back({ 3 * i, 3 * i + 1, 3 * i + 2 });
    }
    for (int k = 0; k < 20; ++k)
    {
      const Ray ray{ point() * 2, Normalized(point()) };
      std::optional<double> nearest;
      for (const Triangle& t : surface.triangles)
      {
        const auto meet =
          MeetByPlane(ray, surface.points[t[0]], surface.points[t[1]], surface.points[t[2]]);
        nearest = meet && (!nearest || *meet < *nearest) ? meet : nearest;
      }
      const auto hit = PickSurface(surface, ray);
      ASSERT_EQ(hit.has_value(), nearest.has_value());
      if (hit)
      {
        ++hits;
        EXPECT_NEAR(hit->distance, *nearest, 1e-9);
        EXPECT_NEAR(Length(hit->point - (ray.origin + ray.direction * *nearest)), 0, 1e-9);
      }
    }
  }
  EXPECT_GT(hits, 100u) << hits;
}

TEST(TestPicker, HardTriangles)
{
  Surface surface;
  surface.points = { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 }, { 1, 1, 0 } };
  surface.triangles = { { 0, 1, 2 }, { 1, 3, 2 }, { 0, 0, 1 }, { 0, 1, 2 } };
  // From in front and from behind; the lowest index of equals.
  for (const double side : { 1.0, -1.0 })
  {
    const auto hit = PickSurface(surface, { { 0.25, 0.25, side }, { 0, 0, -side } });
    ASSERT_TRUE(hit);
    EXPECT_EQ(hit->triangle, 0u);
    EXPECT_DOUBLE_EQ(hit->distance, 1);
  }
  // On the common edge, on a corner: no gap.
  EXPECT_TRUE(PickSurface(surface, { { 0.5, 0.5, 1 }, { 0, 0, -1 } }));
  EXPECT_TRUE(PickSurface(surface, { { 0, 0, 1 }, { 0, 0, -1 } }));
  // Behind the eye, beside, parallel, and nothing at all.
  EXPECT_FALSE(PickSurface(surface, { { 0.25, 0.25, -1 }, { 0, 0, -1 } }));
  EXPECT_FALSE(PickSurface(surface, { { 2, 2, 1 }, { 0, 0, -1 } }));
  EXPECT_FALSE(PickSurface(surface, { { -1, 0.25, 0 }, { 1, 0, 0 } }));
  EXPECT_FALSE(PickSurface(Surface{}, { { 0, 0, 1 }, { 0, 0, -1 } }));
}

TEST(TestPicker, FindsTheNearestPointOfACloudThatAFingerCovers)
{
  Surface cloud;
  cloud.points = { { 0, 0, -10 }, { 0.4, 0, -5 }, { 0, 0.6, -4 }, { 0, 0, 3 } };
  const Ray ray{ { 0, 0, 0 }, { 0, 0, -1 } };
  // Tangents to the ray: 0, 0.08, 0.15; the last is behind the eye.
  EXPECT_EQ(PickSurface(cloud, ray, 0)->triangle, 0u);
  EXPECT_EQ(PickSurface(cloud, ray, 0.07)->triangle, 0u);
  const auto hit = PickSurface(cloud, ray, 0.09);
  ASSERT_TRUE(hit);
  EXPECT_EQ(hit->triangle, 1u);
  EXPECT_EQ(hit->point, cloud.points[1]);
  EXPECT_EQ(hit->distance, 5);
  EXPECT_EQ(PickSurface(cloud, ray, 0.16)->triangle, 2u);
  EXPECT_FALSE(PickSurface(cloud, { { 5, 5, 0 }, { 0, 0, -1 } }, 0.1));
  EXPECT_FALSE(PickSurface(Surface{}, ray, 1));
  // A surface with triangles is not picked by its points.
  cloud.triangles = { { 0, 1, 2 } };
  EXPECT_FALSE(PickSurface(cloud, { { -0.1, 0, 0 }, { 0, 0, -1 } }, 0.5));
}

TEST(TestPicker, TellsWhetherAClosedSurfaceIsAroundAPoint)
{
  Surface octahedron;
  octahedron.points = { { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 }, { -1, 0, 0 }, { 0, -1, 0 },
    { 0, 0, -1 } };
  octahedron.triangles = { { 0, 1, 2 }, { 1, 3, 2 }, { 3, 4, 2 }, { 4, 0, 2 }, { 1, 0, 5 },
    { 3, 1, 5 }, { 4, 3, 5 }, { 0, 4, 5 } };
  octahedron.sources.resize(6);
  const DrawnSurface surface(octahedron);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> any(-1, 1);
  for (int i = 0; i < 2000; ++i)
  {
    const Vec3 point{ any(random), any(random), any(random) };
    const double away = std::abs(point[0]) + std::abs(point[1]) + std::abs(point[2]);
    EXPECT_EQ(IsAround(surface, point), away < 1);
  }
  EXPECT_TRUE(IsAround(surface, {})) << "rays through edges and corners";
  EXPECT_FALSE(IsAround(DrawnSurface(), {}));
}

}
