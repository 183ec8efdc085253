// SPDX-License-Identifier: BSD-3-Clause
// For tests: what the X server's screen shows to a user.
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

// Reads this part of the screen. Throws std::runtime_error if there is no screen.
ScreenPicture LookAtScreen(int left, int top, int width, int height);

}
