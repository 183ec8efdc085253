// SPDX-License-Identifier: BSD-3-Clause
// Mouse and keys become touches, for the GestureRecognizer.
#include "viewer/session/InputTouches.h"

#include <gtest/gtest.h>

using namespace kdstream;

namespace
{

constexpr Viewport window{ 800, 600, 2 };

template <class FrameOf>
std::vector<Gesture> GesturesOf(unsigned frames, const FrameOf& frameOf)
{
  GestureRecognizer recognizer;
  recognizer.SetPixelRatio(window.pixelRatio);
  std::vector<Gesture> all;
  for (unsigned frame = 0; frame < frames; ++frame)
  {
    for (const Gesture& gesture : recognizer.HandleTouches(frameOf(frame)))
    {
      all.push_back(gesture);
    }
  }
  EXPECT_FALSE(recognizer.Touching());
  return all;
}

std::vector<Gesture> GesturesOfDrag(double right, double down, bool pans)
{
  return GesturesOf(
    dragFrames, [&](unsigned frame) { return DragByKey(window, right, down, pans, 3, frame); });
}

std::vector<Gesture> GesturesOfTaps(unsigned taps)
{
  return GesturesOf(taps * tapFrames, [](unsigned frame) { return TapByKey(window, 3, frame); });
}

TEST(TestInputTouches, ARightButtonIsTwoFingersAsFarApartAsOnEveryScreen)
{
  std::vector<Touch> touches;
  AddTouches({ 4, 100, 50, false }, 2, touches);
  AddTouches({ 6, 300, 50, true }, 2, touches);
  EXPECT_EQ(touches, (std::vector<Touch>{ { 4, 100, 50 }, { 6, 180, 50 }, { 7, 420, 50 } }));
}

TEST(TestInputTouches, AnArrowKeyTurnsByAStepOfTheScreenInPoints)
{
  const auto gestures = GesturesOfDrag(-1, 0, false);
  ASSERT_FALSE(gestures.empty());
  EXPECT_EQ(gestures.back().kind, Gesture::Kind::RotateEnd);
  double across = 0;
  for (const Gesture& gesture : gestures)
  {
    EXPECT_NE(gesture.kind, Gesture::Kind::Tap);
    EXPECT_EQ(gesture.dy, 0);
    across += gesture.dx;
  }
  EXPECT_DOUBLE_EQ(across, -50 * window.pixelRatio);
}

TEST(TestInputTouches, WithTwoFingersItPansAndDoesNotZoom)
{
  double across = 0;
  for (const Gesture& gesture : GesturesOfDrag(0, 1, true))
  {
    EXPECT_NE(gesture.kind, Gesture::Kind::Rotate);
    EXPECT_EQ(gesture.scale, 1);
    across += gesture.dy;
  }
  EXPECT_GE(across, 40 * window.pixelRatio);
}

TEST(TestInputTouches, TwoTapsAreADoubleTapInTheMiddle)
{
  const auto once = GesturesOfTaps(1);
  ASSERT_EQ(once.size(), 1u);
  EXPECT_EQ(once[0].kind, Gesture::Kind::Tap);
  const auto twice = GesturesOfTaps(2);
  ASSERT_FALSE(twice.empty());
  EXPECT_EQ(twice.back().kind, Gesture::Kind::DoubleTap);
  EXPECT_DOUBLE_EQ(twice.back().x, 400);
  EXPECT_DOUBLE_EQ(twice.back().y, 300);
}

}
