// SPDX-License-Identifier: BSD-3-Clause
// A camera with which the user cannot get lost: home, undo, a level horizon; and whatever the
// fingers do, the model is on the screen, and the eye is outside the model.
#include "viewer/session/Picker.h"
#include "viewer/session/Testing/SessionsByLevel.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <random>

using namespace kdstream;
using namespace kdstream::testing;

namespace
{

const HomeView leaningBack{ { 0, 0, 1 }, { 0, -0.8, 0.6 }, false };

// A sheet with hills, in the coordinates of a map, seen from the south: its box is mostly empty.
Mesh MakeTerrain(std::uint32_t n)
{
  Mesh mesh;
  for (std::uint32_t i = 0; i < n * n; ++i)
  {
    const double x = double(i % n) / n, y = double(i / n) / n;
    const double height =
      0.08 * std::sin(9 * x) * std::cos(7 * y) + 0.01 * std::sin(60 * x + 50 * y);
    mesh.points.push_back({ 456789 + 400 * x, 5412345 + 400 * y, 300 + 400 * height });
  }
  for (std::uint32_t i = 0; i + 1 < n; ++i)
  {
    for (std::uint32_t k = i * n; k + 1 < (i + 1) * n; ++k)
    {
      mesh.triangles.push_back({ k, k + 1, k + n });
      mesh.triangles.push_back({ k + 1, k + n + 1, k + n });
    }
  }
  return mesh;
}

MemoryServer Terrain()
{
  static const MemoryServer server(MakeTerrain(100), 128, 2);
  return server;
}

struct View
{
  Vec3 eye, focal, up;
  Quaternion orientation;
  bool operator==(const View&) const = default;
};

View ViewOf(const ViewerSession& session)
{
  const ViewerScene scene = session.Scene();
  return { scene.eye, scene.focal, scene.up, scene.orientation };
}

// Whether any of the shown surface is on the screen: a vertex is, or, for larger triangles, a ray
// through a pixel of a grid hits it.
bool ShowsSurface(const ViewerScene& scene, const Viewport& window)
{
  constexpr int steps = 24;
  const double up = Camera::tangentOfHalfAngle, right = up * window.width / window.height;
  const Surface surface = scene.surface->Whole();
  for (const Vec3& point : surface.points)
  {
    const Vec3 seen = scene.orientation.Inverse().Rotate(point - scene.eye);
    if (std::abs(seen[0]) <= right * -seen[2] && std::abs(seen[1]) <= up * -seen[2])
    {
      return true;
    }
  }
  for (int i = 0; i <= steps; ++i)
  {
    for (int j = 0; j <= steps; ++j)
    {
      const Vec3 sight{ right * (2.0 * i / steps - 1), up * (2.0 * j / steps - 1), -1 };
      if (PickSurface(surface, { scene.eye, Normalized(scene.orientation.Rotate(sight)) }))
      {
        return true;
      }
    }
  }
  return false;
}

bool IsIn(const Box& box, const Vec3& point)
{
  bool in = !box.Empty();
  for (std::size_t k = 0; k < 3; ++k)
  {
    in = in && point[k] > box.lo[k] && point[k] < box.hi[k];
  }
  return in;
}

// Whether a closed surface surrounds a point: its winding number, by the solid angles of its
// triangles (van Oosterom and Strackee, 1983).
bool IsInside(const Surface& surface, const Vec3& point)
{
  double angle = 0;
  for (const Triangle& t : surface.triangles)
  {
    const Vec3 a = surface.points[t[0]] - point, b = surface.points[t[1]] - point,
               c = surface.points[t[2]] - point;
    const double la = Length(a), lb = Length(b), lc = Length(c);
    angle += 2 * std::atan2(Dot(a, Cross(b, c)),
                   la * lb * lc + Dot(a, b) * lc + Dot(b, c) * la + Dot(c, a) * lb);
  }
  return std::abs(angle) > 2 * std::acos(-1.0);
}

// A user who does anything, quickly.
class Person
{
public:
  Person(unsigned seed, MemoryServer& server, ViewerSession& session)
    : Random(seed)
    , Server(server)
    , Session(session)
  {
    this->Session.Resize(this->Window);
  }

  // Returns what was done, for messages.
  std::string DoSomething();
  double Time() const { return this->Now; }
  Viewport Window{ 600, 800, 2 };
  Turning turning = Turning::Upright;

private:
  double Any(double from, double to)
  {
    return std::uniform_real_distribution<double>(from, to)(this->Random);
  }
  void Touch(std::vector<kdstream::Touch> touches)
  {
    this->Session.HandleTouches({ this->Now += this->Any(0.005, 0.05), std::move(touches) });
  }
  void Drag();
  void Pinch();
  void Wheel();
  void Answer();

  std::mt19937 Random;
  MemoryServer& Server;
  ViewerSession& Session;
  double Now = 0;
};

void Person::Drag()
{
  double x = this->Any(0, this->Window.width), y = this->Any(0, this->Window.height);
  const double dx = this->Any(-120, 120), dy = this->Any(-120, 120);
  for (int i = 0; i < 6; ++i)
  {
    this->Touch({ { 1, x += dx, y += dy } });
  }
  this->Touch({});
}

void Person::Pinch()
{
  const double x = this->Any(0, this->Window.width), y = this->Any(0, this->Window.height);
  const double dx = this->Any(-90, 90), dy = this->Any(-90, 90), grow = this->Any(0.75, 1.5);
  const double twist = this->Any(-0.3, 0.3);
  double gap = 100;
  for (int i = 0; i < 7; ++i)
  {
    const double a = gap * std::cos(twist * i), b = gap * std::sin(twist * i);
    this->Touch({ { 1, x + dx * i - a, y + dy * i - b }, { 2, x + dx * i + a, y + dy * i + b } });
    gap *= grow;
  }
  this->Touch({});
}

void Person::Wheel()
{
  const double x = this->Any(0, this->Window.width), y = this->Any(0, this->Window.height);
  const double factor = this->Any(0.6, 2.5);
  for (int i = 0; i < 4; ++i)
  {
    this->Session.Zoom(factor, x, y);
  }
}

void Person::Answer()
{
  for (int i = 0; i < 3; ++i)
  {
    (void)this->Server.Answer(this->Session, &this->Random);
  }
  this->Session.Advance(this->Now += 0.1);
  this->Session.BeginFrame();
}

std::string Person::DoSomething()
{
  switch (this->Random() % 16)
  {
    case 0:
      this->turning = this->Random() % 2 == 0 ? Turning::Upright : Turning::Free;
      this->Session.SetTurning(this->turning);
      return "turning";
    case 1:
      this->Window = { 200 + static_cast<int>(this->Random() % 1000),
        200 + static_cast<int>(this->Random() % 1000), 1 };
      this->Session.Resize(this->Window);
      return "resize";
    case 2:
      this->Session.UndoView();
      return "undo";
    case 3:
      this->Session.SetCoasting(this->Random() % 2 == 0);
      return "coast";
    case 4:
    case 5:
    case 6:
      this->Answer();
      return "answers";
    case 7:
    case 8:
    case 9:
      this->Drag();
      return "drag";
    case 10:
    case 11:
    case 12:
      this->Wheel();
      return "wheel";
    default:
      this->Pinch();
      return "pinch";
  }
}

// The first view in a window that has not been changed.
View FirstViewIn(const Viewport& window, MemoryServer server)
{
  ViewerSession session;
  session.Resize(window);
  EXPECT_TRUE(session.SelectModel("torus"));
  while (!session.GetStatus().targetLevel && server.Answer(session))
  {
    // waits until the model is open
  }
  return ViewOf(session);
}

}

TEST(TestSessionCamera, TheFirstViewIsTheModels)
{
  MemoryServer server = SmallTorus();
  const Vec3 middle = FirstViewIn({ 800, 600, 1 }, server).focal;
  for (const HomeView& homeView : { HomeView{}, leaningBack, { { 1, 0, 0 }, { 0, 0, -1 }, true } })
  {
    server.SetHomeView(homeView);
    const View view = FirstViewIn({ 800, 600, 1 }, server);
    EXPECT_LT(Length(Normalized(view.eye - middle) - homeView.view), 1e-12);
    EXPECT_NEAR(Dot(view.orientation.Rotate({ 1, 0, 0 }), homeView.up), 0, 1e-12);
    EXPECT_GT(Dot(view.up, homeView.up), 0.5);
  }
}

TEST(TestSessionCamera, NobodyGetsLost)
{
  std::size_t within = 0, gestures = 0;
  for (unsigned seed = 0; seed < 12; ++seed)
  {
    MemoryServer server = seed % 3 == 2 ? Terrain() : SmallTorus();
    server.SetHomeView(leaningBack);
    SessionOptions options;
    options.detail = seed % 2 == 0 ? DetailMode::View : DetailMode::Level;
    ViewerSession session(options);
    Person person(seed, server, session);
    ASSERT_TRUE(session.SelectModel("torus"));
    server.Serve(session);
    for (int i = 0; i < 250; ++i)
    {
      SCOPED_TRACE("seed " + std::to_string(seed) + ", gesture " + std::to_string(i));
      SCOPED_TRACE(person.DoSomething());
      ++gestures;
      const ViewerScene scene = session.Scene();
      ASSERT_TRUE(scene.surface->TriangleCount() == 0 || ShowsSurface(scene, person.Window));
      if (person.turning == Turning::Upright)
      {
        ASSERT_NEAR(Dot(scene.orientation.Rotate({ 1, 0, 0 }), leaningBack.up), 0, 1e-12);
        ASSERT_GE(Dot(scene.up, leaningBack.up), -1e-12);
      }
      if (seed % 3 != 2 && IsIn(scene.box, scene.eye))
      {
        ++within;
        ASSERT_FALSE(IsInside(scene.surface->Whole(), scene.eye));
      }
    }
  }
  std::printf("%zu gestures, after %zu of them the eye was within the box\n", gestures, within);
  EXPECT_GT(within, gestures / 50) << "the hard case comes";
}

// From everywhere, zooming out at one place leads back to a view of the whole model.
TEST(TestSessionCamera, ZoomingOutLeadsAway)
{
  for (unsigned seed = 0; seed < 40; ++seed)
  {
    SCOPED_TRACE("seed " + std::to_string(seed));
    MemoryServer server = seed % 2 == 0 ? Terrain() : SmallTorus();
    server.SetHomeView(leaningBack);
    ViewerSession session;
    Person person(seed, server, session);
    ASSERT_TRUE(session.SelectModel("torus"));
    server.Serve(session);
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> part(0, 1);
    const double x = person.Window.width * part(random), y = person.Window.height * part(random);
    for (int i = 0; i < 80; ++i)
    {
      session.Zoom(1.2, x, y);
      server.Serve(session);
    }
    for (unsigned i = 0; i < seed % 4; ++i)
    {
      person.DoSomething();
    }
    double before = 0;
    for (int i = 0; i < 160; ++i)
    {
      session.Zoom(1 / 1.2, x, y);
      server.Serve(session);
      before = Length(session.Scene().eye - session.Scene().focal);
    }
    const ViewerScene scene = session.Scene();
    const double size = Length(scene.box.hi - scene.box.lo);
    EXPECT_GT(before, 5 * size);
    EXPECT_TRUE(ShowsSurface(scene, person.Window));
  }
}

TEST(TestSessionCamera, HomeIsTheFirstViewAndUndoTheOneBefore)
{
  MemoryServer server = SmallTorus();
  server.SetHomeView(leaningBack);
  ViewerSession session;
  Person person(99, server, session);
  ASSERT_TRUE(session.SelectModel("torus"));
  server.Serve(session);
  for (int i = 0; i < 150; ++i)
  {
    SCOPED_TRACE(std::to_string(i) + " " + person.DoSomething());
    session.SetCoasting(false);
    const View before = ViewOf(session);
    session.GoHome();
    const View home = ViewOf(session);
    ASSERT_EQ(home, FirstViewIn(person.Window, server));
    session.GoHome(); // changes nothing, so this is not a jump
    if (before != home)
    {
      person.turning = i % 2 == 0 ? Turning::Upright : person.turning;
      session.UndoView();
      ASSERT_EQ(ViewOf(session), before);
    }
  }
}

TEST(TestSessionCamera, ADoubleTapBesideTheModelGoesHome)
{
  Fingers fingers;
  MemoryServer server = SmallTorus();
  ViewerSession session;
  Open(session);
  server.Serve(session);
  const View home = ViewOf(session);
  EXPECT_FALSE(session.GetStatus().canUndo);
  fingers.Pinch(session, 420, 320, 1.3);
  const View near = ViewOf(session);
  EXPECT_NE(near, home);
  fingers.DoubleTap(session, 3, 3);
  EXPECT_EQ(ViewOf(session), home);
  EXPECT_TRUE(session.GetStatus().canUndo);
  session.UndoView();
  EXPECT_EQ(ViewOf(session), near);
  EXPECT_FALSE(session.GetStatus().canUndo);
  session.UndoView();
  EXPECT_EQ(ViewOf(session), near);
  // A double tap on the model does not go home.
  const auto [x, y] = OnModel(session);
  fingers.DoubleTap(session, x, y);
  EXPECT_EQ(ViewOf(session), near);
  session.LeaveFullScreen();
  EXPECT_EQ(ViewOf(session), home);
  session.UndoView();
  EXPECT_EQ(ViewOf(session), near);
  EXPECT_EQ(session.GetStatus().mode, ViewerMode::FullScreen);
}

TEST(TestSessionCamera, AnotherModelHasNoJumpsToTakeBack)
{
  MemoryServer server = SmallTorus();
  ViewerSession session;
  Open(session);
  server.Serve(session);
  session.Zoom(2, 400, 300);
  session.GoHome();
  EXPECT_TRUE(session.GetStatus().canUndo);
  ASSERT_TRUE(session.SelectModel("other"));
  EXPECT_FALSE(session.GetStatus().canUndo);
  session.UndoView();
  session.GoHome();
}

TEST(TestSessionCamera, ATwistRollsOnlyWhereTurningIsFree)
{
  for (const Turning turning : { Turning::Upright, Turning::Free })
  {
    MemoryServer server = SmallTorus();
    ViewerSession session;
    Open(session);
    server.Serve(session);
    session.SetTurning(turning);
    const View before = ViewOf(session);
    double time = 1;
    const auto twist = [&](double most)
    {
      for (double angle = 0; angle < most; angle += 0.05)
      {
        const double a = 100 * std::cos(angle), b = 100 * std::sin(angle);
        session.HandleTouches(
          { time += 0.02, { { 1, 400 - a, 300 - b }, { 2, 400 + a, 300 + b } } });
      }
      session.HandleTouches({ time += 0.02, {} });
    };
    twist(0.15);
    EXPECT_LT(Length(ViewOf(session).up - before.up), 1e-12) << "a little is none";
    twist(1);
    const double turned = Length(ViewOf(session).up - before.up);
    EXPECT_TRUE(turning == Turning::Free ? turned > 0.5 : turned < 1e-12) << turned;
    session.SetTurning(Turning::Upright);
    EXPECT_LT(Length(ViewOf(session).up - before.up), 1e-9);
  }
}

TEST(TestSessionCamera, WhatIsLetGoTurnsOnForAMoment)
{
  const auto afterADrag = [](bool coast, double rest, const std::vector<double>& frames)
  {
    MemoryServer server = SmallTorus();
    SessionOptions options;
    options.coasts = coast;
    ViewerSession session(options);
    Open(session);
    server.Serve(session);
    double time = 10;
    for (int i = 0; i < 10; ++i)
    {
      session.HandleTouches({ time += 0.016, { { 1, 300.0 + 12 * i, 300 } } });
    }
    session.HandleTouches({ time += rest, {} });
    const View letGo = ViewOf(session);
    EXPECT_EQ(session.IsIdle(), !(coast && rest < 0.05));
    for (const double frame : frames)
    {
      session.Advance(time += frame);
    }
    EXPECT_TRUE(session.IsIdle()) << "it comes to rest";
    return std::pair(letGo, ViewOf(session));
  };
  const std::vector<double> smooth(400, 1.0 / 60), rough{ 0.3, 0.1, 5, 1 };
  const auto [letGo, later] = afterADrag(true, 0.016, smooth);
  EXPECT_GT(Length(later.eye - letGo.eye), 0.1 * Length(letGo.eye - letGo.focal));
  const auto atOnce = afterADrag(true, 0.016, rough).second;
  EXPECT_LT(Length(later.eye - atOnce.eye), 1e-9) << "however often frames come";
  for (const auto& [coast, rest] : { std::pair{ false, 0.016 }, { true, 0.2 } })
  {
    const auto [before, after] = afterADrag(coast, rest, smooth);
    EXPECT_EQ(before, after);
  }
}

TEST(TestSessionCamera, TurnsByItselfUntilItIsTouched)
{
  MemoryServer server = SmallTorus();
  ViewerSession session;
  Open(session);
  server.Serve(session);
  const View first = ViewOf(session);
  session.SetSpinning(true);
  EXPECT_TRUE(session.GetStatus().coasting);
  EXPECT_TRUE(session.IsIdle()) << "nobody waits for its end";
  double time = 50;
  for (int i = 0; i <= 24 * 60; ++i)
  {
    session.Advance(time += i == 0 ? 0 : 1.0 / 60);
    if (i == 12 * 60)
    {
      EXPECT_GT(Length(ViewOf(session).eye - first.eye), 1.5 * Length(first.eye - first.focal));
    }
  }
  EXPECT_LT(Length(ViewOf(session).eye - first.eye), 0.01 * Length(first.eye - first.focal));
  const View before = ViewOf(session);
  session.Advance(time += 1e6); // as after the computer was asleep
  EXPECT_LT(Length(ViewOf(session).eye - before.eye), 0.1 * Length(first.eye - first.focal));
  const std::vector<std::function<void()>> stops{ [&] { session.Zoom(1.1, 400, 300); },
    [&] {
      session.HandleTouches({ time += 1, { { 1, 5, 5 } } });
    },
    [&] { session.SetSpinning(false); } };
  for (const auto& stop : stops)
  {
    session.SetSpinning(true);
    session.Advance(time += 1);
    stop();
    EXPECT_FALSE(session.GetStatus().spinning);
    const View stopped = ViewOf(session);
    session.Advance(time += 1);
    EXPECT_EQ(ViewOf(session), stopped);
  }
}

// If frames are slow, a flick is a single step, just before the finger is lifted.
TEST(TestSessionCamera, AFlickWithinAFrameTurnsOn)
{
  for (const bool flick : { true, false })
  {
    MemoryServer server = SmallTorus();
    SessionOptions options;
    options.coasts = true;
    ViewerSession session(options);
    Open(session);
    server.Serve(session);
    session.HandleTouches({ 10, { { 1, 300, 300 } } });
    session.HandleTouches({ 10.01, {} }); // an earlier tap does not count
    session.HandleTouches({ 11, { { 1, 300, 300 } } });
    session.HandleTouches({ flick ? 11.08 : 16.08, { { 1, 420, 300 } } });
    session.HandleTouches({ flick ? 11.081 : 16.081, {} });
    EXPECT_TRUE(session.GetStatus().coasting);
    const View before = ViewOf(session);
    session.Advance(30);
    const double turned = Length(ViewOf(session).eye - before.eye) / Length(before.eye);
    EXPECT_TRUE(flick ? turned > 0.1 : turned < 0.1) << turned << ": as fast as the finger was";
  }
}

TEST(TestSessionCamera, AFingerHoldsWhatTurns)
{
  MemoryServer server = SmallTorus();
  SessionOptions options;
  options.coasts = true;
  ViewerSession session(options);
  Open(session);
  server.Serve(session);
  double time = 1;
  const auto throwIt = [&]
  {
    for (int i = 0; i < 10; ++i)
    {
      session.HandleTouches({ time += 0.016, { { 1, 300.0 + 12 * i, 300 } } });
    }
    session.HandleTouches({ time += 0.016, {} });
    ASSERT_TRUE(session.GetStatus().coasting);
  };
  const std::vector<std::function<void()>> stops{ [&]
    {
      session.HandleTouches({ time += 0.016, { { 1, 5, 5 } } });
    },
    [&] { session.Zoom(1.1, 400, 300); }, [&] { session.GoHome(); }, [&] { session.UndoView(); },
    [&] { session.SetCoasting(false); } };
  for (const auto& stop : stops)
  {
    session.HandleTouches({ time += 1, {} });
    throwIt();
    stop();
    EXPECT_FALSE(session.GetStatus().coasting);
    const View before = ViewOf(session);
    session.Advance(time += 1);
    EXPECT_EQ(ViewOf(session), before);
  }
}
