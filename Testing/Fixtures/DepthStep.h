// SPDX-License-Identifier: BSD-3-Clause
// A near part in front of a part that its ambient occlusion darkens, and checks of the edge between
// them.
#pragma once

#include "Testing/Fixtures/ExtrudedSurface.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

namespace kdstream::test
{

// A wall with a plate in front of its left half; the plate's edge is at x = 0. Seen from (0, 0, 5).
inline Surface DepthStep(double height)
{
  return Joined(Extruded({ { -3, 0 }, { 3, 0 } }), Extruded({ { -3, height }, { 0, height } }));
}

// The up direction of the picture. It makes the edge slant, so that it crosses pixels in many ways.
inline Vec3 UpOfDepthStep()
{
  return { 0.28, 0.96, 0 };
}

// Checks a picture of DepthStep. left(x, y): the share of light, 0-1, that ambient occlusion leaves
// at a pixel; y points down. Along the edge the light must depend only on the distance from the
// edge: on the near side all of it is left, and on the far side there are no bright dots. Pixels
// that the edge crosses are between both values.
template <typename Left>
void ExpectCleanEdge(int width, int height, const Left& left)
{
  const Vec3 up = UpOfDepthStep();
  // If the edge crosses a pixel, the pixel's middle is at most this far away; a little is added for
  // the places of samples.
  const double crossed = 0.5 * (up[0] + up[1]) + 0.1;
  std::map<int, std::vector<double>> behind; // by distance from the edge in half pixels
  std::vector<double> between;
  int near = 0;
  for (int y = height / 4; y < 3 * height / 4; ++y)
  {
    for (int x = width / 4; x < 3 * width / 4; ++x)
    {
      const double away = (x + 0.5 - 0.5 * width) * up[1] + (0.5 * height - y - 0.5) * up[0];
      if (std::abs(away) <= crossed)
      {
        between.push_back(left(x, y));
        EXPECT_LT(between.back(), 1.03) << x << ", " << y << ", " << away;
      }
      else if (away < 0 && away > -8)
      {
        EXPECT_GT(left(x, y), 0.94) << x << ", " << y << ", " << away;
        ++near;
      }
      else if (away > 0 && away < 8)
      {
        behind[static_cast<int>(2 * away)].push_back(left(x, y));
      }
    }
  }
  EXPECT_GT(near, height);
  ASSERT_EQ(behind.size(), 15U);
  ASSERT_GT(between.size(), static_cast<std::size_t>(height / 4));
  for (auto& [away, lights] : behind)
  {
    std::sort(lights.begin(), lights.end());
    const double middle = lights[lights.size() / 2];
    EXPECT_LT(middle, away < 8 ? 0.8 : 0.97) << away;
    EXPECT_LT(lights.back(), middle + 0.08) << away;
    EXPECT_GT(lights.front(), middle - 0.08) << away;
  }
  EXPECT_GT(*std::min_element(between.begin(), between.end()), behind.at(1).front() - 0.03);
}

}
