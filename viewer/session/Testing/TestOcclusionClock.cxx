// SPDX-License-Identifier: BSD-3-Clause
#include "viewer/session/appearance/OcclusionClock.h"

#include <gtest/gtest.h>

namespace kdstream::test
{
namespace
{

// Moves a view for a second, and counts its pictures, and those with occlusion. with, without: the
// seconds that a picture takes with occlusion, and without it.
struct Count
{
  int occluded = 0, all = 0;
};
Count Move(OcclusionClock& clock, double& now, double with, double without)
{
  Count count;
  for (const double end = now + 1; now < end; ++count.all)
  {
    const bool occluded = clock.Has(true, now);
    const double frame = occluded ? with : without;
    count.occluded += occluded ? 1 : 0;
    now += frame;
    clock.Drawn(occluded, frame, now);
  }
  return count;
}

TEST(OcclusionClock, AQuickDeviceAlwaysHasIt)
{
  OcclusionClock clock;
  double now = 100;
  const Count count = Move(clock, now, 0.017, 0.016);
  EXPECT_GT(count.all, 50);
  EXPECT_EQ(count.occluded, count.all);
}

TEST(OcclusionClock, ASlowDeviceHasItAtRest)
{
  OcclusionClock clock;
  double now = 100;
  const Count count = Move(clock, now, 0.08, 0.02);
  EXPECT_EQ(count.occluded, OcclusionClock::slowFrames);
  EXPECT_FALSE(clock.Has(false, now + 0.5 * OcclusionClock::stillness));
  EXPECT_TRUE(clock.Has(false, now + OcclusionClock::stillness));
  EXPECT_FALSE(clock.Has(true, now + 1)); // the view moves again
  now += OcclusionClock::pause;
  EXPECT_EQ(Move(clock, now, 0.017, 0.016).occluded, 59); // the device is quick by now
}

// One or two slow frames do not mean that the device is slow, and neither do pictures without
// occlusion, or the time that a view rests.
TEST(OcclusionClock, SomeSlowFramesDoNotCount)
{
  OcclusionClock clock;
  double now = 100;
  for (int i = 0; i < 60; ++i)
  {
    EXPECT_TRUE(clock.Has(true, now));
    const double frame = i % 3 == 0 ? 0.016 : 0.2;
    now += frame;
    clock.Drawn(true, frame, now);
  }
  EXPECT_TRUE(clock.Has(false, now));
  for (int i = 0; i < 10; ++i)
  {
    clock.Drawn(true, 1, now);
    clock.Drawn(false, 1, now);
  }
  EXPECT_TRUE(clock.Has(true, now));
}

}
}
