// SPDX-License-Identifier: BSD-3-Clause
// Fingers become gestures: taps, double taps, pinches; and invariants that hold for random fingers.
#include "viewer/session/GestureRecognizer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

using kdstream::Gesture;
using kdstream::GestureRecognizer;
using kdstream::GestureThresholds;
using kdstream::Touch;
using kdstream::TouchFrame;
using Kind = Gesture::Kind;

namespace
{

// All gestures of a list of frames.
std::vector<Gesture> Play(GestureRecognizer& recognizer, const std::vector<TouchFrame>& frames)
{
  std::vector<Gesture> all;
  for (const TouchFrame& frame : frames)
  {
    for (const Gesture& gesture : recognizer.HandleTouches(frame))
    {
      all.push_back(gesture);
    }
  }
  return all;
}

std::vector<Gesture> Play(const std::vector<TouchFrame>& frames)
{
  GestureRecognizer recognizer;
  return Play(recognizer, frames);
}

std::size_t Count(const std::vector<Gesture>& gestures, Kind kind)
{
  std::size_t count = 0;
  for (const Gesture& gesture : gestures)
  {
    count += gesture.kind == kind ? 1 : 0;
  }
  return count;
}

std::vector<TouchFrame> TwoTaps(double between, double way, double pressed = 0.05)
{
  return { { 0, { { 1, 100, 100 } } }, { pressed, {} },
    { pressed + between, { { 2, 100 + way, 100 } } }, { 2 * pressed + between, {} } };
}

TEST(TestGestureRecognizer, TapIsShortAndStill)
{
  EXPECT_EQ(Count(Play({ { 0, { { 1, 10, 20 } } }, { 0.3, {} } }), Kind::Tap), 1u);
  EXPECT_TRUE(Play({ { 0, { { 1, 10, 20 } } }, { 0.31, {} } }).empty());
  // A finger that stays within the slop still taps, at the place where it was put down.
  const auto tap = Play({ { 0, { { 1, 10, 20 } } }, { 0.1, { { 1, 17, 20 } } }, { 0.2, {} } });
  ASSERT_EQ(tap.size(), 1u);
  EXPECT_EQ(tap[0], (Gesture{ Kind::Tap, 10, 20 }));
  // A finger that leaves the slop and comes back rotates, and does not tap.
  const auto turn = Play({ { 0, { { 1, 10, 20 } } }, { 0.1, { { 1, 30, 20 } } },
    { 0.15, { { 1, 10, 20 } } }, { 0.2, {} } });
  EXPECT_EQ(Count(turn, Kind::Rotate), 2u);
  EXPECT_EQ(Count(turn, Kind::RotateEnd), 1u);
  EXPECT_EQ(turn.size(), 3u);
}

TEST(TestGestureRecognizer, DoubleTapWithinTimeAndDistanceOnly)
{
  EXPECT_EQ(Count(Play(TwoTaps(0.2, 10)), Kind::DoubleTap), 1u);
  EXPECT_EQ(Count(Play(TwoTaps(0.2, 10)), Kind::Tap), 1u);
  EXPECT_EQ(Count(Play(TwoTaps(0.34, 39)), Kind::DoubleTap), 1u);
  EXPECT_EQ(Count(Play(TwoTaps(0.36, 0)), Kind::DoubleTap), 0u);
  EXPECT_EQ(Count(Play(TwoTaps(0.36, 0)), Kind::Tap), 2u);
  EXPECT_EQ(Count(Play(TwoTaps(0.1, 41)), Kind::DoubleTap), 0u);
  EXPECT_EQ(Count(Play(TwoTaps(0.1, 0, 0.35)), Kind::DoubleTap), 0u);
}

TEST(TestGestureRecognizer, ThreeTapsAreOneDoubleTapAndFourAreTwo)
{
  std::vector<TouchFrame> frames;
  for (int i = 0; i < 4; ++i)
  {
    frames.push_back({ 0.2 * i, { { i, 50, 50 } } });
    frames.push_back({ 0.2 * i + 0.05, {} });
    EXPECT_EQ(Count(Play(frames), Kind::DoubleTap), static_cast<std::size_t>((i + 1) / 2)) << i;
  }
}

TEST(TestGestureRecognizer, WhatHappensBetweenTwoTapsParts)
{
  auto frames = TwoTaps(0.3, 0);
  // First with a short pinch between the two taps, then with a drag.
  frames.insert(
    frames.begin() + 2, { { 0.1, { { 7, 100, 100 }, { 8, 200, 100 } } }, { 0.15, {} } });
  EXPECT_EQ(Count(Play(frames), Kind::DoubleTap), 0u);
  frames[2] = { 0.1, { { 7, 100, 100 } } };
  frames[3] = { 0.12, { { 7, 150, 100 } } };
  frames.insert(frames.begin() + 4, { { 0.15, {} } });
  EXPECT_EQ(Count(Play(frames), Kind::DoubleTap), 0u);
}

TEST(TestGestureRecognizer, ThresholdsScaleWithThePixelRatio)
{
  GestureRecognizer fine;
  fine.SetPixelRatio(3);
  EXPECT_EQ(Count(Play(fine, TwoTaps(0.2, 119)), Kind::DoubleTap), 1u);
  fine.Reset();
  const auto still =
    Play(fine, { { 9, { { 1, 10, 20 } } }, { 9.1, { { 1, 33, 20 } } }, { 9.2, {} } });
  ASSERT_EQ(still.size(), 1u);
  EXPECT_EQ(still[0].kind, Kind::Tap);
}

TEST(TestGestureRecognizer, PinchScalesByTheRatioOfTheGap)
{
  std::mt19937 random(3);
  std::uniform_real_distribution<double> anywhere(0, 1000);
  for (int trial = 0; trial < 100; ++trial)
  {
    std::vector<TouchFrame> frames;
    double first = 0, last = 0, x = 0, y = 0;
    for (int i = 0; i < 20; ++i)
    {
      const Touch a{ 4, anywhere(random), anywhere(random) };
      const Touch b{ 9, anywhere(random), anywhere(random) };
      // The order of the fingers in a frame does not matter.
      frames.push_back({ i * 0.02, i % 3 == 0 ? std::vector{ b, a } : std::vector{ a, b } });
      last = std::max(16.0, std::hypot(a.x - b.x, a.y - b.y));
      first = i == 0 ? last : first;
      x = (a.x + b.x) / 2;
      y = (a.y + b.y) / 2;
    }
    frames.push_back({ 1, {} });
    double scale = 1, dx = 0, dy = 0, beginX = 0, beginY = 0;
    const auto gestures = Play(frames);
    for (const Gesture& gesture : gestures)
    {
      if (gesture.kind == Kind::PinchBegin)
      {
        beginX = gesture.x;
        beginY = gesture.y;
      }
      if (gesture.kind == Kind::Pinch)
      {
        scale *= gesture.scale;
        dx += gesture.dx;
        dy += gesture.dy;
      }
    }
    EXPECT_NEAR(scale, last / first, 1e-9 * scale);
    EXPECT_NEAR(beginX + dx, x, 1e-9);
    EXPECT_NEAR(beginY + dy, y, 1e-9);
    EXPECT_EQ(gestures.front().kind, Kind::PinchBegin);
    EXPECT_EQ(gestures.back().kind, Kind::PinchEnd);
    EXPECT_EQ(Count(gestures, Kind::Tap), 0u);
  }
}

TEST(TestGestureRecognizer, APinchNeverCountsAsATap)
{
  // Two short touches of two fingers that do not move; the fingers are lifted one after the other.
  const auto gestures = Play({ { 0, { { 1, 100, 100 } } },
    { 0.01, { { 1, 100, 100 }, { 2, 150, 100 } } }, { 0.05, { { 2, 150, 100 } } }, { 0.08, {} },
    { 0.2, { { 1, 100, 100 } } }, { 0.21, { { 1, 100, 100 }, { 2, 150, 100 } } },
    { 0.25, { { 1, 100, 100 } } }, { 0.28, {} } });
  EXPECT_EQ(Count(gestures, Kind::Tap) + Count(gestures, Kind::DoubleTap), 0u);
  // One finger, then a second one; both are lifted at once.
  const auto both = Play(
    { { 0, { { 1, 100, 100 } } }, { 0.01, { { 1, 100, 100 }, { 2, 150, 100 } } }, { 0.05, {} } });
  EXPECT_EQ(Count(both, Kind::Tap), 0u);
  EXPECT_EQ(Count(gestures, Kind::PinchBegin), 2u);
  EXPECT_EQ(Count(gestures, Kind::PinchEnd), 2u);
}

TEST(TestGestureRecognizer, TheFingerLeftOverMustLeaveTheSlopAgain)
{
  const auto gestures = Play({ { 0, { { 1, 100, 100 }, { 2, 200, 100 } } },
    { 0.1, { { 2, 200, 100 } } }, { 0.2, { { 2, 206, 100 } } }, { 0.3, { { 2, 220, 100 } } } });
  ASSERT_EQ(Count(gestures, Kind::Rotate), 1u);
  EXPECT_EQ(gestures.back().dx, 14);
}

TEST(TestGestureRecognizer, AThirdFingerIsIgnoredAndTakesOverWithoutAJump)
{
  const auto gestures = Play({ { 0, { { 1, 100, 100 }, { 2, 200, 100 } } },
    { 0.1, { { 3, 900, 900 }, { 1, 100, 100 }, { 2, 200, 100 } } },
    { 0.2, { { 3, 500, 100 }, { 2, 200, 100 } } }, // the first finger is lifted: a new pair
    { 0.3, { { 3, 800, 100 }, { 2, 200, 100 } } } });
  EXPECT_EQ(Count(gestures, Kind::PinchBegin), 2u);
  ASSERT_EQ(Count(gestures, Kind::Pinch), 1u);
  EXPECT_DOUBLE_EQ(gestures.back().scale, 2);
}

TEST(TestGestureRecognizer, HostileFramesAreHarmless)
{
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  const auto gestures = Play({ { nan, { { 1, nan, 0 }, { 2, 5, infinity } } },
    { 0.1, { { 1, 10, 10 }, { 1, 500, 500 } } }, { 0.05, { { 1, 10, 10 } } }, { -infinity, {} } });
  ASSERT_EQ(gestures.size(), 1u);
  EXPECT_EQ(gestures[0], (Gesture{ Kind::Tap, 10, 10 }));
}

// Whatever the fingers do: PinchBegin and PinchEnd alternate, with all pinches between them; scales
// are positive and finite; a sequence of several fingers has no tap.
TEST(TestGestureRecognizer, InvariantsHoldForRandomFingers)
{
  for (unsigned seed = 0; seed < 200; ++seed)
  {
    std::mt19937 random(seed);
    GestureRecognizer recognizer;
    double time = 0;
    bool pinching = false, several = false, moved = false;
    Touch start{};
    std::vector<Touch> fingers;
    for (int i = 0; i < 300; ++i)
    {
      const auto choice = random() % 10;
      if (choice < 3 && fingers.size() < 4)
      {
        fingers.push_back({ static_cast<std::int64_t>(random() % 5),
          static_cast<double>(random() % 300), static_cast<double>(random() % 300) });
      }
      else if (choice < 6 && !fingers.empty())
      {
        fingers.erase(fingers.begin() + static_cast<std::ptrdiff_t>(random() % fingers.size()));
      }
      else if (choice == 6)
      {
        fingers.clear();
      }
      else if (choice < 9)
      {
        for (Touch& finger : fingers)
        {
          finger.x += static_cast<double>(random() % 21) - 10;
          finger.y += static_cast<double>(random() % 21) - 10;
        }
      }
      time += 0.01 * static_cast<double>(random() % 12);
      const bool fresh = !recognizer.Touching();
      const auto gestures = recognizer.HandleTouches({ time, fingers });
      if (fresh && !fingers.empty())
      {
        several = moved = false;
        start = fingers[0];
      }
      for (const Touch& finger : fingers)
      {
        several = several || finger.id != start.id;
      }
      moved = moved ||
              (!fingers.empty() && std::hypot(fingers[0].x - start.x, fingers[0].y - start.y) > 8);
      for (const Gesture& gesture : gestures)
      {
        switch (gesture.kind)
        {
          case Kind::PinchBegin:
            EXPECT_FALSE(pinching);
            pinching = true;
            break;
          case Kind::PinchEnd:
            EXPECT_TRUE(pinching);
            pinching = false;
            break;
          case Kind::Pinch:
            EXPECT_TRUE(pinching);
            EXPECT_TRUE(std::isfinite(gesture.scale) && gesture.scale > 0);
            EXPECT_NEAR(std::hypot(gesture.twistCosine, gesture.twistSine), 1, 1e-12);
            break;
          case Kind::Rotate:
          case Kind::RotateEnd:
            EXPECT_FALSE(pinching);
            break;
          case Kind::Tap:
          case Kind::DoubleTap:
            EXPECT_FALSE(pinching || several || moved) << "seed " << seed << " step " << i;
            break;
        }
      }
      EXPECT_EQ(recognizer.Touching(), !fingers.empty());
      EXPECT_TRUE(!pinching || recognizer.Touching());
    }
  }
}

}
