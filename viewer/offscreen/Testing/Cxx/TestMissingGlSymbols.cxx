// SPDX-License-Identifier: BSD-3-Clause
#include "viewer/offscreen/OffscreenWindow.h"
#include "viewer/offscreen/vtkKdOffscreenRendering.h"

#include <gtest/gtest.h>
#include <vtkNew.h>
#include <vtkRenderWindow.h>

namespace kdstream
{
namespace
{

TEST(MissingGlSymbols, AreReportedWithAReason)
{
  for (const WindowBackend backend : { WindowBackend::Egl, WindowBackend::OsMesa })
  {
    const auto window = MakeOffscreenWindow(backend, 64, 64);
    ASSERT_FALSE(window);
    EXPECT_EQ(window.GetError().code, ErrorCode::Unsupported);
    EXPECT_NE(window.GetError().message.find("kdstream_enable_offscreen"), std::string::npos);
  }
}

// Programs of others get null, instead of a window that crashes.
TEST(MissingGlSymbols, MakeNoWindow)
{
  vtkNew<vtkKdOffscreenRendering> offscreen;
  offscreen->SetBackendToEgl();
  EXPECT_FALSE(offscreen->MakeWindow(64, 64));
  EXPECT_FALSE(offscreen->UseForAllWindows());
}

}
}
