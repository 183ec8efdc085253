// SPDX-License-Identifier: BSD-3-Clause
// What the X server's screen shows: for tests of what a person sees.
#pragma once

#include <cstdint>
#include <vector>

namespace kdstream::testing
{

struct ScreenPicture
{
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgb; // rows from the top
  bool operator==(const ScreenPicture&) const = default;
};

// This part of the screen now. Throws std::runtime_error if there is no screen.
ScreenPicture LookAtScreen(int left, int top, int width, int height);

}
