// SPDX-License-Identifier: BSD-3-Clause
// Windows on an X server, together with windows that need none. CMake runs this under xvfb-run.
#include "viewer/rendering/Testing/RenderTools.h"

#include <vtkXOpenGLRenderWindow.h>

#include <vector>

namespace kdstream::test
{
namespace
{

void Show(const Stage& stage)
{
  EXPECT_TRUE(stage.scene->Update(BumpySphere(50), depths, { 0, 0, 0 }));
  EXPECT_TRUE(stage.scene->SetCamera(CameraAt({ 0, 0, 0 })));
}

TEST(X11Window, DrawsWhatTheOthersDraw)
{
  std::vector<Stage> stages;
  for (const WindowBackend backend :
    { WindowBackend::X11, WindowBackend::Egl, WindowBackend::OsMesa, WindowBackend::X11 })
  {
    stages.emplace_back(backend, 240, 180);
    Show(stages.back());
    EXPECT_EQ(Compare(stages.back().Draw(), stages.front().Draw()).pixels, 0u);
  }
  const WindowPicture picture = stages.front().Draw();
  EXPECT_GT(BrightnessAround(picture, 0.5, 0.4, 5), 1.5 * BrightnessAround(picture, 0.05, 0.05, 3));
  for (const std::size_t i : { 0, 1, 2, 3, 2, 1, 0, 3, 1, 3, 2, 0 })
  {
    EXPECT_EQ(Compare(stages[i].Draw(), picture).pixels, 0u) << i;
    EXPECT_TRUE(stages[i].window->IsCurrent());
  }
  // The X11 windows are destroyed while OSMesa's context is current.
  stages[2].Draw();
  stages.erase(stages.begin() + 3);
  stages.erase(stages.begin());
  EXPECT_EQ(Compare(stages[0].Draw(), picture).pixels, 0u);
  EXPECT_EQ(Compare(stages[1].Draw(), picture).pixels, 0u);
}

TEST(X11Window, FollowsChangesOfSize)
{
  const Stage changing(WindowBackend::X11, 50, 50);
  Show(changing);
  // Sizes beyond that of the screen, which is 640 × 480, work, too.
  for (const auto& [width, height] :
    { std::pair{ 200, 100 }, std::pair{ 1, 1 }, std::pair{ 1200, 900 }, std::pair{ 80, 90 } })
  {
    changing.window->SetSize(width, height);
    const Stage egl(WindowBackend::Egl, width, height);
    Show(egl);
    EXPECT_EQ(Compare(changing.Draw(), egl.Draw()).pixels, 0u) << width << "x" << height;
  }
}

TEST(X11Window, ComesAndGoes)
{
  for (int i = 0; i < 20; ++i)
  {
    const Stage stage(i % 3 == 0 ? WindowBackend::OsMesa : WindowBackend::X11, 64, 64);
    Show(stage);
    EXPECT_GT(BrightnessAround(stage.Draw(), 0.5, 0.4, 3), 60.0) << i;
  }
}

// In a program that can draw off screen, VTK's own windows still work.
TEST(X11Window, LeavesStockWindowsAlone)
{
  const vtkNew<vtkXOpenGLRenderWindow> window;
  window->SetOffScreenRendering(1);
  window->SetMultiSamples(4);
  window->SetSize(120, 90);
  SurfaceScene scene;
  ASSERT_TRUE(scene.Update(BumpySphere(50), depths, { 0, 0, 0 }));
  ASSERT_TRUE(scene.SetCamera(CameraAt({ 0, 0, 0 })));
  window->AddRenderer(&scene.Renderer());
  const Result<WindowPicture> picture = Pixels(*window);
  ASSERT_TRUE(picture);
  window->Finalize();

  const Stage egl(WindowBackend::Egl, 120, 90);
  Show(egl);
  EXPECT_EQ(Compare(egl.Draw(), *picture).pixels, 0u);
}

}
}
