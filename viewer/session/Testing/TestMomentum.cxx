// SPDX-License-Identifier: BSD-3-Clause
// A model that continues to turn after a release, or turns by itself: the resulting drags.
#include "viewer/session/camera/Momentum.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

using namespace kdstream;

namespace
{

constexpr double frame = 1.0 / 60;

// A finger moves to the right by 5 pixels a frame, for a fifth of a second, and is lifted `rest`
// seconds later.
Momentum LetGoAfter(double rest)
{
  Momentum momentum;
  double time = 10;
  momentum.Touch(time);
  for (int i = 0; i < 12; ++i)
  {
    momentum.Follow(time += frame, 5, 0);
  }
  momentum.LetGo(time + rest, 100, 200, 1);
  momentum.Forget();
  return momentum;
}
constexpr double letGo = 10 + 12 * frame;

double WayOf(const std::vector<Momentum::Drag>& drags)
{
  double way = 0;
  for (const Momentum::Drag& drag : drags)
  {
    EXPECT_EQ(drag.x, 100);
    EXPECT_EQ(drag.y, 200);
    EXPECT_EQ(drag.dy, 0);
    way += drag.dx;
  }
  return way;
}

TEST(TestMomentum, WhatIsLetGoTurnsOnEverSlowerAndEnds)
{
  Momentum momentum = LetGoAfter(0);
  ASSERT_TRUE(momentum.TurnsOn());
  const auto drags = momentum.Advance(letGo + 10, 1);
  EXPECT_FALSE(momentum.TurnsOn());
  ASSERT_GT(drags.size(), 10u);
  for (std::size_t i = 1; i < drags.size(); ++i)
  {
    EXPECT_LT(drags[i].dx, drags[i - 1].dx);
  }
  EXPECT_NEAR(WayOf(drags), 0.2 * 300, 0.05 * 300) << "as far as the finger goes in a fifth second";
}

TEST(TestMomentum, TheStepsAreTheSameWhateverTheFramesAre)
{
  Momentum momentum = LetGoAfter(0), jerky = LetGoAfter(0);
  std::vector<Momentum::Drag> smooth;
  for (double time = letGo; momentum.TurnsOn(); time += 0.007)
  {
    for (const Momentum::Drag& drag : momentum.Advance(time, 1))
    {
      smooth.push_back(drag);
    }
  }
  const auto atOnce = jerky.Advance(letGo + 10, 1);
  ASSERT_EQ(atOnce.size(), smooth.size());
  for (std::size_t i = 0; i < smooth.size(); ++i)
  {
    EXPECT_EQ(atOnce[i].dx, smooth[i].dx);
  }
}

TEST(TestMomentum, AFingerAtRestAndOneThatTakesNoTimeTurnNothingOn)
{
  EXPECT_FALSE(LetGoAfter(0.07).TurnsOn());
  Momentum keys;
  keys.Touch(1);
  keys.Follow(1, 50, 0);
  keys.LetGo(1, 0, 0, 1);
  EXPECT_FALSE(keys.TurnsOn());
  Momentum forgotten;
  forgotten.Touch(1);
  forgotten.Follow(1.05, 50, 0);
  forgotten.Forget();
  forgotten.LetGo(1.06, 0, 0, 1);
  EXPECT_FALSE(forgotten.TurnsOn());
}

TEST(TestMomentum, ItEndsWhereItIsStoppedAndByAnotherClock)
{
  Momentum stopped = LetGoAfter(0), other = LetGoAfter(0), lost = LetGoAfter(0);
  stopped.Stop();
  EXPECT_TRUE(stopped.Advance(letGo + 1, 1).empty());
  EXPECT_TRUE(other.Advance(3, 1).empty());
  EXPECT_FALSE(other.TurnsOn());
  EXPECT_TRUE(lost.Advance(std::nan(""), 1).empty());
  EXPECT_FALSE(lost.TurnsOn());
}

TEST(TestMomentum, SpinningGoesAsTimeDoesAndOnAfterAPause)
{
  Momentum momentum;
  momentum.SetSpinning(true);
  const Viewport window{ 800, 600, 1 };
  EXPECT_EQ(momentum.Spin(5, window).dx, 0);
  const double once = momentum.Spin(5 + frame, window).dx;
  EXPECT_GT(once, 0);
  EXPECT_NEAR(momentum.Spin(5 + 3 * frame, window).dx, 2 * once, 1e-9);
  EXPECT_NEAR(momentum.Spin(1000, window).dx, once * 0.1 / frame, 1e-9) << "no leap";
  EXPECT_EQ(momentum.Spin(3, window).dx, 0) << "nor back";
  momentum.SetSpinning(false);
  EXPECT_FALSE(momentum.IsSpinning());
}

}
