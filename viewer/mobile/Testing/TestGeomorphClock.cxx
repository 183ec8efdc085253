// SPDX-License-Identifier: BSD-3-Clause
// New vertices morph for 150 ms, but not on a device that draws too few pictures in that time.
#include "viewer/mobile/GeomorphClock.h"

#include <gtest/gtest.h>

using namespace kdstream;

namespace
{

constexpr double start = 1000;

// Draws a geomorph at this number of pictures per second. Returns the time when it was over.
double Geomorph(GeomorphClock& clock, double now, double rate)
{
  clock.Begin(now);
  double last = now, share = 0;
  for (int i = 0; last <= now + GeomorphClock::duration; ++i)
  {
    last = now + i / rate;
    const double next = clock.Share(last);
    EXPECT_GE(next, share) << "never back";
    share = next;
  }
  EXPECT_EQ(share, 1);
  return last;
}

TEST(TestGeomorphClock, WithoutAGeomorphAllIsAtItsPlace)
{
  GeomorphClock clock;
  EXPECT_TRUE(clock.MayBegin(start));
  EXPECT_EQ(clock.Share(start), 1);
  EXPECT_TRUE(clock.MayBegin(start));
}

TEST(TestGeomorphClock, TakesAbout150MillisecondsSlowlyAtItsEnds)
{
  GeomorphClock clock;
  clock.Begin(start);
  EXPECT_EQ(clock.Share(start), 0);
  const double early = clock.Share(start + 0.015), middle = clock.Share(start + 0.075),
               late = clock.Share(start + 0.135);
  EXPECT_GT(early, 0);
  EXPECT_LT(early, 0.05);
  EXPECT_NEAR(middle, 0.5, 1e-6);
  EXPECT_NEAR(late, 1 - early, 1e-6);
  EXPECT_LT(clock.Share(start + 0.149), 1);
  EXPECT_EQ(clock.Share(start + 0.151), 1);
  GeomorphClock other;
  EXPECT_NEAR(Geomorph(other, start, 1000) - start, 0.15, 0.0021);
}

TEST(TestGeomorphClock, ADeviceThatKeepsItsRateGoesOn)
{
  GeomorphClock clock;
  double now = start;
  for (int geomorph = 0; geomorph < 20; ++geomorph)
  {
    now = Geomorph(clock, now + 0.01, 60);
    EXPECT_TRUE(clock.MayBegin(now));
  }
}

// Does not morph for ten seconds, then tries again.
TEST(TestGeomorphClock, ASlowDeviceRests)
{
  GeomorphClock clock;
  const double end = Geomorph(clock, start, 20); // three or four pictures
  EXPECT_FALSE(clock.MayBegin(end));
  EXPECT_FALSE(clock.MayBegin(end + 9.9));
  EXPECT_TRUE(clock.MayBegin(end + 10));
  EXPECT_EQ(clock.Share(end + 5), 1) << "what is drawn meanwhile is at its place";
  EXPECT_TRUE(clock.MayBegin(end + 10)) << "and lengthens nothing";
  const double second = Geomorph(clock, end + 10, 60);
  EXPECT_TRUE(clock.MayBegin(second));
}

}
