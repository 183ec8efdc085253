// SPDX-License-Identifier: BSD-3-Clause
// Cutting polygons into triangles. A slow second method checks at random places that the triangles
// fill exactly the polygon. Areas add up, convex polygons become fans, and no input hangs or loses
// a triangle.
#include "filters/core/CutPolygon.h"

#include "filters/core/VectorMath.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <string>

namespace kdstream
{
namespace
{

using Flat = std::array<double, 2>;

double AreaOf(const Flat& a, const Flat& b, const Flat& c)
{
  return ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])) / 2;
}

double AreaOf(const std::vector<Flat>& polygon)
{
  double sum = 0;
  for (std::size_t i = 2; i < polygon.size(); ++i)
  {
    sum += AreaOf(polygon[0], polygon[i - 1], polygon[i]);
  }
  return sum;
}

bool IsIn(const std::vector<Flat>& polygon, const Flat& p)
{
  bool in = false;
  for (std::size_t i = 0; i < polygon.size(); ++i)
  {
    const Flat &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    if ((a[1] > p[1]) != (b[1] > p[1]) &&
        p[0] < a[0] + (b[0] - a[0]) * (p[1] - a[1]) / (b[1] - a[1]))
    {
      in = !in;
    }
  }
  return in;
}

// Moves the polygon into a tilted plane far from the origin. bump: how far corners are off that
// plane.
std::vector<Vec3> InSpace(const std::vector<Flat>& polygon, unsigned seed, double bump = 0)
{
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  const auto any = [&]() { return Vec3{ normal(random), normal(random), normal(random) }; };
  Vec3 u = any(), v = any();
  u = Times(u, 1 / Length(u));
  v = Minus(v, Times(u, Dot(u, v)));
  v = Times(v, 1 / Length(v));
  const Vec3 w = Cross(u, v);
  const Vec3 origin = Times(any(), 10);
  std::vector<Vec3> placed;
  for (const Flat& p : polygon)
  {
    const Vec3 flat = Plus(origin, Plus(Times(u, p[0]), Times(v, p[1])));
    placed.push_back(Plus(flat, Times(w, bump * normal(random))));
  }
  return placed;
}

// Expects the triangles to fill the polygon exactly once.
void ExpectFilled(const std::vector<Flat>& polygon, const std::vector<Vec3>& corners,
  const std::string& what, double tolerance = 1e-9)
{
  SCOPED_TRACE(what);
  PolygonCutter cutter;
  const std::span<const Triangle> cut = cutter.Cut(corners);
  ASSERT_EQ(cut.size(), polygon.size() - 2);
  const double whole = AreaOf(polygon);
  double sum = 0;
  std::vector<int> used(polygon.size(), 0);
  for (const Triangle& t : cut)
  {
    const double area = AreaOf(polygon[t[0]], polygon[t[1]], polygon[t[2]]);
    EXPECT_GE(area, -tolerance * whole);
    sum += std::abs(area);
    for (const VertexId corner : t)
    {
      used[corner] = 1;
    }
  }
  EXPECT_NEAR(sum, whole, tolerance * whole);
  EXPECT_EQ(std::count(used.begin(), used.end(), 1), std::ptrdiff_t(polygon.size()));
  Flat lo = polygon[0], hi = polygon[0];
  for (const Flat& p : polygon)
  {
    lo = { std::min(lo[0], p[0]), std::min(lo[1], p[1]) };
    hi = { std::max(hi[0], p[0]), std::max(hi[1], p[1]) };
  }
  std::mt19937 random(unsigned(polygon.size()));
  std::uniform_real_distribution<double> any(0, 1);
  const std::size_t samples = polygon.size() > 1000 ? 10 : 100;
  for (std::size_t i = 0; i < samples; ++i)
  {
    const Flat p{ lo[0] + any(random) * (hi[0] - lo[0]), lo[1] + any(random) * (hi[1] - lo[1]) };
    int over = 0;
    for (const Triangle& t : cut)
    {
      const Flat &a = polygon[t[0]], &b = polygon[t[1]], &c = polygon[t[2]];
      over += AreaOf(a, b, p) > 0 && AreaOf(b, c, p) > 0 && AreaOf(c, a, p) > 0 ? 1 : 0;
    }
    EXPECT_EQ(over, IsIn(polygon, p) ? 1 : 0) << p[0] << " " << p[1];
  }
}

std::vector<Flat> Star(std::size_t count, std::mt19937& random)
{
  std::uniform_real_distribution<double> radius(0.1, 1);
  std::vector<Flat> star;
  for (std::size_t i = 0; i < count; ++i)
  {
    const double angle = 2 * std::numbers::pi * double(i) / double(count), r = radius(random);
    star.push_back({ r * std::cos(angle), r * std::sin(angle) });
  }
  return star;
}

// Random points, joined to a polygon. Crossing sides are exchanged until no sides cross.
std::vector<Flat> Untangled(std::size_t count, std::mt19937& random)
{
  std::uniform_real_distribution<double> any(0, 1);
  std::vector<Flat> polygon;
  for (std::size_t i = 0; i < count; ++i)
  {
    polygon.push_back({ any(random), any(random) });
  }
  const auto crosses = [&](std::size_t i, std::size_t j)
  {
    const Flat &a = polygon[i], &b = polygon[i + 1];
    const Flat &c = polygon[j], &d = polygon[(j + 1) % count];
    return AreaOf(a, b, c) * AreaOf(a, b, d) < 0 && AreaOf(c, d, a) * AreaOf(c, d, b) < 0;
  };
  for (bool crossed = true; crossed;)
  {
    crossed = false;
    for (std::size_t i = 0; i + 2 < count; ++i)
    {
      for (std::size_t j = i + 2; j < count; ++j)
      {
        if (crosses(i, j))
        {
          std::reverse(
            polygon.begin() + std::ptrdiff_t(i) + 1, polygon.begin() + std::ptrdiff_t(j) + 1);
          crossed = true;
        }
      }
    }
  }
  if (AreaOf(polygon) < 0)
  {
    std::reverse(polygon.begin(), polygon.end());
  }
  return polygon;
}

// A comb with long, thin, leaning teeth.
std::vector<Flat> Comb(std::size_t teeth)
{
  std::vector<Flat> comb{ { double(teeth), -1 }, { double(teeth), 0 } };
  for (std::size_t i = teeth; i-- > 0;)
  {
    comb.push_back({ double(i) + 0.6 + double(teeth), double(teeth) });
    comb.push_back({ double(i), 0 });
  }
  comb.push_back({ 0, -1 });
  return comb;
}

// A square spiral.
std::vector<Flat> Spiral(std::size_t turns)
{
  std::vector<Flat> outside, inside;
  constexpr std::array<Flat, 4> directions{ { { 1, -1 }, { 1, 1 }, { -1, 1 }, { -1, -1 } } };
  for (std::size_t i = 0; i < 4 * turns; ++i)
  {
    const double far = double(i / 4) + 1 + double(i % 4) / 4;
    const Flat& d = directions[i % 4];
    outside.push_back({ d[0] * (far + 0.1), d[1] * (far + 0.1) });
    inside.push_back({ d[0] * far, d[1] * far });
  }
  outside.insert(outside.end(), inside.rbegin(), inside.rend());
  if (AreaOf(outside) < 0)
  {
    std::reverse(outside.begin(), outside.end());
  }
  return outside;
}

TEST(CutPolygon, FillsRandomSimplePolygons)
{
  std::mt19937 random(3);
  for (unsigned seed = 0; seed < 300; ++seed)
  {
    const std::size_t count = 4 + seed % 60;
    const std::vector<Flat> star = Star(count, random), untangled = Untangled(count, random);
    for (const double bump : { 0.0, 0.01 })
    {
      const std::string what = std::to_string(seed) + ", off by " + std::to_string(bump);
      if (bump == 0)
      {
        ExpectFilled(star, InSpace(star, seed), "star " + what, 2e-6);
        ExpectFilled(untangled, InSpace(untangled, seed), "untangled " + what, 2e-6);
      }
      else
      {
        // The projection is not the flat polygon, but no triangle is lost.
        PolygonCutter cutter;
        EXPECT_EQ(cutter.Cut(InSpace(star, seed, bump)).size(), count - 2);
        EXPECT_EQ(cutter.Cut(InSpace(untangled, seed, bump)).size(), count - 2);
      }
    }
  }
}

TEST(CutPolygon, FillsCombsAndSpirals)
{
  for (const std::size_t count : { 1, 2, 5, 40, 1000 })
  {
    ExpectFilled(Comb(count), InSpace(Comb(count), 1), "comb " + std::to_string(count), 2e-6);
    ExpectFilled(Spiral(count), InSpace(Spiral(count), 2), "spiral " + std::to_string(count), 2e-6);
  }
}

TEST(CutPolygon, FillsPolygonsOfVeryManyCorners)
{
  std::mt19937 random(4);
  for (const std::vector<Flat>& polygon : { Star(20000, random), Comb(10000), Spiral(2500) })
  {
    ExpectFilled(polygon, InSpace(polygon, 3), std::to_string(polygon.size()), 2e-6);
  }
}

// The polygon for which the bug was reported: a fan would fill its notch.
TEST(CutPolygon, FillsANotchedSquareExactly)
{
  const std::vector<Flat> notched{ { 0, 0 }, { 4, 0 }, { 4, 4 }, { 2, 1 }, { 0, 4 } };
  for (std::size_t first = 0; first < notched.size(); ++first)
  {
    std::vector<Flat> turned = notched;
    std::rotate(turned.begin(), turned.begin() + std::ptrdiff_t(first), turned.end());
    std::vector<Vec3> corners, back;
    for (const Flat& p : turned)
    {
      corners.push_back({ p[0], 0, p[1] });
    }
    ExpectFilled(turned, corners, "first " + std::to_string(first), 0);
  }
}

// Corners off the plane, as in scanned and modelled quadrilaterals: the triangles face the way that
// the polygon does.
TEST(CutPolygon, CutsAPolygonThatIsNotFlat)
{
  const std::vector<Vec3> corners{ { 0, 0, 0.3 }, { 4, 0, -0.2 }, { 4, 4, 0.1 }, { 2, 1, 0.4 },
    { 0, 4, -0.3 } };
  PolygonCutter cutter;
  const auto cut = cutter.Cut(corners);
  ASSERT_EQ(cut.size(), 3U);
  Vec3 sum{};
  for (const Triangle& t : cut)
  {
    const Vec3 part =
      Cross(Minus(corners[t[1]], corners[t[0]]), Minus(corners[t[2]], corners[t[0]]));
    EXPECT_GT(part[2], 0);
    sum = Plus(sum, part);
  }
  EXPECT_NEAR(sum[2] / 2, 10, 1e-12);
}

// A bridge joins a hole to the border. The polygon follows it there and back, so each end of the
// bridge has two corners.
TEST(CutPolygon, KeepsAHoleOpenThatABridgeLeadsTo)
{
  const std::vector<Flat> polygon{ { 0, 0 }, { 4, 0 }, { 4, 4 }, { 0, 4 }, { 0, 0 }, { 1, 1 },
    { 1, 3 }, { 3, 3 }, { 3, 1 }, { 1, 1 } };
  ExpectFilled(polygon, InSpace(polygon, 9), "bridge");
  const std::vector<Flat> apart{ { 0, 0 }, { 4, 0 }, { 4, 4 }, { 0, 4 }, { 0, 2 }, { 1, 2 },
    { 1, 3 }, { 3, 3 }, { 3, 1 }, { 1, 1 }, { 1, 2 }, { 0, 2 } };
  ExpectFilled(apart, InSpace(apart, 10), "bridge in a side");
}

std::vector<Triangle> Fan(std::size_t count)
{
  std::vector<Triangle> fan;
  for (VertexId i = 2; i < count; ++i)
  {
    fan.push_back({ 0, i - 1, i });
  }
  return fan;
}

// If an ear would have a dent on its border, another ear is cut, so that no triangle is without
// area.
TEST(CutPolygon, ADentOnADiagonalIsNotCutAcross)
{
  const std::vector<Vec3> polygon{ { 0, 0, 0 }, { 4, 0, 0 }, { 4, 4, 0 }, { 1, 1, 0 },
    { 0, 4, 0 } };
  // Starting with corner 0, the polygon passes for a fan and is cut as one. So start with the
  // others.
  for (std::size_t first = 1; first < polygon.size(); ++first)
  {
    std::vector<Vec3> corners = polygon;
    std::rotate(corners.begin(), corners.begin() + std::ptrdiff_t(first), corners.end());
    PolygonCutter cutter;
    for (const Triangle& t : cutter.Cut(corners))
    {
      const Vec3 area =
        Cross(Minus(corners[t[1]], corners[t[0]]), Minus(corners[t[2]], corners[t[0]]));
      EXPECT_GT(area[2], 0) << "from corner " << first;
    }
  }
}

TEST(CutPolygon, ConvexPolygonsAreFans)
{
  std::mt19937 random(6);
  std::uniform_real_distribution<double> any(0, 2 * std::numbers::pi);
  PolygonCutter cutter;
  for (unsigned seed = 0; seed < 200; ++seed)
  {
    const std::size_t count = 3 + seed % 40;
    std::vector<double> angles(count);
    std::generate(angles.begin(), angles.end(), [&]() { return any(random); });
    std::sort(angles.begin(), angles.end());
    std::vector<Flat> convex;
    for (const double angle : angles)
    {
      convex.push_back({ 3 * std::cos(angle), std::sin(angle) });
    }
    std::vector<Vec3> corners = InSpace(convex, seed);
    for (Vec3& p : corners) // floats, as in files
    {
      p = { float(p[0]), float(p[1]), float(p[2]) };
    }
    const auto cut = cutter.Cut(corners);
    EXPECT_EQ(std::vector(cut.begin(), cut.end()), Fan(count)) << seed;
    EXPECT_TRUE(cutter.IsFan());
  }
}

// Corners inside a side, moved a little to either side by the rounding of a file's decimals.
TEST(CutPolygon, CornersInASideLeaveAFan)
{
  std::vector<Flat> square;
  for (int side = 0; side < 4; ++side)
  {
    for (int i = 0; i < 10; ++i)
    {
      const double t = i / 10.0;
      square.push_back(side == 0   ? Flat{ t, 0 }
                       : side == 1 ? Flat{ 1, t }
                       : side == 2 ? Flat{ 1 - t, 1 }
                                   : Flat{ 0, 1 - t });
    }
  }
  PolygonCutter cutter;
  for (unsigned seed = 0; seed < 20; ++seed)
  {
    std::vector<Vec3> corners = InSpace(square, seed);
    for (Vec3& p : corners)
    {
      p = { std::round(p[0] * 1e7) / 1e7, std::round(p[1] * 1e7) / 1e7,
        std::round(p[2] * 1e7) / 1e7 };
    }
    cutter.Cut(corners);
    EXPECT_TRUE(cutter.IsFan()) << seed;
  }
}

// No polygon may hang the cutter or lose a triangle.
TEST(CutPolygon, PolygonsWithoutAnInside)
{
  PolygonCutter cutter;
  const double inf = std::numeric_limits<double>::infinity(), nan = std::nan("");
  const std::vector<std::vector<Vec3>> polygons{ {}, { {} }, { {}, {} }, std::vector<Vec3>(50),
    { {}, { 1, 0, 0 }, { 3, 0, 0 }, { 2, 0, 0 } },                          // a line
    { {}, { 1, 1, 0 }, { 1, 0, 0 }, { 0, 1, 0 } },                          // a bow
    { {}, { 4, 0, 0 }, { 4, 4, 0 }, { 4, 0, 0 }, { 2, 1, 0 }, { 0, 4, 0 } } // a spike
    ,
    { {}, { nan, 0, 0 }, { 4, 4, 0 }, { 2, 1, 0 }, { 0, 4, 0 } },
    { {}, { inf, 0, 0 }, { 4, 4, 0 }, { 2, 1, 0 }, { 0, 4, 0 } },
    { {}, { 1e308, 0, 0 }, { 1e308, 1e308, 0 }, { -1e308, 1, 0 }, { 0, 1e308, 0 } },
    { {}, { 4e-310, 0, 0 }, { 4e-310, 4e-310, 0 }, { 2e-310, 1e-310, 0 }, { 0, 4e-310, 0 } } };
  for (const std::vector<Vec3>& polygon : polygons)
  {
    EXPECT_EQ(cutter.Cut(polygon).size(), std::max<std::size_t>(2, polygon.size()) - 2);
  }
}

TEST(CutPolygon, AnyCornersGiveTheirTriangles)
{
  std::mt19937 random(8);
  PolygonCutter cutter;
  for (unsigned seed = 0; seed < 500; ++seed)
  {
    // Corners on few places: many are equal, in a line, or on other sides.
    const std::size_t count = 3 + random() % 40;
    const unsigned places = 2 + seed % 6;
    std::vector<Vec3> corners;
    for (std::size_t i = 0; i < count; ++i)
    {
      corners.push_back({ double(random() % places), double(random() % places),
        seed % 3 == 0 ? double(random() % places) : 0 });
    }
    const auto cut = cutter.Cut(corners);
    EXPECT_EQ(cut.size(), count - 2);
    Vec3 whole{}, sum{};
    for (std::size_t i = 2; i < count; ++i)
    {
      whole = Plus(whole, Cross(Minus(corners[i - 1], corners[0]), Minus(corners[i], corners[0])));
    }
    for (const Triangle& t : cut)
    {
      ASSERT_LT(*std::max_element(t.begin(), t.end()), count);
      sum =
        Plus(sum, Cross(Minus(corners[t[1]], corners[t[0]]), Minus(corners[t[2]], corners[t[0]])));
    }
    EXPECT_EQ(sum, whole) << seed; // integers: exact
  }
  std::vector<Vec3> tangled;
  for (int i = 0; i < 20000; ++i)
  {
    tangled.push_back({ double(random() % 1000), double(random() % 1000), 0 });
  }
  EXPECT_EQ(cutter.Cut(tangled).size(), 19998U);
}

}
}
