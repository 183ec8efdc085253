// SPDX-License-Identifier: BSD-3-Clause
// Planes through surfaces: outlines are closed, caps have the area that the outlines enclose, and
// what is cut away cannot be picked.
#include "Testing/Fixtures/Invariants.h"
#include "Testing/Fixtures/Meshes.h"
#include "viewer/session/section/ShownSection.h"
#include "viewer/session/section/SurfaceSection.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <vector>

using namespace kdstream;
using fixtures::BoxOf;

namespace
{

DrawnSurface Drawn(const Mesh& mesh)
{
  Surface surface;
  surface.points = mesh.points;
  surface.triangles = mesh.triangles;
  surface.sources.resize(mesh.points.size());
  return DrawnSurface(std::move(surface));
}

Vec3 AnyDirection(std::mt19937& random)
{
  std::normal_distribution<double> any;
  Vec3 v{ any(random), any(random), any(random) };
  while (Length(v) < 1e-3)
  {
    v = { any(random), any(random), any(random) };
  }
  return Normalized(v);
}

// A random plane through the box.
SectionPlane AnyPlane(std::mt19937& random, const Box& box)
{
  SectionPlane plane{ AnyDirection(random), 0 };
  std::uniform_real_distribution<double> any(plane.LeastOf(box), plane.MostOf(box));
  plane.offset = any(random);
  return plane;
}

// The area that directed segments enclose, by Green's theorem: above 0 if it is on their left.
double AreaWithin(const std::vector<SectionSegment>& segments, const SectionPlane& plane)
{
  double twice = 0;
  for (const SectionSegment& segment : segments)
  {
    const Vec3 a = segment.from - segments.front().from, b = segment.to - segments.front().from;
    twice += Dot(Cross(a, b), plane.normal);
  }
  return twice / 2;
}

// The signed area of a cap: above 0 if the triangles turn left around the normal.
double AreaOf(const Surface& cap, const SectionPlane& plane)
{
  double twice = 0;
  for (const Triangle& t : cap.triangles)
  {
    const Vec3 a = cap.points[t[0]], b = cap.points[t[1]], c = cap.points[t[2]];
    const double own = Dot(Cross(b - a, c - a), plane.normal);
    EXPECT_GE(own, -1e-9);
    twice += own;
  }
  return twice / 2;
}

bool Covers(const Surface& cap, const SectionPlane& plane, const Vec3& point)
{
  return PickSurface(cap, { point + plane.normal, plane.normal * -1 }).has_value();
}

TEST(TestSurfaceSection, ClosedSurfacesHaveClosedLines)
{
  std::mt19937 random(1);
  for (const fixtures::NamedMesh& each : fixtures::ClosedMeshes())
  {
    SCOPED_TRACE(each.name);
    const DrawnSurface surface = Drawn(each.mesh);
    for (int i = 0; i < 20; ++i)
    {
      const SectionPlane plane = AnyPlane(random, BoxOf(each.mesh));
      const std::vector<SectionSegment> segments = CutSurface(surface, plane);
      const double scale = Length(BoxOf(each.mesh).hi - BoxOf(each.mesh).lo);
      std::size_t ends = 0;
      for (const SectionLine& line : LinesOf(segments))
      {
        EXPECT_TRUE(line.closed);
        EXPECT_GE(line.points.size(), 2u);
        ends += line.points.size();
      }
      EXPECT_EQ(ends, segments.size()) << "each segment is in one line";
      for (const SectionSegment& segment : segments)
      {
        EXPECT_NEAR(plane.Above(segment.from), 0, 1e-9 * scale);
        EXPECT_NEAR(plane.Above(segment.to), 0, 1e-9 * scale);
      }
    }
  }
}

TEST(TestSurfaceSection, CapsHaveTheAreaThatTheOutlineEncloses)
{
  std::mt19937 random(2);
  for (const Mesh& mesh : { fixtures::DisplacedSphere(3), fixtures::Torus(40, 24),
         fixtures::NestedSpheres(3), fixtures::ThinPlate(12), fixtures::Tetrahedra(7),
         fixtures::DisplacedSphere(3, { 5e6, -3e6, 200 }) })
  {
    const DrawnSurface surface = Drawn(mesh);
    const Box box = BoxOf(mesh);
    const double scale = Length(box.hi - box.lo);
    for (int i = 0; i < 40; ++i)
    {
      const SectionPlane plane = AnyPlane(random, box);
      const std::vector<SectionSegment> segments = CutSurface(surface, plane);
      const Surface cap = CapOf(segments, plane);
      const double within = segments.empty() ? 0 : AreaWithin(segments, plane);
      EXPECT_NEAR(AreaOf(cap, plane), within, 1e-8 * scale * scale);
      EXPECT_EQ(cap.points.size(), cap.sources.size());
      EXPECT_LE(cap.triangles.size(), 4 * segments.size());
      for (const Vec3& point : cap.points)
      {
        EXPECT_NEAR(plane.Above(point), 0, 1e-8 * scale);
      }
    }
  }
}

TEST(TestSurfaceSection, CapsAreWhereTheModelIsSolid)
{
  std::mt19937 random(3);
  std::uniform_real_distribution<double> any(-1.2, 1.2);
  std::size_t inside = 0;
  for (const Mesh& mesh :
    { fixtures::DisplacedSphere(3), fixtures::Torus(40, 24), fixtures::NestedSpheres(3) })
  {
    const DrawnSurface surface = Drawn(mesh);
    for (int i = 0; i < 20; ++i)
    {
      const SectionPlane plane = AnyPlane(random, BoxOf(mesh));
      const Surface cap = CapOf(CutSurface(surface, plane), plane);
      for (int k = 0; k < 50; ++k)
      {
        const Vec3 point = plane.NearestTo({ any(random), any(random), any(random) });
        EXPECT_EQ(Covers(cap, plane, point), IsAround(surface, point));
        inside += IsAround(surface, point) ? 1 : 0;
      }
    }
  }
  EXPECT_GT(inside, 300u);
}

// A scan with holes.
TEST(TestSurfaceSection, HolesAreClosedByAStraightLine)
{
  std::mt19937 random(4);
  const Mesh whole = fixtures::DisplacedSphere(4);
  Mesh torn = whole;
  std::erase_if(torn.triangles,
    [&](const Triangle& t)
    {
      const Vec3& p = torn.points[t[0]];
      return Length(p - Vec3{ 1, 0, 0 }) < 0.25 || Length(p - Vec3{ -0.6, 0.7, 0.3 }) < 0.2;
    });
  const DrawnSurface surface = Drawn(torn), original = Drawn(whole);
  std::size_t open = 0;
  for (int i = 0; i < 200; ++i)
  {
    SectionPlane plane = AnyPlane(random, BoxOf(whole));
    plane.offset *= 0.5;
    const std::vector<SectionSegment> segments = CutSurface(surface, plane);
    const std::vector<SectionLine> lines = LinesOf(segments);
    open += std::any_of(lines.begin(), lines.end(), [](const auto& line) { return !line.closed; });
    const double area = AreaOf(CapOf(segments, plane), plane);
    const double most = AreaWithin(CutSurface(original, plane), plane);
    EXPECT_GT(area, 0.9 * most);
    EXPECT_LT(area, 1.02 * most);
  }
  EXPECT_GT(open, 20u);
}

// Planes exactly through corners, edges and faces.
TEST(TestSurfaceSection, PlanesThroughCornersAndFaces)
{
  Mesh cube;
  for (unsigned i = 0; i < 8; ++i)
  {
    cube.points.push_back({ i & 1U ? 1.0 : 0.0, i & 2U ? 1.0 : 0.0, i & 4U ? 1.0 : 0.0 });
  }
  cube.triangles = { { 0, 2, 1 }, { 1, 2, 3 }, { 4, 5, 6 }, { 5, 7, 6 }, { 0, 1, 4 }, { 1, 5, 4 },
    { 2, 6, 3 }, { 3, 6, 7 }, { 0, 4, 2 }, { 2, 4, 6 }, { 1, 3, 5 }, { 3, 7, 5 } };
  const DrawnSurface surface = Drawn(cube);
  const auto areaAt = [&](const Vec3& normal, double offset)
  {
    const SectionPlane plane{ Normalized(normal), offset / Length(normal) };
    const auto segments = CutSurface(surface, plane);
    for (const SectionLine& line : LinesOf(segments))
    {
      EXPECT_TRUE(line.closed);
    }
    return AreaOf(CapOf(segments, plane), plane);
  };
  EXPECT_NEAR(areaAt({ 0, 0, 1 }, 0.5), 1, 1e-12);
  EXPECT_NEAR(areaAt({ 0, 0, 1 }, 0), 1, 1e-12) << "what lies in the plane is kept";
  EXPECT_NEAR(areaAt({ 0, 0, 1 }, 1), 0, 1e-12) << "nothing is cut away";
  EXPECT_NEAR(areaAt({ 0, 0, -1 }, -0.25), 1, 1e-12);
  EXPECT_NEAR(areaAt({ 1, 1, 0 }, 1), std::sqrt(2.0), 1e-12) << "through four corners";
  EXPECT_NEAR(areaAt({ 1, 1, 1 }, 1), std::sqrt(3.0) / 2, 1e-12) << "through three corners";
  EXPECT_NEAR(areaAt({ 1, 1, 1 }, 1.5), 1.299038105676658, 1e-12);
  EXPECT_EQ(areaAt({ 1, 0, 0 }, 7), 0);
}

TEST(TestSurfaceSection, HardMeshesAreCutWithoutHarm)
{
  std::mt19937 random(5);
  for (const fixtures::NamedMesh& each : fixtures::AllMeshes())
  {
    SCOPED_TRACE(each.name);
    const DrawnSurface surface = Drawn(each.mesh);
    ShownSection section;
    section.Reset(BoxOf(each.mesh));
    for (int i = 0; i < 10; ++i)
    {
      section.Set(AnyPlane(random, BoxOf(each.mesh)));
      section.Follow(surface, 1, true);
      ASSERT_TRUE(section.Cap());
      for (const Triangle& t : section.Cap()->triangles)
      {
        for (const VertexId corner : t)
        {
          ASSERT_LT(corner, section.Cap()->points.size());
          EXPECT_TRUE(std::isfinite(section.Cap()->points[corner][0]));
        }
      }
      (void)LinesOf(section.Outline());
      (void)section.Pick(surface, { { 0.1, 0.2, 9 }, { 0, 0, -1 } }, 0.1);
    }
  }
}

// Compared with a search in all triangles, of which the part that is cut away does not count.
TEST(TestSurfaceSection, PicksWhatIsLeft)
{
  std::mt19937 random(6);
  std::uniform_real_distribution<double> any(-1, 1);
  const Mesh mesh = fixtures::DisplacedSphere(3);
  const DrawnSurface surface = Drawn(mesh);
  std::size_t caps = 0, surfaces = 0, none = 0;
  for (int i = 0; i < 2000; ++i)
  {
    ShownSection section;
    section.Reset(BoxOf(mesh));
    section.Set(AnyPlane(random, BoxOf(mesh)));
    const bool isClosed = i % 4 != 0;
    section.Follow(surface, 1, isClosed);
    const SectionPlane& plane = *section.Plane();
    const Vec3 eye = AnyDirection(random) * 3;
    const Ray ray{ eye, Normalized(Vec3{ any(random), any(random), any(random) } - eye) };
    std::optional<double> nearest;
    for (const Triangle& t : mesh.triangles)
    {
      Surface one;
      one.points = { mesh.points[t[0]], mesh.points[t[1]], mesh.points[t[2]] };
      one.triangles = { { 0, 1, 2 } };
      const auto hit = PickSurface(one, ray);
      if (hit && !plane.CutsAway(hit->point) && (!nearest || hit->distance < *nearest))
      {
        nearest = hit->distance;
      }
    }
    const double above = plane.Above(eye), fall = -Dot(ray.direction, plane.normal);
    const Vec3 entry = eye + ray.direction * (above / fall);
    const bool isCap = isClosed && above > 0 && fall > 0 && IsAround(surface, entry);
    const auto hit = section.Pick(surface, ray);
    ASSERT_EQ(hit.has_value(), isCap || nearest) << i;
    if (hit)
    {
      EXPECT_EQ(hit->part == ShownSection::capPart, isCap);
      EXPECT_NEAR(hit->distance, isCap ? above / fall : *nearest, 1e-9);
    }
    (isCap ? caps : hit ? surfaces : none) += 1;
  }
  EXPECT_GT(caps, 100u);
  EXPECT_GT(surfaces, 100u);
  EXPECT_GT(none, 100u);
}

TEST(TestSurfaceSection, NearestIsWhatIsLeft)
{
  const Mesh mesh = fixtures::DisplacedSphere(4);
  const DrawnSurface surface = Drawn(mesh);
  const SectionPlane plane{ { 0, 0, 1 }, -0.5 };
  const auto hit = NearestOnSurface(surface, { 0, 0, 2 }, 0, &plane);
  ASSERT_TRUE(hit);
  EXPECT_LT(hit->point[2], -0.3); // on a triangle that the plane goes through
  const SectionPlane all{ { 0, 0, 1 }, -9 };
  EXPECT_FALSE(NearestOnSurface(surface, { 0, 0, 2 }, 0, &all));
}

TEST(TestSurfaceSection, IsMovedWithinTheBox)
{
  const Box box{ { -1, -2, -3 }, { 1, 2, 3 } };
  ShownSection section;
  section.Reset(box);
  EXPECT_FALSE(section.Plane());
  EXPECT_EQ(section.Depth(), 0);
  section.Move(1); // without a plane: does nothing
  section.SetDepth(0.5);
  section.Turn({});
  EXPECT_FALSE(section.Plane());
  EXPECT_FALSE(section.SetAlong("w", { 0, 0, 1 }));
  ASSERT_TRUE(section.SetAlong("y", { 0.1, -0.9, 0.3 }));
  EXPECT_EQ(section.Plane()->normal, (Vec3{ 0, -1, 0 })) << "what is on the eye's side goes";
  EXPECT_EQ(section.Depth(), 0.5);
  section.SetDepth(0.25);
  EXPECT_DOUBLE_EQ(section.Plane()->offset, 1);
  section.Move(0.5);
  EXPECT_DOUBLE_EQ(section.Depth(), 0.125);
  section.Move(99);
  EXPECT_EQ(section.Depth(), 0);
  section.Move(-99);
  EXPECT_EQ(section.Depth(), 1);
  section.SetDepth(0.25);
  ASSERT_TRUE(section.SetAlong("flip", {}));
  EXPECT_EQ(section.Plane()->normal, (Vec3{ 0, 1, 0 }));
  EXPECT_DOUBLE_EQ(section.Depth(), 0.75);
  const SectionPlane before = *section.Plane();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  section.Set(SectionPlane{ { nan, 0, 1 }, 0 });
  section.Set(SectionPlane{ { 0, 0, 0 }, 0 });
  section.Set(SectionPlane{ { 0, 0, 1 }, nan });
  section.SetDepth(nan);
  section.Move(nan);
  EXPECT_EQ(*section.Plane(), before);
  ASSERT_TRUE(section.SetAlong("off", {}));
  EXPECT_FALSE(section.Plane());
}

TEST(TestSurfaceSection, SnapsToAxesUntilItIsTurnedFurther)
{
  ShownSection section;
  section.Reset({ { -1, -1, -1 }, { 1, 1, 1 } });
  section.SetAlong("z", { 0, 0, 1 });
  const auto turn = [&](double angle) // a small turn about y
  {
    section.Turn(Quaternion{ 1, 0, angle / 2, 0 }.After({}));
  };
  turn(0.03);
  EXPECT_EQ(section.Plane()->normal, (Vec3{ 0, 0, 1 })) << "still on the axis";
  turn(0.03);
  EXPECT_EQ(section.Plane()->normal, (Vec3{ 0, 0, 1 }));
  turn(0.06);
  EXPECT_NEAR(section.Plane()->normal[0], std::sin(0.12), 1e-3) << "all of the turn counts";
  for (int i = 0; i < 24; ++i)
  {
    turn(0.06);
  }
  EXPECT_EQ(section.Plane()->normal, (Vec3{ 1, 0, 0 }));
  EXPECT_NEAR(section.Plane()->offset, 0, 1e-12) << "about the middle";
}

TEST(TestSurfaceSection, WorksOnlyWhereSomethingIsNew)
{
  const DrawnSurface surface = Drawn(fixtures::DisplacedSphere(2));
  ShownSection section;
  section.Reset(BoxOf(fixtures::DisplacedSphere(2)));
  section.Follow(surface, 1, true);
  EXPECT_FALSE(section.Cap());
  section.SetAlong("x", { 1, 0, 0 });
  section.Follow(surface, 1, true);
  const auto cap = section.Cap();
  const std::uint64_t version = section.CapVersion();
  section.Follow(surface, 1, true);
  EXPECT_EQ(section.Cap(), cap);
  EXPECT_EQ(section.CapVersion(), version);
  section.Follow(surface, 2, true);
  EXPECT_NE(section.Cap(), cap);
  EXPECT_GT(section.CapVersion(), version);
  section.Follow(surface, 2, false);
  EXPECT_FALSE(section.Cap()) << "what is not closed is not filled";
  EXPECT_FALSE(section.Outline().empty());
  section.Set({});
  EXPECT_TRUE(section.Outline().empty());
}

// Parses the path of a drawing, and returns the area that it encloses.
double AreaOfDrawing(const std::string& svg)
{
  double twice = 0;
  std::size_t at = svg.find("d=\"");
  EXPECT_NE(at, std::string::npos);
  const std::size_t end = svg.find("\"/>", at);
  std::vector<std::array<double, 2>> loop;
  for (at += 3; at < end; ++at)
  {
    if (svg[at] == 'M' || svg[at] == 'L')
    {
      char* next = nullptr;
      const double x = std::strtod(svg.c_str() + at + 1, &next);
      const double y = std::strtod(next + 1, &next);
      loop.push_back({ x, y });
    }
    else if (svg[at] == 'Z')
    {
      for (std::size_t i = 0; i < loop.size(); ++i)
      {
        const auto &a = loop[i], &b = loop[(i + 1) % loop.size()];
        twice += a[1] * b[0] - a[0] * b[1]; // y points down in SVG
      }
      loop.clear();
    }
  }
  return twice / 2;
}

TEST(TestSurfaceSection, DrawingsAreInTheModelsUnit)
{
  const DrawnSurface surface = Drawn(fixtures::Torus(60, 24));
  const SectionPlane plane{ { 0, 1, 0 }, 0.05 };
  const auto segments = CutSurface(surface, plane);
  const std::string svg =
    SectionDrawing(LinesOf(segments), plane, "m", "A <b> & \x01", "within 0.1 mm");
  EXPECT_NEAR(AreaOfDrawing(svg), AreaWithin(segments, plane), 1e-9);
  EXPECT_GT(AreaOfDrawing(svg), 0.1);
  EXPECT_NE(svg.find("<title>A &lt;b> &amp;  </title>"), std::string::npos) << svg.substr(0, 400);
  EXPECT_NE(svg.find("<desc>within 0.1 mm</desc>"), std::string::npos);
  const std::size_t width = svg.find(" width=\"") + 8, box = svg.find("viewBox=\"") + 9;
  char* next = nullptr;
  const double paper = std::strtod(svg.c_str() + width, &next);
  EXPECT_EQ(std::string(next, 3), "mm\"");
  std::vector<double> numbers;
  for (const char* from = svg.c_str() + box; numbers.size() < 4; from = next)
  {
    numbers.push_back(std::strtod(from, &next));
  }
  EXPECT_NEAR(paper, 1000 * numbers[2], 1e-6);
  const std::string plain = SectionDrawing(LinesOf(segments), plane, "ft", "", "");
  EXPECT_EQ(plain.find(" width="), std::string::npos) << "no such unit on paper";
  const std::string empty = SectionDrawing({}, plane, "mm", "", "");
  EXPECT_NE(empty.find("</svg>"), std::string::npos);
}

}
