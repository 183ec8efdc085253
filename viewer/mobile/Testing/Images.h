// SPDX-License-Identifier: BSD-3-Clause
// Pictures in memory, and how much two of them differ, for the tests of viewer/mobile.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <vector>

namespace kdstream::test
{

using Image = std::vector<std::uint8_t>; // red, green, blue of each pixel; the top row first

struct Difference
{
  double mean = 0.0;      // of all channels' absolute differences, 0-255
  std::size_t pixels = 0; // that differ by more than the tolerance in a channel
  int largest = 0;        // of any channel
};

inline Difference Compare(const Image& a, const Image& b, int tolerance = 0)
{
  EXPECT_EQ(a.size(), b.size());
  Difference difference;
  double sum = 0.0;
  const std::size_t size = std::min(a.size(), b.size()) / 3 * 3;
  for (std::size_t i = 0; i < size; i += 3)
  {
    int worst = 0;
    for (std::size_t k = i; k < i + 3; ++k)
    {
      const int channel = std::abs(int{ a[k] } - int{ b[k] });
      worst = std::max(worst, channel);
      sum += channel;
    }
    difference.pixels += worst > tolerance ? 1 : 0;
    difference.largest = std::max(difference.largest, worst);
  }
  difference.mean = size ? sum / static_cast<double>(size) : 0.0;
  return difference;
}

// Finds the pixels that show the model, from two pictures of the same scene: in front of black, and
// in front of white. If the model covers at least half of a pixel, the pictures differ by less than
// half there.
inline std::vector<bool> Silhouette(const Image& black, const Image& white)
{
  EXPECT_EQ(black.size(), white.size());
  std::vector<bool> covered(std::min(black.size(), white.size()) / 3);
  for (std::size_t i = 0; i < covered.size(); ++i)
  {
    covered[i] = int{ white[3 * i] } - int{ black[3 * i] } <= 127;
  }
  return covered;
}

}
