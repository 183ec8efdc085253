// SPDX-License-Identifier: BSD-3-Clause
// What mouse and keys stand for, as the recognizer of gestures takes it.
#include "viewer/session/InputTouches.h"

#include <gtest/gtest.h>

using namespace kdstream;

namespace
{

constexpr Viewport window{ 800, 600, 2 };

std::vector<Gesture> GesturesOf(const std::vector<TouchFrame>& frames)
{
  GestureRecognizer recognizer;
  recognizer.SetPixelRatio(window.pixelRatio);
  std::vector<Gesture> all;
  for (const TouchFrame& frame : frames)
  {
    for (const Gesture& gesture : recognizer.HandleTouches(frame))
    {
      all.push_back(gesture);
    }
  }
  EXPECT_FALSE(recognizer.Touching());
  return all;
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
  const auto gestures = GesturesOf(DragByKey(window, -1, 0, false, 3));
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
  for (const Gesture& gesture : GesturesOf(DragByKey(window, 0, 1, true, 3)))
  {
    EXPECT_NE(gesture.kind, Gesture::Kind::Rotate);
    EXPECT_EQ(gesture.scale, 1);
    across += gesture.dy;
  }
  EXPECT_GE(across, 40 * window.pixelRatio);
}

TEST(TestInputTouches, TwoTapsAreADoubleTapInTheMiddle)
{
  const auto once = GesturesOf(TapByKey(window, 1, 3));
  ASSERT_EQ(once.size(), 1u);
  EXPECT_EQ(once[0].kind, Gesture::Kind::Tap);
  const auto twice = GesturesOf(TapByKey(window, 2, 3));
  ASSERT_FALSE(twice.empty());
  EXPECT_EQ(twice.back().kind, Gesture::Kind::DoubleTap);
  EXPECT_DOUBLE_EQ(twice.back().x, 400);
  EXPECT_DOUBLE_EQ(twice.back().y, 300);
}

}
