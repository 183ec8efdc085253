// SPDX-License-Identifier: BSD-3-Clause
// Ambient occlusion in VTK's pictures, where it differs from OpenGL ES: windows, parts of windows,
// and other things that are drawn in them. The other tests, and a comparison of both, are in
// viewer/mobile/Testing.
#include "Testing/Fixtures/DepthStep.h"
#include "viewer/rendering/Testing/RenderTools.h"

#include <vtkRenderer.h>

namespace kdstream::test
{
namespace
{

constexpr int side = 160;
constexpr TreeDepths depths{ 3, 7, 7 };

Surface Groove()
{
  return Extruded({ { -3, 0 }, { -0.15, 0 }, { 0, -0.3 }, { 0.15, 0 }, { 3, 0 } });
}

void Show(const Stage& stage, bool occlusion)
{
  SceneStyle style;
  style.occlusion = occlusion;
  stage.scene->SetStyle(style);
  ASSERT_TRUE(stage.scene->Update(Groove(), depths, { 0, 0, 0 }));
  ASSERT_TRUE(stage.scene->SetCamera({ { 0, 0, 5 }, { 0, 0, 0 }, { 0, 1, 0 }, 0.6 }));
}

int RedAt(const WindowPicture& picture, int x, int y)
{
  return picture.rgb[3 * static_cast<std::size_t>(y * picture.width + x)];
}

WindowPicture DrawGroove(
  bool occlusion, WindowBackend backend = WindowBackend::Egl, int samples = 4)
{
  const Stage stage(backend, side, side);
  stage.window->SetMultiSamples(samples);
  Show(stage, occlusion);
  return stage.Draw();
}

// With several samples per pixel, and with only one.
TEST(SceneOcclusion, AGrooveIsDark)
{
  for (const int samples : { 0, 4 })
  {
    const WindowPicture plain = DrawGroove(false, WindowBackend::Egl, samples);
    const WindowPicture occluded = DrawGroove(true, WindowBackend::Egl, samples);
    EXPECT_LT(RedAt(occluded, side / 2, side / 2), 0.6 * RedAt(plain, side / 2, side / 2));
    EXPECT_GE(RedAt(occluded, side / 4, side / 2), RedAt(plain, side / 4, side / 2) - 2);
  }
}

// The depths are coarse because the eye is within the surface's box.
TEST(SceneOcclusion, APlaneStaysAsItIsWhereDepthsAreCoarse)
{
  for (const double viewAngle : { 0.05, 0.6 })
  {
    SCOPED_TRACE(viewAngle);
    const Surface plane = AroundTheEye(Extruded({ { -1, 1 }, { 1, -1 } }));
    const Stage stage(WindowBackend::Egl, side, side);
    const auto draw = [&](bool occlusion)
    {
      SceneStyle style;
      style.occlusion = occlusion;
      stage.scene->SetStyle(style);
      EXPECT_TRUE(stage.scene->Update(plane, depths, { 0, 0, 0 }));
      EXPECT_TRUE(stage.scene->SetCamera({ { 0, 0, 5 }, { 0, 0, 0 }, { 0, 1, 0 }, viewAngle }));
      return stage.Draw();
    };
    const WindowPicture plain = draw(false), occluded = draw(true);
    for (int y = 0; y < side; ++y)
    {
      for (int x = 0; x < side; ++x)
      {
        ASSERT_NEAR(RedAt(plain, x, y), RedAt(occluded, x, y), 3) << x << ", " << y;
      }
    }
  }
}

// With several samples per pixel, and with only one.
TEST(SceneOcclusion, EdgesOfNearPartsAreClean)
{
  for (const int samples : { 0, 4 })
  {
    SCOPED_TRACE(samples);
    const Stage stage(WindowBackend::Egl, side, side);
    stage.window->SetMultiSamples(samples);
    const auto draw = [&](bool occlusion)
    {
      SceneStyle style;
      style.occlusion = occlusion;
      stage.scene->SetStyle(style);
      EXPECT_TRUE(stage.scene->Update(DepthStep(0.12), depths, { 0, 0, 0 }));
      EXPECT_TRUE(stage.scene->SetCamera({ { 0, 0, 5 }, { 0, 0, 0 }, UpOfDepthStep(), 0.6 }));
      return stage.Draw();
    };
    const WindowPicture plain = draw(false), occluded = draw(true);
    ExpectCleanEdge(side, side,
      [&](int x, int y)
      { return RedAt(occluded, x, y) / static_cast<double>(RedAt(plain, x, y)); });
  }
}

TEST(SceneOcclusion, OsMesaDrawsTheSame)
{
  EXPECT_EQ(DrawGroove(true).rgb, DrawGroove(true, WindowBackend::OsMesa).rgb);
}

// Two scenes, each in its half of a window, one with ambient occlusion and one without. Draws them
// again after the window's size was changed.
TEST(SceneOcclusion, StaysInItsPartOfTheWindow)
{
  const Stage stage(WindowBackend::Egl, 2 * side, side);
  Show(stage, true);
  stage.scene->Renderer().SetViewport(0.5, 0, 1, 1);
  SurfaceScene left;
  ASSERT_TRUE(left.Update(Groove(), depths, { 0, 0, 0 }));
  ASSERT_TRUE(left.SetCamera({ { 0, 0, 5 }, { 0, 0, 0 }, { 0, 1, 0 }, 0.6 }));
  left.Renderer().SetViewport(0, 0, 0.5, 1);
  stage.window->AddRenderer(&left.Renderer());
  const WindowPicture plain = DrawGroove(false), occluded = DrawGroove(true);
  for (int again = 0; again < 2; ++again)
  {
    const WindowPicture both = stage.Draw();
    ASSERT_EQ(both.width, 2 * side);
    for (int y = 0; y < side; ++y)
    {
      for (int x = 0; x < side; ++x)
      {
        ASSERT_EQ(RedAt(both, x, y), RedAt(plain, x, y)) << x << ", " << y;
        ASSERT_NEAR(RedAt(both, side + x, y), RedAt(occluded, x, y), 1) << x << ", " << y;
      }
    }
    stage.window->SetSize(side, side / 2);
    stage.Draw();
    stage.window->SetSize(2 * side, side);
  }
  stage.window->RemoveRenderer(&left.Renderer());
}

// Another scene is drawn later in the same window. It is not darkened, and OpenGL's state is as
// before.
TEST(SceneOcclusion, LeavesWhatComesAfter)
{
  const Stage stage(WindowBackend::Egl, side, side);
  Show(stage, true);
  SurfaceScene over;
  const Surface small = Extruded({ { -0.5, 0 }, { 0.5, 0 } });
  ASSERT_TRUE(over.Update(small, depths, { 0, 0, 0 }));
  ASSERT_TRUE(over.SetCamera({ { 0, 0, 5 }, { 0, 0, 0 }, { 0, 1, 0 }, 0.6 }));
  stage.window->SetNumberOfLayers(2);
  over.Renderer().SetLayer(1);
  stage.window->AddRenderer(&over.Renderer());
  const WindowPicture with = stage.Draw();
  Show(stage, false);
  const WindowPicture without = stage.Draw();
  EXPECT_EQ(RedAt(with, side / 2, side / 2), RedAt(without, side / 2, side / 2));
  EXPECT_EQ(RedAt(with, side / 2 + 4, side / 3), RedAt(without, side / 2 + 4, side / 3));
  stage.window->RemoveRenderer(&over.Renderer());
}

}
}
