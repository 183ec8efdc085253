// SPDX-License-Identifier: BSD-3-Clause
// Decoding, making a surface and drawing it happen in different frames, and surfaces leave two
// thirds of the time for following the fingers.
#include "viewer/mobile/SurfacePace.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <random>

using kdstream::SurfacePace;

TEST(TestSurfacePace, AFrameThatDecodedMakesNoSurfaceButEveryThird)
{
  SurfacePace pace;
  std::uint64_t loaded = 0;
  EXPECT_FALSE(pace.PutsOff(loaded)) << "nothing has come";
  for (int round = 0; round < 4; ++round)
  {
    EXPECT_TRUE(pace.PutsOff(++loaded));
    EXPECT_TRUE(pace.IsPuttingOff());
    EXPECT_TRUE(pace.PutsOff(loaded += 5));
    EXPECT_FALSE(pace.PutsOff(++loaded)) << "two were put off";
    pace.Made(0.001);
    EXPECT_FALSE(pace.IsPuttingOff());
  }
  EXPECT_TRUE(pace.PutsOff(++loaded));
  EXPECT_FALSE(pace.PutsOff(loaded)) << "nothing has come since";
  EXPECT_FALSE(pace.IsPuttingOff());
}

TEST(TestSurfacePace, TheNextWaitsForTwiceAsLongWhileMoreIsComing)
{
  SurfacePace pace;
  EXPECT_TRUE(pace.MayDraw(true, 0)) << "the first";
  pace.Drawn(10, 0.25);
  EXPECT_FALSE(pace.MayDraw(true, 10.49));
  EXPECT_TRUE(pace.MayDraw(true, 10.5));
  EXPECT_TRUE(pace.MayDraw(false, 10.01)) << "the last one is drawn at once";
  pace.Drawn(20, 30);
  EXPECT_FALSE(pace.MayDraw(true, 20.99));
  EXPECT_TRUE(pace.MayDraw(true, 21)) << "a slow device shows something once a second";
}

// As in PagePicture: something arrives in every frame, and making each surface takes a given time.
// No surface takes so long that the longest wait is reached.
TEST(TestSurfacePace, SurfacesTakeAThirdOfTheTimeAtMost)
{
  std::mt19937 random(7);
  std::uniform_real_distribution<double> slow(0.001, 0.25);
  SurfacePace pace;
  constexpr double frame = 1.0 / 60;
  double now = 0, onSurfaces = 0, longest = 0;
  std::uint64_t loaded = 0;
  bool isMade = false;
  int drawn = 0;
  for (int i = 0; i < 20'000; ++i)
  {
    const double begin = now;
    bool made = false;
    if (isMade)
    {
      const double drawing = slow(random);
      now += drawing;
      onSurfaces += drawing + pace.MakingSeconds();
      pace.Drawn(now, drawing + pace.MakingSeconds());
      isMade = false;
      ++drawn;
    }
    else if (!pace.PutsOff(++loaded) && pace.MayDraw(true, now))
    {
      const double making = slow(random);
      now += making;
      pace.Made(making);
      isMade = made = true;
    }
    now += made ? 0 : frame;
    longest = std::max(longest, now - begin);
  }
  EXPECT_GT(drawn, 500);
  EXPECT_LE(onSurfaces / now, 1.0 / 3);
  EXPECT_LE(longest, 0.25 + frame) << "making and drawing share no frame";
}
