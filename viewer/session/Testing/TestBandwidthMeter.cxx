// SPDX-License-Identifier: BSD-3-Clause
#include "viewer/session/requests/BandwidthMeter.h"

#include <gtest/gtest.h>

#include <limits>

using namespace kdstream;

TEST(TestBandwidthMeter, RequestsAQuarterOfASecondOfTheBandwidth)
{
  BandwidthMeter meter;
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

TEST(TestBandwidthMeter, FillsAConnectionWithALongRoundTrip)
{
  BandwidthMeter meter;
  meter.Arrived(5000, 0.6, true);
  meter.Arrived(5000, 0.8, true);
  for (int i = 0; i < 100; ++i)
  {
    meter.Arrived(10000, 0.1, false); // 100 kB/s
  }
  EXPECT_NEAR(double(meter.Window()), 110e3, 2e3); // two round trips of 0.55 s
}

// A slow first answer may mean a long round trip or a slow connection. Little is requested until
// that is known.
TEST(TestBandwidthMeter, SingleBlobsOnASlowConnectionAreNotALongRoundTrip)
{
  BandwidthMeter meter;
  meter.Arrived(7500, 0.18, true); // a round trip of 0.03 s, and 0.15 s at 50 kB/s
  EXPECT_EQ(meter.Window(), 12288u);
  meter.Arrived(5000, 0.1, false);
  EXPECT_NEAR(double(meter.Window()), 12500, 100);

  BandwidthMeter fast;
  fast.Arrived(7500, 0.0306, true); // the same round trip, and 100 Mbit/s
  EXPECT_NEAR(double(fast.Window()), 61e3, 1e3);
  fast.Arrived(5000, 0.0004, false);
  EXPECT_NEAR(double(fast.Window()), 3.1e6, 1e5);
}

TEST(TestBandwidthMeter, StaysInItsLimitsWhateverTheClockSays)
{
  BandwidthMeter meter;
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
