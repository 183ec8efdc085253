// Regression pictures of the OpenGL ES renderer. Mesa's software renderer of another version may
// round otherwise, so a little may differ: see `ExpectBaseline`. Where a picture is meant to
// change, look at the one that the failure names and copy it over the baseline.
#include "viewer/mobile/Testing/GlesTools.h"
#include "viewer/mobile/Testing/PngFile.h"

namespace kdstream::test
{
namespace
{

constexpr int width = 200, height = 300;

// A mean difference of all channels up to 0.1 of 255, and up to 0.5 % of the pixels by more than 8
// (edges): far more than rounding every coordinate otherwise makes (RoundedOtherwise: 0.00001, and
// none), far less than a wrong light or wrong triangles make.
void ExpectBaseline(const std::string& name, const Image& drawn)
{
  const Image expected = ReadPngFile(KDSTREAM_BASELINES "/" + name + ".png", width, height);
  const Difference difference = Compare(drawn, expected, 8);
  const bool same =
    !expected.empty() && difference.mean <= 0.1 && difference.pixels <= drawn.size() / 3 / 200;
  if (!same)
  {
    const std::string file = name + ".drawn.png";
    WritePngFile(file, drawn, width, height);
    ADD_FAILURE() << "is not the baseline: mean difference " << difference.mean << ", "
                  << difference.pixels << " pixels, largest " << difference.largest
                  << "; what was drawn is in " << file;
  }
}

Image DrawIn(SurfaceColoring coloring, const ViewerScene& scene)
{
  Easel easel(width, height);
  easel.renderer->SetColoring(coloring);
  return easel.Draw(scene);
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

// 80,402 vertices: more than 16 bits count, so more than one chunk.
TEST(GlesPictures, ManyVertices)
{
  const Surface sphere = BumpySphere(201);
  ASSERT_GT(sphere.points.size(), std::size_t{ 65536 });
  ExpectBaseline("ManyVertices", DrawIn(SurfaceColoring::Resolution, SceneOf(sphere)));
}

// Exactly as without the offset, since the points are the same relative to the center.
TEST(GlesPictures, FarFromTheOrigin)
{
  const Vec3 offset{ 4e6, 4e6, 4e6 };
  const Image far = DrawIn(SurfaceColoring::Stone, SceneOf(BumpySphere(60, offset)));
  EXPECT_EQ(Compare(far, DrawIn(SurfaceColoring::Stone, SceneOf(BumpySphere(60)))).pixels, 0u);
  ExpectBaseline("Stone", far);
}

// Around another center, floats round otherwise: a picture stands that.
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
