// SPDX-License-Identifier: BSD-3-Clause
// How fingers and keys move the camera, and that the model cannot get out of sight.
#include "viewer/session/Testing/TorusModel.h"
#include "viewer/session/camera/CameraControl.h"

#include <gtest/gtest.h>

#include <cmath>

using namespace kdstream;
using namespace kdstream::testing;

namespace
{

struct Controlled : TorusModel
{
  CameraControl control{ this->model, Turning::Free, true };
  bool isTaken = false;

  Controlled()
  {
    this->control.Resize({ width, height, 1 });
    this->control.Fit();
  }
  double DistanceToBox() const
  {
    return this->control.Get().DistanceTo(this->server.Description().box);
  }
  // A finger that drags the model to the right by 5 pixels a frame.
  void Swipe(double& time)
  {
    for (int i = 0; i <= 12; ++i)
    {
      this->Touch({ time += 1.0 / 60, { { 1, 100 + 5.0 * i, 300 } } });
    }
    this->Touch({ time, {} });
  }
  void Touch(const TouchFrame& frame)
  {
    for (const Gesture& gesture : this->control.BeginTouches(frame))
    {
      this->control.Handle(gesture, frame.time, this->isTaken);
    }
    this->control.EndTouches(frame);
  }
};

TEST(TestCameraControl, EyeStaysOutsideOfWhatIsShown)
{
  for (const bool isShown : { false, true })
  {
    Controlled torus;
    if (isShown)
    {
      torus.Show();
    }
    for (int i = 0; i < 20; ++i)
    {
      torus.control.ZoomAbout(2, onRingX, onRingY);
    }
    EXPECT_TRUE(torus.control.HasMoved());
    EXPECT_TRUE(isShown || torus.DistanceToBox() > 0);
    EXPECT_FALSE(isShown && IsAround(torus.model.Drawn(), torus.control.Get().Eye()));
    for (int i = 0; i < 30; ++i)
    {
      torus.control.ZoomAbout(0.5, onRingX, onRingY);
    }
    EXPECT_GT(torus.DistanceToBox(), 1);
  }
}

// If a new surface surrounds the eye, the eye steps back; but not if a host's own camera sets the
// view.
TEST(TestCameraControl, StepsBackOutOfASurfaceThatComesAroundTheEye)
{
  for (const bool isLed : { false, true })
  {
    Controlled torus;
    torus.Show();
    const Vec3 inside{ 1, 0, 0 };
    ASSERT_TRUE(IsAround(torus.model.Drawn(), inside));
    if (isLed)
    {
      torus.control.LookFrom(inside, { 0, 0, 0 }, { 0, 1, 0 }, 0.3, true);
    }
    else
    {
      Camera there = torus.control.Get();
      there.LookFrom(inside, { 0, 0, 0 }, { 0, 1, 0 }, Camera::tangentOfHalfAngle);
      torus.control.TakePlace(there.GetPlace(), false);
    }
    torus.control.FollowSurface();
    EXPECT_TRUE(IsAround(torus.model.Drawn(), torus.control.Get().Eye())); // not yet, in both
    torus.control.Arrive();
    EXPECT_EQ(IsAround(torus.model.Drawn(), torus.control.Get().Eye()), isLed);
  }
}

// Another window then still shows the first view, because nobody has moved.
TEST(TestCameraControl, AHostThatLooksFromTheSamePlaceHasNotMoved)
{
  Controlled torus;
  const auto look = [&](bool begins) {
    return torus.control.LookFrom({ 0, 0, 5 }, { 0, 0, 0 }, { 0, 1, 0 }, 0.3, begins);
  };
  EXPECT_TRUE(look(true));
  EXPECT_TRUE(torus.control.HasMoved());
  torus.control.Reset(); // another model, before it is open
  EXPECT_FALSE(look(false));
  EXPECT_FALSE(torus.control.HasMoved());
  EXPECT_TRUE(look(true));
  EXPECT_TRUE(torus.control.HasMoved());
}

TEST(TestCameraControl, JumpsAreTakenBackOneByOne)
{
  Controlled torus;
  const Camera first = torus.control.Get();
  EXPECT_FALSE(torus.control.CanUndo());
  EXPECT_FALSE(torus.control.JumpToSide("beside"));
  EXPECT_TRUE(torus.control.JumpToSide("front")); // the camera is there already
  EXPECT_FALSE(torus.control.CanUndo());
  EXPECT_TRUE(torus.control.JumpToSide("top"));
  const Camera top = torus.control.Get();
  torus.control.JumpHome();
  EXPECT_EQ(torus.control.Get(), first);
  EXPECT_TRUE(torus.control.Undo());
  EXPECT_EQ(torus.control.Get(), top);
  EXPECT_TRUE(torus.control.Undo());
  EXPECT_EQ(torus.control.Get(), first);
  EXPECT_FALSE(torus.control.Undo());
}

TEST(TestCameraControl, WindowThatComesBackShowsWhatItShowed)
{
  Controlled torus;
  torus.control.ZoomAbout(3, 400, 300);
  const Camera before = torus.control.Get();
  torus.control.Resize({ height, width, 2 });
  EXPECT_NE(torus.control.Get(), before);
  torus.control.Resize({ width, height, 1 });
  EXPECT_EQ(torus.control.Get(), before);
}

// A window may change its shape while it opens; the link's place is then taken again.
TEST(TestCameraControl, PlaceOfALinkIsTakenAnewUntilSomebodyMoves)
{
  Controlled torus;
  torus.control.ZoomAbout(3, onRingX, onRingY);
  const CameraPlace place = torus.control.Get().GetPlace();
  Controlled other;
  other.control.Resize({ 200, 900, 1 });
  other.control.TakePlace(place, true);
  EXPECT_TRUE(other.control.CanUndo());
  EXPECT_TRUE(other.control.HasMoved());
  other.control.Resize({ width, height, 1 });
  const auto distance = [&]
  { return Length(other.control.Get().Eye() - torus.control.Get().Eye()); };
  EXPECT_LT(distance(), 1e-9);
  double time = 10;
  other.Swipe(time);
  const Camera turned = other.control.Get();
  EXPECT_GT(distance(), 0.1);
  other.control.Resize({ 200, 900, 1 });
  other.control.Resize({ width, height, 1 });
  EXPECT_EQ(other.control.Get(), turned);
}

TEST(TestCameraControl, TurnsOnWhenItIsLetGo)
{
  Controlled torus;
  double time = 10;
  torus.Swipe(time);
  ASSERT_TRUE(torus.control.Coasts());
  const Camera let = torus.control.Get();
  EXPECT_TRUE(torus.control.Advance(time + 0.5).coasted);
  EXPECT_NE(torus.control.Get(), let);
  torus.control.Advance(time + 60);
  EXPECT_FALSE(torus.control.Coasts());
  EXPECT_FALSE(torus.control.Advance(time + 61).coasted);

  torus.control.SetCoasting(false);
  torus.Swipe(time);
  EXPECT_FALSE(torus.control.Coasts());
}

TEST(TestCameraControl, OfWhatIsTakenOnlyThePinchZooms)
{
  Controlled torus;
  const Camera before = torus.control.Get();
  torus.isTaken = true;
  double time = 10;
  torus.Swipe(time);
  EXPECT_EQ(torus.control.Get(), before);
  EXPECT_FALSE(torus.control.Coasts());
  for (int i = 0; i <= 10; ++i)
  {
    torus.Touch({ time += 0.1, { { 1, 300, 300.0 + i }, { 2, 500.0 + 20 * i, 300.0 + i } } });
  }
  EXPECT_LT(torus.control.Get().Distance(), before.Distance());
  EXPECT_EQ(torus.control.Get().Orientation(), before.Orientation());
  EXPECT_FALSE(torus.control.ZoomAbout(0, 10, 10));
  EXPECT_FALSE(torus.control.ZoomAbout(std::nan(""), 10, 10));
}

TEST(TestCameraControl, SpinsUntilAFingerComes)
{
  Controlled torus;
  torus.control.SetSpinning(true);
  torus.control.Advance(1);
  const Camera before = torus.control.Get();
  EXPECT_TRUE(torus.control.Advance(2).spun);
  EXPECT_NE(torus.control.Get(), before);
  torus.control.BeginTouches({ 3, { { 1, 10, 10 } } });
  EXPECT_FALSE(torus.control.Spins());
  EXPECT_FALSE(torus.control.Advance(4).spun);
}

TEST(TestCameraControl, AnotherModelForgetsTheLastOne)
{
  Controlled torus;
  torus.control.JumpToSide("top");
  torus.control.ZoomAbout(2, 400, 300);
  torus.control.SetSpinning(true);
  torus.control.Reset();
  EXPECT_FALSE(torus.control.CanUndo());
  EXPECT_FALSE(torus.control.HasMoved());
  EXPECT_FALSE(torus.control.Spins());
}

}
