// SPDX-License-Identifier: BSD-3-Clause
// Links to views: another user sees the same view; and a link may contain any text.
#include "Testing/Fixtures/ErrorAt.h"
#include "viewer/session/ViewLink.h"

#include "viewer/session/Testing/SessionsByLevel.h"

#include <cmath>
#include <random>

using namespace kdstream;
using namespace kdstream::testing;

namespace
{

constexpr double pixel = 2 * Camera::tangentOfHalfAngle / height; // tangent of a pixel's angle

// How far apart, in pixels, two cameras show the point about which they turn, and points beside it.
double PixelsApart(const ViewerScene& a, const ViewerScene& b)
{
  double most = 0;
  const double distance = Length(a.eye - a.focal);
  for (const Vec3& beside : { Vec3{}, Vec3{ 0.3, 0, 0 }, Vec3{ 0, 0.3, 0 }, Vec3{ 0, 0, 0.3 } })
  {
    const Vec3 point = a.focal + a.orientation.Rotate(beside * distance);
    const auto seen = [&point](const ViewerScene& scene)
    {
      const Vec3 sight = scene.orientation.Inverse().Rotate(point - scene.eye);
      return Vec3{ sight[0] / -sight[2], sight[1] / -sight[2], 0 };
    };
    most = std::max(most, Length(seen(a) - seen(b)) / pixel);
  }
  return most;
}

// The session of a user who has looked around, after the server has answered everything.
std::unique_ptr<ViewerSession> SomeView(Fingers& fingers, unsigned seed, MemoryServer& server)
{
  auto session = std::make_unique<ViewerSession>();
  Open(*session);
  server.Serve(*session);
  session->EnterFullScreen();
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> any(0, 1);
  session->SetTurning(seed % 3 == 0 ? Turning::Free : Turning::Upright);
  for (int i = 0; i < 4; ++i)
  {
    fingers.Pinch(*session, any(random) * width, any(random) * height, 0.7 + 3 * any(random));
    session->HandleTouches({ fingers.now += 1, { { 1, 300, 300 } } });
    session->HandleTouches(
      { fingers.now += 0.1, { { 1, 300 + 200 * any(random), 300 + 90 * any(random) } } });
    session->HandleTouches({ fingers.now += 0.1, {} });
    server.Serve(*session);
  }
  return session;
}

TEST(TestViewLink, ShowsTheSameElsewhere)
{
  Fingers fingers;
  for (unsigned seed = 0; seed < 30; ++seed)
  {
    MemoryServer server = SmallTorus();
    const auto mine = SomeView(fingers, seed, server);
    const std::string text = FormatViewLink(mine->Link());
    EXPECT_LT(text.size(), 110u) << text;
    const auto link = ParseViewLink(text);
    ASSERT_TRUE(link) << link.GetError().message;
    ViewerSession theirs;
    theirs.Resize({ width, height, 1 });
    ASSERT_TRUE(theirs.Follow(*link));
    server.Serve(theirs);
    EXPECT_LT(PixelsApart(mine->Scene(), theirs.Scene()), 0.05) << text;
    EXPECT_EQ(theirs.GetStatus().mode, ViewerMode::FullScreen);
    EXPECT_EQ(theirs.GetStatus().error, "");
  }
}

TEST(TestViewLink, ARegionIsTheOriginalThere)
{
  Fingers fingers;
  MemoryServer server = SmallTorus();
  ViewerSession mine;
  Open(mine);
  server.Serve(mine);
  mine.SetRings(2);
  const auto [x, y] = OnModel(mine);
  fingers.DoubleTap(mine, x, y);
  server.Serve(mine);
  ASSERT_TRUE(mine.GetStatus().region);
  ViewerSession theirs;
  theirs.Resize({ width, height, 1 });
  ASSERT_TRUE(theirs.Follow(*ParseViewLink(FormatViewLink(mine.Link()))));
  server.Serve(theirs);
  ASSERT_TRUE(theirs.GetStatus().region);
  EXPECT_EQ(theirs.GetStatus().region->cell, mine.GetStatus().region->cell);
  EXPECT_EQ(theirs.GetStatus().region->shown, mine.GetStatus().region->shown);
  EXPECT_EQ(theirs.GetStatus().region->rings, 2u);
}

// All of the square in the middle of the window stays visible.
TEST(TestViewLink, AnotherWindowShowsTheMiddle)
{
  Fingers fingers;
  MemoryServer server = SmallTorus();
  const auto mine = SomeView(fingers, 7, server);
  const ViewerScene here = mine->Scene();
  for (const Viewport& window : { Viewport{ 400, 900, 2 }, Viewport{ 1600, 500, 1 } })
  {
    ViewerSession theirs;
    theirs.Resize(window);
    ASSERT_TRUE(theirs.Follow(mine->Link()));
    server.Serve(theirs);
    const ViewerScene there = theirs.Scene();
    const double half = Camera::tangentOfHalfAngle * Length(here.eye - here.focal);
    const double shown = Camera::tangentOfHalfAngle * Length(there.eye - there.focal) *
                         std::min(1.0, double(window.width) / window.height);
    EXPECT_GE(shown, half * (1 - 1e-6)) << window.width;
    EXPECT_LT(shown, half * 1.01) << window.width;
  }
}

// As on a phone while the page starts, when the browser's bars come and go.
TEST(TestViewLink, AWindowThatChangesItsShapeShowsTheSame)
{
  MemoryServer server = SmallTorus();
  ViewerSession mine, theirs, slow;
  for (ViewerSession* each : { &mine, &theirs, &slow })
  {
    Open(*each);
  }
  mine.Resize({ 412, 703, 1 });
  theirs.Resize({ 412, 743, 1 });
  slow.Resize({ 412, 703, 1 });
  server.Serve(mine);
  mine.Zoom(3, 200, 300);
  for (ViewerSession* each : { &theirs, &slow })
  {
    ASSERT_TRUE(each->Follow(mine.Link()));
    server.Serve(*each);
  }
  const Camera before = slow.GetCamera();
  EXPECT_FALSE(before == theirs.GetCamera());
  slow.Resize({ 412, 743, 1 });
  EXPECT_TRUE(slow.GetCamera() == theirs.GetCamera());
  slow.Resize({ 412, 743, 2 });
  slow.Resize({ 412, 703, 1 });
  EXPECT_TRUE(slow.GetCamera() == before);
  slow.Zoom(1.1, 200, 300); // from here on, the view is the user's own
  const double distance = slow.GetCamera().Distance();
  slow.Resize({ 412, 743, 1 });
  EXPECT_EQ(slow.GetCamera().Distance(), distance);
}

TEST(TestViewLink, AnotherVersionOfTheModelIsReported)
{
  Fingers fingers;
  MemoryServer server = SmallTorus();
  ViewLink link = SomeView(fingers, 1, server)->Link();
  link.digest = "0123abcd";
  ViewerSession theirs;
  Open(theirs);
  server.Serve(theirs);
  const ViewerScene before = theirs.Scene();
  ASSERT_TRUE(theirs.Follow(link)); // the model is open already
  EXPECT_TRUE(fixtures::Mentions(theirs.GetStatus().error, { "another version of torus" }));
  EXPECT_GT(PixelsApart(before, theirs.Scene()), 10);
  theirs.UndoView();
  EXPECT_LT(PixelsApart(before, theirs.Scene()), 1e-9) << "it was a jump";
  theirs.SetModels({ Summarize(server.Description()) });
  link.model = "gone";
  EXPECT_TRUE(fixtures::FailsAt(theirs.Follow(link), ErrorCode::NotFound, "'gone'"));
}

// Any text, made from correct and wrong links, gives an error or a link, and never a useless
// camera.
TEST(TestViewLink, TakesAnyText)
{
  Fingers fingers;
  MemoryServer server = SmallTorus();
  const std::string good =
    FormatViewLink(SomeView(fingers, 3, server)->Link()) +
    "&region=131.2&colours=partition&light=plain&detail=level&distances=" + std::string(80, 'f');
  ViewerSession theirs;
  Open(theirs);
  server.Serve(theirs);
  std::mt19937 random(5);
  std::size_t taken = 0;
  for (int i = 0; i < 4000; ++i)
  {
    std::string text = good;
    for (unsigned k = 0; k < 1 + i % 4u; ++k)
    {
      const std::size_t at = random() % text.size();
      random() % 3 == 0   ? void(text.erase(at, 1 + random() % 9))
      : random() % 2 == 0 ? void(text.insert(at, 1, static_cast<char>(random())))
                          : void(text[at] = static_cast<char>(random()));
      text += text.empty() ? "x" : "";
    }
    const auto link = ParseViewLink(text);
    if (!link)
    {
      EXPECT_NE(link.GetError().message.find("link"), std::string::npos);
      continue;
    }
    ++taken;
    (void)theirs.Follow(*link);
    const ViewerScene scene = theirs.Scene();
    const double away = Length(scene.eye - scene.focal);
    ASSERT_TRUE(std::isfinite(away) && away > 0) << text;
    ASSERT_TRUE(theirs.GetStatus().vertices == 0 ||
                NearestOnSurface(*scene.surface, scene.focal).has_value());
  }
  EXPECT_GT(taken, 100u);
  EXPECT_FALSE(ParseViewLink("view=AAAA"));
  EXPECT_FALSE(ParseViewLink(""));
  EXPECT_FALSE(ParseViewLink("model=a&distances=" + std::string(41, 'A')));
  EXPECT_FALSE(ParseViewLink("model=a&distances=" + std::string(17 * 40, 'A')));
  EXPECT_EQ(
    ParseViewLink("model=a&distances=" + std::string(16 * 40, 'A'))->measurements.size(), 16u);
  EXPECT_FALSE(ParseViewLink("model=../etc"));
  EXPECT_TRUE(ParseViewLink("model=a&later=1&&x"));
  EXPECT_TRUE(
    fixtures::FailsAt(ParseViewLink("model=a&region=0.1"), ErrorCode::InvalidInput, "region"));
  EXPECT_TRUE(fixtures::FailsAt(
    ParseViewLink(std::string(ViewLink::longest + 1, 'a')), ErrorCode::InvalidInput, "too long"));
}

TEST(TestViewLink, SidesAreLevelAndOpposite)
{
  for (const HomeView& homeView : { HomeView{}, HomeView{ { 0, 0, 1 }, { 0, -0.8, 0.6 }, false },
         HomeView{ { 0, 0, 1 }, { 0, 0, 1 }, false } })
  {
    MemoryServer server = SmallTorus();
    server.SetHomeView(homeView);
    ViewerSession session;
    Open(session);
    server.Serve(session);
    const auto look = [&](const char* side)
    {
      EXPECT_TRUE(session.LookFromSide(side));
      const ViewerScene scene = session.Scene();
      return std::pair(Normalized(scene.eye - scene.focal), scene.up);
    };
    const auto [front, up] = look("front");
    EXPECT_LT(Length(up - homeView.up), 1e-9);
    EXPECT_NEAR(Dot(front, homeView.up), 0, 1e-9);
    if (std::abs(Dot(homeView.view, homeView.up)) < 0.9)
    {
      EXPECT_GT(Dot(front, homeView.view), 0.5);
    }
    EXPECT_LT(Length(look("back").first + front), 1e-9);
    EXPECT_LT(Length(look("right").first - Cross(homeView.up, front)), 1e-9);
    EXPECT_LT(Length(look("left").first + Cross(homeView.up, front)), 1e-9);
    const auto [above, away] = look("top");
    EXPECT_LT(Length(above - homeView.up), 1e-9);
    EXPECT_LT(Length(away + front), 1e-9) << "the front is below";
    EXPECT_LT(Length(look("bottom").first + homeView.up), 1e-9);
    const ViewerScene bottom = session.Scene();
    EXPECT_FALSE(session.LookFromSide("inside"));
    EXPECT_EQ(session.Scene().eye, bottom.eye);
    session.UndoView();
    EXPECT_LT(Length(Normalized(session.Scene().eye - session.Scene().focal) - homeView.up), 1e-9);
  }
}

}
