// SPDX-License-Identifier: BSD-3-Clause
#include "viewer/offscreen/vtkKdOffscreenRendering.h"

#include "filters/adapter/Testing/ReportedErrors.h"

#include <gtest/gtest.h>
#include <vtkErrorCode.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkRenderWindow.h>
#include <vtkRenderWindowInteractor.h>
#include <vtkRenderer.h>
#include <vtkWindowToImageFilter.h>

#include <sstream>
#include <string>

namespace
{

using kdstream::testing::ReportedErrors;

// Draws red; returns the window's size and the colour of its middle: red, green, blue.
std::string MiddleOfRed(vtkRenderWindow& window)
{
  vtkNew<vtkRenderer> renderer;
  renderer->SetBackground(1, 0, 0);
  window.AddRenderer(renderer);
  vtkNew<vtkWindowToImageFilter> picture;
  picture->SetInput(&window);
  picture->Update();
  int size[3];
  picture->GetOutput()->GetDimensions(size);
  std::ostringstream text;
  text << size[0] << "x" << size[1];
  for (int channel = 0; channel < 3; ++channel)
  {
    text << " "
         << picture->GetOutput()->GetScalarComponentAsDouble(size[0] / 2, size[1] / 2, 0, channel);
  }
  return text.str();
}

TEST(KdOffscreenRendering, DrawsOnEachBackend)
{
  vtkNew<vtkKdOffscreenRendering> offscreen;
  for (const int backend : { vtkKdOffscreenRendering::Auto, vtkKdOffscreenRendering::Egl,
         vtkKdOffscreenRendering::OsMesa })
  {
    offscreen->SetBackend(backend);
    SCOPED_TRACE(offscreen->GetBackendAsString());
    const auto window = offscreen->MakeWindow(60, 40);
    ASSERT_TRUE(window);
    EXPECT_EQ(MiddleOfRed(*window), "60x40 255 0 0");
  }
}

TEST(KdOffscreenRendering, RefusesWhatCannotBeDrawn)
{
  vtkNew<vtkKdOffscreenRendering> offscreen;
  ReportedErrors errors(*offscreen);
  EXPECT_EQ(offscreen->GetErrorCode(), vtkErrorCode::NoError);
  EXPECT_FALSE(offscreen->MakeWindow(0, 40));
  EXPECT_NE(errors.Take().find("0x40"), std::string::npos);
  EXPECT_EQ(offscreen->GetErrorCode(), vtkErrorCode::UnknownError);
  EXPECT_TRUE(offscreen->MakeWindow(60, 40));
  EXPECT_EQ(offscreen->GetErrorCode(), vtkErrorCode::NoError);
  EXPECT_FALSE(offscreen->MakeWindow(60, 8193));
  offscreen->SetBackend(99);
  EXPECT_STREQ(offscreen->GetBackendAsString(), "x11");
  offscreen->SetBackend(-1);
  EXPECT_STREQ(offscreen->GetBackendAsString(), "auto");
  EXPECT_TRUE(offscreen->SetBackendFromString("osmesa"));
  EXPECT_EQ(offscreen->GetErrorCode(), vtkErrorCode::NoError);
  EXPECT_FALSE(offscreen->SetBackendFromString("vulkan"));
  EXPECT_EQ(offscreen->GetErrorCode(), vtkErrorCode::UnknownError);
  EXPECT_EQ(offscreen->GetBackend(), vtkKdOffscreenRendering::OsMesa);
}

TEST(KdOffscreenRendering, ReportsWhatX11Lacks)
{
  const char* const name = std::getenv("DISPLAY");
  const std::string display = name ? name : "";
  unsetenv("DISPLAY");
  vtkNew<vtkKdOffscreenRendering> offscreen;
  offscreen->SetBackendToX11();
  ReportedErrors errors(*offscreen);
  EXPECT_FALSE(offscreen->UseForAllWindows());
  EXPECT_NE(errors.Take().find("DISPLAY"), std::string::npos);
  EXPECT_EQ(offscreen->GetErrorCode(), vtkErrorCode::UnknownError);
  if (name)
  {
    setenv("DISPLAY", display.c_str(), 1);
  }
}

// Uses windows as a program does that was written for a screen.
TEST(KdOffscreenRendering, CanBeUsedForAllWindows)
{
  vtkNew<vtkKdOffscreenRendering> offscreen;
  ASSERT_TRUE(offscreen->UseForAllWindows());
  vtkNew<vtkRenderWindow> window;
  vtkNew<vtkRenderWindowInteractor> interactor;
  interactor->SetRenderWindow(window);
  window->SetSize(50, 30);
  interactor->Initialize();
  EXPECT_EQ(MiddleOfRed(*window), "50x30 255 0 0");
  interactor->Start();

  // A later choice applies to later windows.
  offscreen->SetBackendToOsMesa();
  ASSERT_TRUE(offscreen->UseForAllWindows());
  vtkNew<vtkRenderWindow> another;
  EXPECT_EQ(MiddleOfRed(*another), "300x300 255 0 0");
}

TEST(KdOffscreenRendering, HeedsTheEnvironment)
{
  setenv("KDSTREAM_OFFSCREEN", "vulkan", 1);
  EXPECT_FALSE(vtkKdOffscreenRendering::UseEnvironment());
  setenv("KDSTREAM_OFFSCREEN", "egl", 1);
  EXPECT_TRUE(vtkKdOffscreenRendering::UseEnvironment());
  vtkNew<vtkRenderWindow> window;
  EXPECT_EQ(MiddleOfRed(*window), "300x300 255 0 0");
  unsetenv("KDSTREAM_OFFSCREEN");
  EXPECT_TRUE(vtkKdOffscreenRendering::UseEnvironment());
}

}
