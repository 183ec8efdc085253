// SPDX-License-Identifier: BSD-3-Clause
#include "viewer/session/LineMeter.h"

#include <gtest/gtest.h>

#include <limits>

using namespace kdstream;

TEST(TestLineMeter, AsksForAQuarterOfASecondOfTheLine)
{
  LineMeter meter;
  EXPECT_EQ(meter.Window(), 65536u); // nothing is known
  for (int i = 0; i < 100; ++i)
  {
    meter.Arrived(5000, 0.1, false); // 50 kB/s
  }
  EXPECT_NEAR(double(meter.Window()), 12500, 500);
  for (int i = 0; i < 100; ++i)
  {
    meter.Arrived(5000, 0.005, false); // 1 MB/s
  }
  EXPECT_NEAR(double(meter.Window()), 250e3, 5e3);
}

TEST(TestLineMeter, FillsALineWithALongWay)
{
  LineMeter meter;
  meter.Arrived(5000, 0.6, true); // what comes alone tells of the way, not of the line
  EXPECT_EQ(meter.Window(), 65536u);
  meter.Arrived(5000, 0.8, true);
  for (int i = 0; i < 100; ++i)
  {
    meter.Arrived(10000, 0.1, false); // 100 kB/s
  }
  EXPECT_NEAR(double(meter.Window()), 120e3, 2e3); // two ways of 0.6 s
}

TEST(TestLineMeter, StaysInItsLimitsWhateverTheClockSays)
{
  LineMeter meter;
  for (const double seconds : { 0.0, -1.0, std::numeric_limits<double>::quiet_NaN() })
  {
    meter.Arrived(1000, seconds, false);
    meter.Arrived(1000, seconds, true);
    EXPECT_EQ(meter.Window(), 65536u);
  }
  meter.Arrived(1, 1e9, false);
  EXPECT_EQ(meter.Window(), 12288u);
  meter.Arrived(std::size_t{ 1 } << 62, 1e-9, false);
  EXPECT_EQ(meter.Window(), std::size_t{ 4 } << 20);
  meter.Arrived(1, std::numeric_limits<double>::infinity(), false);
  EXPECT_EQ(meter.Window(), 12288u);
}
