// SPDX-License-Identifier: BSD-3-Clause
// Shared by the tests of viewer/rendering: a model, a camera, and comparing pictures.
#pragma once

#include "Testing/Fixtures/BumpySphere.h"
#include "filters/core/drawing/Surface.h"
#include "viewer/offscreen/OffscreenWindow.h"
#include "viewer/rendering/Picture.h"
#include "viewer/rendering/SurfaceScene.h"

#include <gtest/gtest.h>

#include <vtkObjectFactory.h>
#include <vtkOutputWindow.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

namespace kdstream::test
{

// Every error or warning of VTK fails the test.
class FailingOutputWindow final : public vtkOutputWindow
{
public:
  static FailingOutputWindow* New() { VTK_STANDARD_NEW_BODY(FailingOutputWindow); }
  vtkTypeMacro(FailingOutputWindow, vtkOutputWindow);
  void DisplayText(const char* text) override { ADD_FAILURE() << "VTK: " << text; }
};

class VtkErrorsFail final : public ::testing::Environment
{
public:
  void SetUp() override
  {
    const vtkNew<FailingOutputWindow> output;
    vtkOutputWindow::SetInstance(output);
  }
};
inline ::testing::Environment* const vtkErrorsFail =
  ::testing::AddGlobalTestEnvironment(new VtkErrorsFail);

// A window with one scene. Throws, and so fails the test, if the window cannot be made.
struct Stage
{
  vtkSmartPointer<vtkRenderWindow> window;
  std::unique_ptr<SurfaceScene> scene;

  Stage(WindowBackend backend, int width, int height)
  {
    auto made = MakeOffscreenWindow(backend, width, height);
    if (!made)
    {
      throw std::runtime_error(made.GetError().message);
    }
    this->window = *made;
    this->scene = std::make_unique<SurfaceScene>();
    this->window->AddRenderer(&this->scene->Renderer());
  }

  WindowPicture Draw() const
  {
    const Result<WindowPicture> picture = Pixels(*this->window);
    EXPECT_TRUE(picture) << (picture ? "" : picture.GetError().message);
    return picture ? *picture : WindowPicture{};
  }
};

inline Surface BumpySphere(std::uint32_t rows, const Vec3& offset = { 0.0, 0.0, 0.0 })
{
  return BumpySphere(rows, offset, 0.01);
}

// Looks at `focal` from a little above and to the right; the sphere fills most of the picture.
inline SceneCamera CameraAt(const Vec3& focal)
{
  SceneCamera camera;
  camera.focal = focal;
  camera.eye = { focal[0] + 1.25, focal[1] + 1.0, focal[2] + 4.0 };
  return camera;
}

inline std::array<int, 3> PixelAt(const WindowPicture& picture, int x, int y)
{
  const std::size_t i = 3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(picture.width) +
                              static_cast<std::size_t>(x));
  return { picture.rgb[i], picture.rgb[i + 1], picture.rgb[i + 2] };
}

inline double Brightness(const std::array<int, 3>& pixel)
{
  return (pixel[0] + pixel[1] + pixel[2]) / 3.0;
}

// The mean brightness (0-255) of a square with sides of 2 r + 1 pixels, whose centre is given in
// fractions of the picture.
inline double BrightnessAround(const WindowPicture& picture, double x, double y, int r)
{
  const int cx = static_cast<int>(x * picture.width);
  const int cy = static_cast<int>(y * picture.height);
  double sum = 0.0;
  for (int dy = -r; dy <= r; ++dy)
  {
    for (int dx = -r; dx <= r; ++dx)
    {
      sum += Brightness(PixelAt(picture, cx + dx, cy + dy));
    }
  }
  return sum / ((2.0 * r + 1.0) * (2.0 * r + 1.0));
}

struct PictureDifference
{
  std::size_t pixels = 0; // that differ by more than the tolerance in a channel
  int largest = 0;        // of any channel
};

inline PictureDifference Compare(const WindowPicture& a, const WindowPicture& b, int tolerance = 0)
{
  EXPECT_EQ(a.width, b.width);
  EXPECT_EQ(a.height, b.height);
  PictureDifference difference;
  for (std::size_t i = 0; i + 2 < std::min(a.rgb.size(), b.rgb.size()); i += 3)
  {
    int worst = 0;
    for (std::size_t k = i; k < i + 3; ++k)
    {
      worst = std::max(worst, std::abs(int{ a.rgb[k] } - int{ b.rgb[k] }));
    }
    difference.pixels += worst > tolerance ? 1 : 0;
    difference.largest = std::max(difference.largest, worst);
  }
  return difference;
}

}
