// SPDX-License-Identifier: BSD-3-Clause
#include "Testing/Fixtures/ErrorAt.h"
#include "viewer/session/appearance/SceneRules.h"

#include "viewer/session/Geometry.h"
#include "viewer/session/appearance/VertexNormals.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

namespace kdstream
{
namespace
{

Surface TwoTriangles()
{
  Surface surface;
  surface.points = { { 0, 0, 0 }, { 1, 0, 0 }, { 1, 2, 0 }, { 0, 2, 3 } };
  surface.sources.resize(4);
  surface.triangles = { { 0, 1, 2 }, { 0, 2, 3 } };
  return surface;
}

TEST(SceneRules, FacetsAreAsLongAsTheirEdges)
{
  Surface surface;
  surface.points = { { 0, 0, 0 }, { 3, 0, 0 }, { 0, 4, 0 }, { 30, 0, 0 }, { 0, 40, 0 } };
  EXPECT_EQ(FacetLength(surface), 0);
  surface.triangles = { { 0, 1, 2 } };
  EXPECT_DOUBLE_EQ(FacetLength(surface), 4);
  surface.triangles.push_back({ 0, 3, 4 });
  EXPECT_DOUBLE_EQ(FacetLength(surface), 22);
}

TEST(SceneRules, FindWhatIsWrongWithASurface)
{
  const Vec3 center{ 0.5, 1, 1.5 };
  EXPECT_TRUE(CheckSurface(TwoTriangles(), center));
  EXPECT_TRUE(CheckSurface(Surface{}, center));
  for (const double value :
    { std::numeric_limits<double>::quiet_NaN(), -std::numeric_limits<double>::infinity(), 3.5e38 })
  {
    Surface bad = TwoTriangles();
    bad.points[2][1] = value;
    const Status status = CheckSurface(bad, center);
    ASSERT_FALSE(status) << value;
    EXPECT_EQ(status.GetError().message.rfind("point 2 ", 0), 0U);
  }
  Surface far = TwoTriangles();
  far.points[2][1] = 3e38;
  EXPECT_TRUE(CheckSurface(far, center));
  Surface index = TwoTriangles();
  index.triangles[1][1] = 4;
  EXPECT_EQ(CheckSurface(index, center).GetError().message.rfind("triangle 1 ", 0), 0U);
  Surface sources = TwoTriangles();
  sources.sources.pop_back();
  EXPECT_TRUE(
    fixtures::FailsAt(CheckSurface(sources, center), ErrorCode::InvalidInput, "3 sources"));
}

TEST(SceneRules, FindWhatIsWrongWithACamera)
{
  EXPECT_TRUE(CheckCamera({}));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const SceneCamera& bad : {
         SceneCamera{ { nan, 0, 1 }, { 0, 0, 0 }, { 0, 1, 0 }, 0.5 },
         SceneCamera{ { 0, 0, 1 }, { 0, 0, 0 }, { 0, 1, nan }, 0.5 },
         SceneCamera{ { 1e308, 0, 0 }, { -1e308, 0, 0 }, { 0, 1, 0 }, 0.5 },
         SceneCamera{ { 3, 2, 1 }, { 3, 2, 1 }, { 0, 1, 0 }, 0.5 },
         SceneCamera{ { 0, 0, 1 }, { 0, 0, 0 }, { 0, 0, -7 }, 0.5 },
         SceneCamera{ { 0, 0, 1 }, { 0, 0, 0 }, { 0, 1, 0 }, 0.0 },
         SceneCamera{ { 0, 0, 1 }, { 0, 0, 0 }, { 0, 1, 0 }, std::numbers::pi },
       })
  {
    const Status status = CheckCamera(bad);
    ASSERT_FALSE(status);
    EXPECT_EQ(status.GetError().code, ErrorCode::InvalidArgument);
  }
}

// Every corner of the box lies between the planes. If the eye is outside the box, each plane is
// near a corner.
TEST(SceneRules, EncloseTheBoxBetweenThePlanes)
{
  std::mt19937 random(11);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const auto anywhere = [&] { return Vec3{ uniform(random), uniform(random), uniform(random) }; };
  for (int i = 0; i < 1000; ++i)
  {
    Box box;
    box.Add(anywhere());
    box.Add(anywhere());
    const Vec3 eye = Normalized(anywhere()) * 5.0;
    const Vec3 focal = anywhere();
    const Vec3 sight = Normalized(focal - eye);
    const ClippingPlanes planes = PlanesAround(box, eye, focal);
    double nearest = 100.0, farthest = 0.0;
    for (int corner = 0; corner < 8; ++corner)
    {
      const Vec3 p{ (corner & 1 ? box.hi : box.lo)[0], (corner & 2 ? box.hi : box.lo)[1],
        (corner & 4 ? box.hi : box.lo)[2] };
      nearest = std::min(nearest, Dot(p - eye, sight));
      farthest = std::max(farthest, Dot(p - eye, sight));
    }
    EXPECT_LT(planes.nearest, nearest);
    EXPECT_GT(planes.farthest, farthest);
    EXPECT_GT(planes.nearest, nearest - 0.1);
    EXPECT_LT(planes.farthest, farthest + 0.1);
  }
}

TEST(SceneRules, LeaveEnoughDepthFromInsideAndBehind)
{
  Box box;
  box.Add(Vec3{ -1, -1, -1 });
  box.Add(Vec3{ 1, 1, 1 });
  for (const Vec3& eye : { Vec3{ 0, 0, 0 }, Vec3{ 0, 0, 0.9 }, Vec3{ 0, 0, -50 } })
  {
    const ClippingPlanes planes = PlanesAround(box, eye, eye - Vec3{ 0, 0, 2 });
    EXPECT_GT(planes.nearest, 0.0);
    EXPECT_GE(planes.nearest, planes.farthest * 1e-4);
    EXPECT_GT(planes.farthest, planes.nearest);
  }
  const ClippingPlanes empty = PlanesAround(Box{}, { 0, 0, 3 }, { 0, 0, 0 });
  EXPECT_GT(empty.nearest, 0.0);
  EXPECT_LT(empty.nearest, 3.0);
  EXPECT_GT(empty.farthest, 3.0);
}

Surface Plain(std::size_t points)
{
  Surface surface;
  for (std::size_t i = 0; i < points; ++i)
  {
    surface.points.push_back({ static_cast<double>(i), 0.0, static_cast<double>(i % 2) });
    surface.sources.emplace_back();
  }
  return surface;
}

Attribute Array(AttributeInfo info, const std::vector<double>& values)
{
  Attribute array{ std::move(info), {} };
  array.values.resize(values.size() * SizeOf(array.type));
  for (std::size_t i = 0; i < values.size(); ++i)
  {
    array.Set(i / array.components, i % array.components, values[i]);
  }
  return array;
}

TEST(SceneRules, TakeTheModelsOwnColors)
{
  Surface surface = Plain(2);
  EXPECT_EQ(OwnColors(surface), nullptr);
  surface.attributes.push_back(
    Array({ "RGB", AttributeType::Float32, AttributeAssociation::Point, 3 }, { 1, 2, 3, 4, 5, 6 }));
  EXPECT_EQ(OwnColors(surface), nullptr) << "floats are no colours";
  surface.attributes.push_back(
    Array({ "RGBA", AttributeType::UInt8, AttributeAssociation::Point, 4 },
      { 9, 8, 7, 0, 6, 5, 4, 255 }));
  ASSERT_NE(OwnColors(surface), nullptr);
  EXPECT_EQ(OwnColor(*OwnColors(surface), 0), (Color{ 9, 8, 7 }));
  EXPECT_EQ(OwnColor(*OwnColors(surface), 1), (Color{ 6, 5, 4 }));
}

TEST(SceneRules, LightCloudsByTheirOwnNormalsAndSurfacesByTheirTriangles)
{
  Surface surface = Plain(4);
  EXPECT_TRUE(NormalsOf(surface).empty());
  const double none = std::numeric_limits<double>::quiet_NaN();
  surface.attributes.push_back(
    Array({ "Normals", AttributeType::Float64, AttributeAssociation::Point, 3 },
      { 0, -5, 0, 0, 0, 0, none, 1, 0, 1e300, 0, 0 }));
  const std::vector<std::array<float, 3>> expected{ { 0, -1, 0 }, { 0, 0, 0 }, { 0, 0, 0 },
    { 1, 0, 0 } };
  EXPECT_EQ(NormalsOf(surface), expected);
  surface.triangles = { { 0, 1, 2 }, { 1, 3, 2 } };
  EXPECT_EQ(NormalsOf(surface), ComputeVertexNormals(surface.points, surface.triangles));
}

TEST(SceneRules, RefuseArraysThatAreNotOneAPoint)
{
  Surface surface = Plain(2);
  surface.attributes.push_back(
    Array({ "RGB", AttributeType::UInt8, AttributeAssociation::Point, 3 }, { 1, 2, 3 }));
  const Status status = CheckSurface(surface, {});
  ASSERT_FALSE(status);
  EXPECT_NE(status.GetError().message.find("RGB"), std::string::npos);
}

TEST(SceneRules, EnlargeABox)
{
  Box box;
  EXPECT_TRUE(Enlarged(box, 1).Empty());
  box.Add(Vec3{ 1, 2, 3 });
  EXPECT_EQ(Enlarged(box, 0.5).lo, (Vec3{ 0.5, 1.5, 2.5 }));
  EXPECT_EQ(Enlarged(box, 0.5).hi, (Vec3{ 1.5, 2.5, 3.5 }));
}

TEST(SceneRules, ColorTriangles)
{
  const TreeDepths depths{ 3, 7, 9 };
  const auto of = [&](Resolution resolution, std::uint32_t partition) {
    return ColorSourceOf({ resolution, MakeKey(partition, 5) }, depths);
  };
  EXPECT_EQ(of(Resolution::Original(), 6).partition, 6u);
  EXPECT_EQ(of(Resolution::Level(7), 6).partition, 6u);
  EXPECT_FALSE(of(Resolution::Level(6), 6).partition);

  const ColorSource two = of(Resolution::Level(8), 2);
  const ColorSource four = of(Resolution::Level(9), 4);
  const ColorSource none = of(Resolution::Level(3), 4);
  EXPECT_EQ(Together(two, four).partition, 2u);
  EXPECT_EQ(Together(four, two).partition, 2u);
  EXPECT_EQ(Together(two, four).resolution, Resolution::Level(9));
  EXPECT_EQ(Together(none, four).partition, 4u);
  EXPECT_EQ(Together(four, none).partition, 4u);
  EXPECT_FALSE(Together(none, none).partition);

  EXPECT_EQ(ColorOf(two, SurfaceColoring::Stone), stoneColor);
  EXPECT_EQ(ColorOf(two, SurfaceColoring::Partition), PartitionColor(2));
  EXPECT_EQ(ColorOf(none, SurfaceColoring::Partition), stoneColor);
  EXPECT_EQ(ColorOf(none, SurfaceColoring::Resolution), ResolutionColor(Resolution::Level(3)));
}

}
}
