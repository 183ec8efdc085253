// SPDX-License-Identifier: BSD-3-Clause
// Mouse, wheel, keys and fingers as steps of a session.
#include "viewer/desktop/window/WindowInput.h"

#include <gtest/gtest.h>

using namespace kdstream;
using Kind = WindowEvent::Kind;
using Button = WindowEvent::Button;

namespace
{

WindowEvent Event(Kind kind, double x, double y, double time, Button button = Button::Left)
{
  WindowEvent event;
  event.kind = kind;
  event.x = x;
  event.y = y;
  event.time = time;
  event.button = button;
  return event;
}

WindowEvent Key(const std::string& key)
{
  WindowEvent event = Event(Kind::Key, 0, 0, 1);
  event.key = key;
  return event;
}

WindowInput Input()
{
  WindowInput input;
  input.SetView(100, 50, { 800, 600, 2 });
  return input;
}

SessionStep Touches(double time, std::vector<Touch> touches)
{
  return { SessionStep::Kind::Touches, { time, std::move(touches) } };
}

using Steps = std::vector<SessionStep>;

TEST(TestWindowInput, TheLeftButtonIsAFingerOfTheView)
{
  WindowInput input = Input();
  EXPECT_EQ(input.Handle(Event(Kind::Move, 1, 1, 0)), Steps());
  EXPECT_EQ(input.Flush(), Steps()) << "nothing is down";
  EXPECT_EQ(input.Handle(Event(Kind::Press, 110, 60, 1)), Steps({ Touches(1, { { 0, 10, 10 } }) }));
  EXPECT_TRUE(input.Touching());
  EXPECT_EQ(input.Handle(Event(Kind::Move, 120, 60, 2)), Steps());
  EXPECT_EQ(input.Handle(Event(Kind::Move, 130, 65, 3)), Steps());
  EXPECT_EQ(input.Flush(), Steps({ Touches(3, { { 0, 30, 15 } }) })) << "all moves are one";
  EXPECT_EQ(input.Flush(), Steps());
  input.Handle(Event(Kind::Move, 140, 65, 4));
  EXPECT_EQ(input.Handle(Event(Kind::Release, 140, 65, 5)),
    Steps({ Touches(4, { { 0, 40, 15 } }), Touches(5, {}) }));
  EXPECT_FALSE(input.Touching());
}

TEST(TestWindowInput, RightMiddleAndShiftedButtonsAreTwoFingers)
{
  const Steps two{ Touches(1, { { 0, 10 - 120, 10 }, { 1, 10 + 120, 10 } }) };
  WindowEvent shifted = Event(Kind::Press, 110, 60, 1);
  shifted.shift = true;
  for (const WindowEvent& press : { shifted, Event(Kind::Press, 110, 60, 1, Button::Right),
         Event(Kind::Press, 110, 60, 1, Button::Middle) })
  {
    EXPECT_EQ(Input().Handle(press), two);
  }
  // A second button changes nothing, because the mouse is one pointer.
  WindowInput input = Input();
  input.Handle(Event(Kind::Press, 110, 60, 1));
  EXPECT_EQ(input.Handle(Event(Kind::Press, 110, 60, 2, Button::Right)), Steps());
  EXPECT_EQ(input.Handle(Event(Kind::Release, 110, 60, 3, Button::Right)).size(), 1u);
  EXPECT_EQ(input.Handle(Event(Kind::Release, 110, 60, 4)), Steps());
}

TEST(TestWindowInput, FingersStayApartFromTheMouseAndFromEachOther)
{
  WindowInput input = Input();
  WindowEvent first = Event(Kind::TouchBegin, 110, 60, 1);
  first.finger = 7;
  WindowEvent second = Event(Kind::TouchBegin, 120, 60, 2);
  second.finger = 8;
  input.Handle(first);
  EXPECT_EQ(input.Handle(second), Steps({ Touches(2, { { 16, 10, 10 }, { 18, 20, 10 } }) }));
  WindowEvent move = Event(Kind::TouchMove, 150, 60, 3);
  move.finger = 8;
  input.Handle(move);
  EXPECT_EQ(input.Flush(), Steps({ Touches(3, { { 16, 10, 10 }, { 18, 50, 10 } }) }));
  WindowEvent end = Event(Kind::TouchEnd, 110, 60, 4);
  end.finger = 7;
  EXPECT_EQ(input.Handle(end), Steps({ Touches(4, { { 18, 50, 10 } }) }));
}

TEST(TestWindowInput, ATrackpadsPinchZoomsWhereThePointerIs)
{
  WindowInput input = Input();
  WindowEvent pinch = Event(Kind::Pinch, 110, 60, 1);
  pinch.scale = 1.25;
  const auto steps = input.Handle(pinch);
  ASSERT_EQ(steps.size(), 1u);
  EXPECT_EQ(steps[0].kind, SessionStep::Kind::Zoom);
  EXPECT_EQ(steps[0].factor, 1.25);
  EXPECT_EQ(steps[0].x, 10);
  EXPECT_EQ(steps[0].y, 10);
}

TEST(TestWindowInput, TheWheelZoomsWhereThePointerIs)
{
  WindowInput input = Input();
  WindowEvent wheel = Event(Kind::Wheel, 110, 60, 1);
  for (const double notches : { 1.0, -1.0, 2.5 })
  {
    wheel.notches = notches;
    const Steps steps = input.Handle(wheel);
    ASSERT_EQ(steps.size(), 1u);
    EXPECT_EQ(steps[0].kind, SessionStep::Kind::Zoom);
    EXPECT_DOUBLE_EQ(steps[0].x, 10);
    EXPECT_DOUBLE_EQ(steps[0].y, 10);
    EXPECT_EQ(steps[0].factor > 1, notches > 0);
  }
  // Moves that preceded the wheel come before it.
  input.Handle(Event(Kind::Press, 110, 60, 1));
  input.Handle(Event(Kind::Move, 120, 60, 2));
  EXPECT_EQ(input.Handle(wheel).size(), 2u);
}

TEST(TestWindowInput, KeysTurnZoomJumpAndTap)
{
  const Steps right = Input().Handle(Key("Right"));
  ASSERT_EQ(right.size(), 4u);
  EXPECT_EQ(right[0], Touches(1, { { -1, 400, 300 } }));
  EXPECT_GT(right[2].frame.touches[0].x, right[1].frame.touches[0].x);
  EXPECT_TRUE(right[3].frame.touches.empty());
  EXPECT_LT(Input().Handle(Key("Up"))[2].frame.touches[0].y, 300);
  EXPECT_GT(Input().Handle(Key("plus"))[0].factor, 1);
  EXPECT_LT(Input().Handle(Key("minus"))[0].factor, 1);
  EXPECT_EQ(Input().Handle(Key("h")), Steps({ { SessionStep::Kind::Go, {}, "home" } }));
  EXPECT_EQ(Input().Handle(Key("BackSpace")), Steps({ { SessionStep::Kind::Go, {}, "undo" } }));
  EXPECT_EQ(Input().Handle(Key("x")), Steps());
  WindowEvent withControl = Key("h");
  withControl.control = true;
  EXPECT_EQ(Input().Handle(withControl), Steps());

  // The touches of Return are recognized as a double tap.
  GestureRecognizer gestures;
  std::vector<Gesture> all;
  for (const SessionStep& step : Input().Handle(Key("Return")))
  {
    for (const Gesture& gesture : gestures.HandleTouches(step.frame))
    {
      all.push_back(gesture);
    }
  }
  ASSERT_FALSE(all.empty());
  EXPECT_EQ(all.back().kind, Gesture::Kind::DoubleTap);
  EXPECT_DOUBLE_EQ(all.back().x, 400);
  // Those of an arrow are recognized as a turn, and not as a tap.
  gestures.Reset();
  all.clear();
  for (const SessionStep& step : right)
  {
    for (const Gesture& gesture : gestures.HandleTouches(step.frame))
    {
      all.push_back(gesture);
    }
  }
  ASSERT_FALSE(all.empty());
  for (const Gesture& gesture : all)
  {
    EXPECT_TRUE(gesture.kind == Gesture::Kind::Rotate || gesture.kind == Gesture::Kind::RotateEnd);
  }
}

}
