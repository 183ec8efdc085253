// SPDX-License-Identifier: BSD-3-Clause
#include "viewer/rendering/OffscreenWindow.h"

#include <gtest/gtest.h>

namespace kdstream
{
namespace
{

TEST(MissingGlSymbols, AreToldInWords)
{
  for (const WindowBackend backend : { WindowBackend::Egl, WindowBackend::OsMesa })
  {
    const auto window = MakeOffscreenWindow(backend, 64, 64);
    ASSERT_FALSE(window);
    EXPECT_EQ(window.GetError().code, ErrorCode::Unsupported);
    EXPECT_NE(window.GetError().message.find("kdstream_enable_offscreen"), std::string::npos);
  }
}

}
}
