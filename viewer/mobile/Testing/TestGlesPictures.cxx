// SPDX-License-Identifier: BSD-3-Clause
// Regression pictures of the OpenGL ES renderer. Other versions of Mesa's software renderer may
// round differently, so small differences are allowed: see `ExpectBaseline`. If a picture is meant
// to change, check the picture that the failure names, and copy it over the baseline.
#include "viewer/mobile/Testing/GlesTools.h"
#include "viewer/mobile/Testing/PngFile.h"

#include <filesystem>

namespace kdstream::test
{
namespace
{

constexpr int width = 200, height = 300;

// Allows a mean difference of all channels up to 0.1 of 255, and up to 0.5 % of pixels that differ
// by more than 8 (edges). Rounding every coordinate differently changes far less (RoundedOtherwise:
// 0.00001, and no pixels); a wrong light or wrong triangles change far more.
void ExpectBaseline(const std::string& name, const Image& drawn)
{
  const std::string file = KDSTREAM_BASELINES "/" + name;
  Difference difference;
  const auto isAsIn = [&](const std::string& baseline)
  {
    const Image expected = ReadPngFile(baseline, width, height);
    difference = Compare(drawn, expected, 8);
    return !expected.empty() && difference.mean <= 0.1 &&
           difference.pixels <= drawn.size() / 3 / 200;
  };
  // Mesa 25 draws squares of points up to a pixel beside where Mesa 22 does: NAME.mesa25.png.
  const std::string later = file + ".mesa25.png";
  if (!(std::filesystem::exists(later) && isAsIn(later)) && !isAsIn(file + ".png"))
  {
    const std::string wrong = name + ".drawn.png";
    WritePngFile(wrong, drawn, width, height);
    ADD_FAILURE() << "is not the baseline: mean difference " << difference.mean << ", "
                  << difference.pixels << " pixels, largest " << difference.largest
                  << "; what was drawn is in " << wrong;
  }
}

Image DrawIn(SurfaceColoring coloring, const ViewerScene& scene)
{
  Canvas canvas(width, height);
  canvas.renderer->SetColoring(coloring);
  return canvas.Draw(scene);
}

TEST(GlesPictures, Stone)
{
  ExpectBaseline("Stone", DrawIn(SurfaceColoring::Stone, SceneOf(BumpySphere(60))));
}

TEST(GlesPictures, Partitions)
{
  ExpectBaseline("Partitions", DrawIn(SurfaceColoring::Partition, SceneOf(BumpySphere(24))));
}

TEST(GlesPictures, Resolutions)
{
  ExpectBaseline("Resolutions", DrawIn(SurfaceColoring::Resolution, SceneOf(BumpySphere(24))));
}

TEST(GlesPictures, Cloud)
{
  Surface cloud = BumpySphere(60);
  cloud.triangles.clear();
  ExpectBaseline("Cloud", DrawIn(SurfaceColoring::Stone, SceneOf(cloud)));
  ExpectBaseline("CloudPartitions", DrawIn(SurfaceColoring::Partition, SceneOf(cloud)));
}

// A checkered sphere with colours, whose alpha must be ignored, and with normals like a scan's:
// half of them face inwards.
Surface Checkered(std::uint32_t rows)
{
  Surface sphere = BumpySphere(rows);
  Attribute colors{ { "RGBA", AttributeType::UInt8, AttributeAssociation::Point, 4 }, {} };
  Attribute normals{ { "Normals", AttributeType::Float64, AttributeAssociation::Point, 3 }, {} };
  colors.values.resize(sphere.points.size() * colors.TupleSize());
  normals.values.resize(sphere.points.size() * normals.TupleSize());
  for (std::size_t i = 0; i < sphere.points.size(); ++i)
  {
    const Vec3& p = sphere.points[i];
    const auto step = [](double x) { return std::lround(std::floor(4.0 * x)); };
    const bool dark = (step(p[0]) + step(p[1]) + step(p[2])) % 2 == 0;
    colors.Set(i, 0, dark ? 30 : 240);
    colors.Set(i, 1, dark ? 70 : 200);
    colors.Set(i, 2, 100 + 120 * p[1]);
    colors.Set(i, 3, static_cast<double>(i % 256));
    for (std::size_t k = 0; k < 3; ++k)
    {
      normals.Set(i, k, i % 2 ? p[k] : -3.0 * p[k]);
    }
  }
  sphere.attributes = { std::move(colors), std::move(normals) };
  return sphere;
}

TEST(GlesPictures, Colors)
{
  ExpectBaseline("Colors", DrawIn(SurfaceColoring::Own, SceneOf(Checkered(60))));
  ExpectBaseline("Stone", DrawIn(SurfaceColoring::Stone, SceneOf(Checkered(60))));
}

TEST(GlesPictures, ColorsOfAModelWithoutAny)
{
  ExpectBaseline("Stone", DrawIn(SurfaceColoring::Own, SceneOf(BumpySphere(60))));
}

TEST(GlesPictures, CloudColors)
{
  Surface cloud = Checkered(60);
  cloud.triangles.clear();
  ExpectBaseline("CloudColors", DrawIn(SurfaceColoring::Own, SceneOf(cloud)));
}

// 80,402 vertices, more than 16 bits can count, so there are several chunks.
TEST(GlesPictures, ManyVertices)
{
  const Surface sphere = BumpySphere(201);
  ASSERT_GT(sphere.points.size(), std::size_t{ 65536 });
  ExpectBaseline("ManyVertices", DrawIn(SurfaceColoring::Resolution, SceneOf(sphere)));
}

// The same picture as without the offset, because the points relative to the center are the same.
TEST(GlesPictures, FarFromTheOrigin)
{
  const Vec3 offset{ 4e6, 4e6, 4e6 };
  const Image far = DrawIn(SurfaceColoring::Stone, SceneOf(BumpySphere(60, offset)));
  EXPECT_EQ(Compare(far, DrawIn(SurfaceColoring::Stone, SceneOf(BumpySphere(60)))).pixels, 0u);
  ExpectBaseline("Stone", far);
}

// Floats round differently relative to another center; this must hardly change the picture.
TEST(GlesPictures, RoundedOtherwise)
{
  ViewerScene scene = SceneOf(BumpySphere(60));
  scene.box.Add(Vec3{ 1.7, -1.9, 2.3 });
  const Image drawn = DrawIn(SurfaceColoring::Stone, scene);
  EXPECT_GT(Compare(drawn, DrawIn(SurfaceColoring::Stone, SceneOf(BumpySphere(60)))).pixels, 0u);
  ExpectBaseline("Stone", drawn);
}

TEST(GlesPictures, Nothing)
{
  ExpectBaseline("Nothing", DrawIn(SurfaceColoring::Stone, SceneOf(Surface{})));
}

}
}
