// SPDX-License-Identifier: BSD-3-Clause
// Boxes in front of a surface: only the boxes' own pixels change, even with ambient occlusion.
#include "viewer/desktop/RegionBoxes.h"

#include "Testing/Fixtures/ExtrudedSurface.h"
#include "viewer/rendering/Testing/RenderTools.h"

#include <vtkRenderer.h>

namespace kdstream::test
{
namespace
{

constexpr int side = 200;

// A plane at right angles to the line of sight, with ambient occlusion and boxes. Points outside
// the picture increase the distance between the near and far planes.
struct BoxedPlane
{
  Stage stage{ WindowBackend::Egl, side, side };
  RegionBoxes boxes{ stage.scene->Renderer() };

  BoxedPlane()
  {
    this->stage.window->AddRenderer(&this->boxes.Renderer());
    SceneStyle style;
    style.occlusion = true;
    this->stage.scene->SetStyle(style);
    EXPECT_TRUE(this->stage.scene->Update(
      Extruded({ { -3, -1 }, { -2, 0 }, { 2, 0 }, { 3, 1 } }), depths, { 0, 0, 0 }));
    EXPECT_TRUE(this->stage.scene->SetCamera({ { 0, 0, 5 }, { 0, 0, 0 }, { 0, 1, 0 }, 0.6 }));
  }

  WindowPicture DrawBoxes(const std::vector<Box>& shown)
  {
    this->boxes.Show(shown, { 0, 0, 0 }, 1.5);
    return this->stage.Draw();
  }
};

Box BoxOf(const Vec3& lo, const Vec3& hi)
{
  Box box;
  box.Add(lo);
  box.Add(hi);
  return box;
}

TEST(RegionBoxes, LinesDoNotDarkenTheSurfaceBesideThem)
{
  BoxedPlane plane;
  const WindowPicture without = plane.DrawBoxes({});
  const WindowPicture with = plane.DrawBoxes({ BoxOf({ -0.4, -0.4, -0.02 }, { 0.4, 0.4, 0.02 }) });
  std::size_t lines = 0;
  for (int y = 0; y < side; ++y)
  {
    for (int x = 0; x < side; ++x)
    {
      const int before = PixelAt(without, x, y)[0];
      const int after = PixelAt(with, x, y)[0];
      lines += after > before + 40 ? 1 : 0; // orange has more red than the plane
      EXPECT_GE(after, before - 3) << x << ", " << y;
    }
  }
  EXPECT_GT(lines, 200U);
}

TEST(RegionBoxes, WhatIsBehindTheSurfaceIsHidden)
{
  BoxedPlane plane;
  const WindowPicture without = plane.DrawBoxes({});
  EXPECT_EQ(plane.DrawBoxes({ BoxOf({ -0.4, -0.4, -0.4 }, { 0.4, 0.4, -0.1 }) }).rgb, without.rgb);
  EXPECT_NE(plane.DrawBoxes({ BoxOf({ -0.4, -0.4, 0.1 }, { 0.4, 0.4, 0.4 }) }).rgb, without.rgb);
  EXPECT_EQ(plane.DrawBoxes({}).rgb, without.rgb);
}

// The model has only a part of the window, and is not in its lowest layer.
TEST(RegionBoxes, FollowTheModelsPartOfTheWindow)
{
  BoxedPlane plane;
  const vtkNew<vtkRenderer> ground;
  plane.stage.window->SetNumberOfLayers(2);
  plane.stage.window->AddRenderer(ground);
  plane.stage.scene->Renderer().SetLayer(1);
  plane.stage.scene->Renderer().SetViewport(0, 0, 0.5, 0.5);
  const WindowPicture without = plane.DrawBoxes({});
  const WindowPicture with = plane.DrawBoxes({ BoxOf({ -0.4, -0.4, 0.1 }, { 0.4, 0.4, 0.4 }) });
  std::size_t changed = 0;
  for (int y = 0; y < side; ++y)
  {
    for (int x = 0; x < side; ++x)
    {
      const bool differs = PixelAt(with, x, y) != PixelAt(without, x, y);
      changed += differs ? 1 : 0;
      EXPECT_TRUE(!differs || (x < side / 2 && y >= side / 2)) << x << ", " << y;
    }
  }
  EXPECT_GT(changed, 100U);
  plane.stage.window->RemoveRenderer(ground);
}

}
}
