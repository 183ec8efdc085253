// SPDX-License-Identifier: BSD-3-Clause
// Hits of rays on triangles, compared with a search that uses another formula.
#include "viewer/session/Picker.h"

#include "viewer/session/Testing/MemoryServer.h"
#include "viewer/session/ViewerSession.h"

#include <gtest/gtest.h>

#include <iostream>
#include <random>

using namespace kdstream;

namespace
{

// Finds where the ray meets the triangle's plane, then checks that the point is on the inner side
// of each edge.
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
  // Seen from the front and from behind; among equals the lowest index wins.
  for (const double side : { 1.0, -1.0 })
  {
    const auto hit = PickSurface(surface, { { 0.25, 0.25, side }, { 0, 0, -side } });
    ASSERT_TRUE(hit);
    EXPECT_EQ(hit->triangle, 0u);
    EXPECT_DOUBLE_EQ(hit->distance, 1);
  }
  // There is no gap on the common edge, nor on a corner.
  EXPECT_TRUE(PickSurface(surface, { { 0.5, 0.5, 1 }, { 0, 0, -1 } }));
  EXPECT_TRUE(PickSurface(surface, { { 0, 0, 1 }, { 0, 0, -1 } }));
  // No hit: behind the eye, beside the triangles, parallel to them, and without triangles.
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
  // The points' tangents from the ray are 0, 0.08 and 0.15; the last point is behind the eye.
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

TEST(TestPicker, FindsWhetherAClosedSurfaceIsAroundAPoint)
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

// The distance to points on a grid over the triangle, which are at most `step` apart.
double DistanceBySamples(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c, double& step)
{
  constexpr int count = 16;
  double nearest = 1e300;
  for (int i = 0; i <= count; ++i)
  {
    for (int j = 0; j <= count - i; ++j)
    {
      const Vec3 sample = a + (b - a) * (double(i) / count) + (c - a) * (double(j) / count);
      nearest = std::min(nearest, Length(p - sample));
    }
  }
  step = std::max(step, std::max(Length(b - a), Length(c - a)) / count);
  return nearest;
}

TEST(TestPicker, FindsTheNearestPointOfASurface)
{
  std::mt19937 random(11);
  std::uniform_real_distribution<double> unit(-1, 1);
  const auto point = [&] { return Vec3{ unit(random), unit(random), unit(random) }; };
  for (int trial = 0; trial < 60; ++trial)
  {
    Surface surface;
    for (VertexId i = 0; i < 50; ++i)
    {
      const Vec3 a = point(), b = a + point() * 0.4;
      surface.points.push_back(a);
      surface.points.push_back(i % 7 == 0 ? a : b); // degenerate triangles: an edge, or a corner
      surface.points.push_back(i % 14 == 0 ? a : i % 5 == 0 ? a + (b - a) * 2 : a + point() * 0.4);
      surface.triangles.push_back({ 3 * i, 3 * i + 1, 3 * i + 2 });
    }
    surface.sources.resize(surface.points.size());
    const DrawnSurface drawn(surface);
    for (int k = 0; k < 40; ++k)
    {
      const Vec3 from = point() * 2;
      double sampled = 1e300, step = 0;
      for (const Triangle& t : surface.triangles)
      {
        const auto& [i, j, m] = t;
        sampled = std::min(sampled,
          DistanceBySamples(from, surface.points[i], surface.points[j], surface.points[m], step));
      }
      const auto found = NearestOnSurface(drawn, from);
      ASSERT_TRUE(found);
      const double nearest = Length(found->point - from);
      EXPECT_EQ(found->distance, nearest);
      EXPECT_LE(nearest, sampled + 1e-12);
      EXPECT_GE(nearest, sampled - step);
      const auto enough = NearestOnSurface(drawn, from, 2 * nearest);
      ASSERT_TRUE(enough);
      EXPECT_LE(Length(enough->point - from), 2 * nearest);
    }
  }
}

TEST(TestPicker, FindsTheNearestPointOfACloud)
{
  Surface cloud;
  EXPECT_FALSE(NearestOnSurface(DrawnSurface(), {}));
  cloud.points = { { 0, 0, -10 }, { 0.4, 0, -5 }, { 0, 0, 3 } };
  cloud.sources.resize(3);
  EXPECT_EQ(NearestOnSurface(DrawnSurface(cloud), {})->point, cloud.points[2]);
  EXPECT_EQ(NearestOnSurface(DrawnSurface(cloud), { 1, 0, -6 })->point, cloud.points[1]);
}

// Tests every triangle of every part.
std::optional<SurfaceHit> PickByForce(const DrawnSurface& surface, const Ray& ray, double slack)
{
  std::optional<SurfaceHit> best;
  for (const DrawnSurface::Part& part : surface.Parts())
  {
    const auto hit = PickSurface(part.part->surface, ray, slack);
    if (hit && (!best || hit->distance < best->distance))
    {
      best = hit;
    }
  }
  return best;
}

// Rays from around a box, and from inside, towards its content: in a random direction, along an
// axis, or exactly at a vertex.
class Rays
{
public:
  explicit Rays(const Surface& whole)
    : Points(whole.points)
    , Bounds(BoundsOf(whole))
  {
  }
  Ray Next()
  {
    const Vec3 size = this->Bounds.hi - this->Bounds.lo;
    const auto inside = [&]
    {
      Vec3 point = this->Bounds.lo;
      for (std::size_t k = 0; k < 3; ++k)
      {
        point[k] += size[k] * this->Unit(this->Random);
      }
      return point;
    };
    const Vec3 middle = this->Bounds.lo * 0.5 + this->Bounds.hi * 0.5;
    const Vec3 from = middle + (inside() - middle) * (this->Random() % 4 == 0 ? 1 : 4);
    Vec3 at = inside();
    const auto kind = this->Random() % 4;
    if (kind == 0)
    {
      at = this->Points[this->Random() % this->Points.size()];
    }
    else if (kind == 1)
    {
      at = from;
      at[this->Random() % 3] += this->Random() % 2 == 0 ? 1 : -1;
    }
    return { from, Normalized(at - from) };
  }

private:
  const std::vector<Vec3>& Points;
  Box Bounds;
  std::mt19937 Random{ 7 };
  std::uniform_real_distribution<double> Unit{ 0, 1 };
};

// Returns the mean number of triangles, or points, visited for each ray. Checks that each hit is
// the same as if all were tested.
double VisitedByRays(const DrawnSurface& surface, double slack, std::size_t rays)
{
  Rays from(surface.Whole());
  std::size_t visited = 0, hits = 0;
  for (std::size_t i = 0; i < rays; ++i)
  {
    const Ray ray = from.Next();
    const auto here = PickSurface(surface, ray, slack, &visited);
    const auto there = PickByForce(surface, ray, slack);
    EXPECT_EQ(here.has_value(), there.has_value()) << i;
    if (here && there)
    {
      ++hits;
      EXPECT_EQ(here->distance, there->distance) << i;
      EXPECT_EQ(here->triangle, there->triangle) << i;
      EXPECT_EQ(here->point, there->point) << i;
    }
  }
  EXPECT_GT(hits, rays / 4);
  return static_cast<double>(visited) / static_cast<double>(rays);
}

// For a session's surface, which has one part for each piece.
TEST(TestPicker, TheTreeFindsWhatTheListHasAndVisitsLittleOfIt)
{
  kdstream::testing::MemoryServer server(kdstream::testing::MakeTorus(200, 80), 128, 2);
  SessionOptions options;
  options.refinement.tolerance = 0.2;
  ViewerSession session(options);
  session.Resize({ 800, 600, 1 });
  ASSERT_TRUE(session.SelectModel("torus"));
  session.EnterFullScreen();
  server.Serve(session);
  const DrawnSurface& surface = *session.Scene().surface;
  ASSERT_GT(surface.Parts().size(), 20u);
  ASSERT_GT(surface.TriangleCount(), 15000u);
  const double visited = VisitedByRays(surface, 0, 10000);
  EXPECT_LT(visited, 0.01 * static_cast<double>(surface.TriangleCount()));
  std::cout << visited << " of " << surface.TriangleCount() << " triangles\n";
}

// Slivers, degenerate triangles and equal ones, near the origin and far away from it.
TEST(TestPicker, TheTreeIsRightAboutTrianglesThatRoundingIsHardOn)
{
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(-1, 1);
  const auto anywhere = [&] { return Vec3{ unit(random), unit(random), unit(random) }; };
  for (const double offset : { 0.0, 5e6, 1e12 })
  {
    for (const double width : { 1e-3, 1e-9, 1e-13, 0.0 })
    {
      Surface surface;
      for (VertexId i = 0; i < 500; ++i)
      {
        const Vec3 a = anywhere() + Vec3{ offset, 0, 0 }, b = a + anywhere() * 2;
        surface.points.insert(
          surface.points.end(), { a, b, a * 0.5 + b * 0.5 + anywhere() * width });
        surface.triangles.push_back({ 3 * i, 3 * i + 1, 3 * i + 2 });
        if (i % 5 == 0)
        {
          surface.triangles.push_back(surface.triangles.back());
        }
      }
      Surface dense = surface; // with triangles that rays surely hit
      for (std::size_t i = 0; i + 9 < surface.points.size(); i += 7)
      {
        const auto v = static_cast<VertexId>(i);
        dense.triangles.push_back({ v, v + 3, v + 8 });
      }
      dense.sources.resize(dense.points.size());
      VisitedByRays(DrawnSurface(dense), 0, 500);
    }
  }
}

TEST(TestPicker, TheTreeFindsPointsOfCloudsThatAFingerCovers)
{
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(-1, 1);
  Surface cloud;
  for (int i = 0; i < 20000; ++i)
  {
    cloud.points.push_back(Normalized({ unit(random), unit(random), unit(random) }));
  }
  cloud.points.insert(cloud.points.end(), cloud.points.begin(), cloud.points.begin() + 1000);
  cloud.sources.resize(cloud.points.size());
  const DrawnSurface surface(cloud);
  EXPECT_LT(VisitedByRays(surface, 0.02, 2000), 0.05 * 21000);
}

}
