// SPDX-License-Identifier: BSD-3-Clause
// A session with a section and raking light: how fingers move them, what is fetched, and links.
#include "Testing/Fixtures/ErrorAt.h"
#include "viewer/session/SessionFile.h"
#include "viewer/session/Testing/SessionsByLevel.h"

#include <algorithm>
#include <cmath>
#include <random>

using namespace kdstream;
using namespace kdstream::testing;
using protocol::BlobKind;

namespace
{

std::unique_ptr<ViewerSession> OpenedForSections(MemoryServer& server, SessionOptions options = {})
{
  auto session = std::make_unique<ViewerSession>(options);
  Open(*session);
  server.Serve(*session);
  session->EnterFullScreen();
  server.Serve(*session);
  return session;
}

void Drag(Fingers& fingers, ViewerSession& session, double x, double y, double dx, double dy)
{
  for (int i = 0; i <= 10; ++i)
  {
    session.HandleTouches({ fingers.now += 0.02, { { 1, x + dx * i / 10, y + dy * i / 10 } } });
  }
  session.HandleTouches({ fingers.now += 0.02, {} });
}

void DragTwo(Fingers& fingers, ViewerSession& session, double dx, double dy)
{
  for (int i = 0; i <= 10; ++i)
  {
    session.HandleTouches({ fingers.now += 0.02, { { 1, 300 + dx * i / 10, 300 + dy * i / 10 },
                                                   { 2, 500 + dx * i / 10, 300 + dy * i / 10 } } });
  }
  session.HandleTouches({ fingers.now += 0.02, {} });
}

// What is cut away is not requested, wherever the camera is; without the section it is.
TEST(TestSessionSection, WhatIsCutAwayIsNotFetched)
{
  Fingers fingers;
  for (unsigned seed = 0; seed < 12; ++seed)
  {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> any(0, 1);
    MemoryServer server = SmallTorus();
    const auto session = std::make_unique<ViewerSession>();
    Open(*session);
    server.Serve(*session);
    static constexpr std::array<std::string_view, 5> words{ "x", "y", "z", "view", "side" };
    ASSERT_TRUE(session->SetSectionAlong(words[seed % words.size()]));
    session->SetSectionDepth(0.2 + 0.6 * any(random));
    session->EnterFullScreen();
    SectionPlane plane = *session->GetSection().Plane();
    plane.offset += 0.05; // boxes are rounded outwards
    const auto [x, y] = OnModel(*session);
    for (int i = 0; i < 5; ++i)
    {
      session->Zoom(1.6, x, y);
      server.Serve(*session);
      Drag(fingers, *session, 300, 300, 400 * any(random) - 200, 200 * any(random) - 100);
      server.Serve(*session, &random);
      if (i % 2 == 1)
      {
        fingers.DoubleTap(*session, x, y);
        server.Serve(*session, &random);
      }
    }
    const TreeDepths& depths = server.Codec().depths;
    std::size_t partitions = 0, gone = 0;
    for (const protocol::BlobId& blob : server.sent)
    {
      if (blob.kind == BlobKind::Partition)
      {
        ++partitions;
        const PieceId piece = PieceOfBlob(blob, depths);
        gone += plane.CutsAwayAllOf(server.Tree()[piece.node]) ? 1 : 0;
      }
    }
    EXPECT_EQ(gone, 0u) << "of " << partitions;
    server.sent.clear();
    session->SetSection({});
    server.Serve(*session);
    EXPECT_FALSE(session->Scene().section);
    EXPECT_FALSE(session->Scene().cap);
  }
}

TEST(TestSessionSection, LessIsWanted)
{
  std::size_t sent[2]{};
  for (const bool isCut : { false, true })
  {
    MemoryServer server = SmallTorus();
    ViewerSession session;
    Open(session);
    server.Serve(session);
    if (isCut)
    {
      session.SetSectionAlong("x");
      session.SetSectionDepth(0.8);
    }
    session.EnterFullScreen();
    server.Serve(session);
    sent[isCut ? 1 : 0] = server.sent.size();
  }
  EXPECT_GT(sent[0], 60u);
  EXPECT_LT(sent[1], 0.4 * static_cast<double>(sent[0]));
}

// Of a tapped region, only the partitions that are left are requested and counted.
TEST(TestSessionSection, RegionsEndAtThePlane)
{
  Fingers fingers;
  for (const DetailMode detail : { DetailMode::View, DetailMode::Level })
  {
    MemoryServer server = SmallTorus();
    SessionOptions options;
    options.detail = detail;
    options.rings = 3;
    const auto session = OpenedForSections(server, options);
    const auto [x, y] = OnModel(*session);
    fingers.DoubleTap(*session, x, y);
    server.Serve(*session);
    ASSERT_TRUE(session->GetStatus().region);
    const auto all = session->GetStatus().region->partitions;
    ASSERT_TRUE(session->SetSectionAlong("y"));
    server.Serve(*session);
    ASSERT_TRUE(session->GetStatus().region);
    const auto left = session->GetStatus().region->partitions;
    EXPECT_LT(left, all);
    EXPECT_GT(left, 0u);
    EXPECT_EQ(session->GetStatus().region->shown, left);
  }
}

TEST(TestSessionSection, FingersMoveAndTurnIt)
{
  Fingers fingers;
  MemoryServer server = SmallTorus();
  const auto session = OpenedForSections(server);
  const Camera before = session->GetCamera();
  session->SetTool(Tool::Section);
  Drag(fingers, *session, 300, 300, 100, 0);
  EXPECT_NE(session->GetCamera(), before) << "without a section a finger turns as ever";
  session->GoHome();
  ASSERT_EQ(session->GetCamera(), before);
  ASSERT_TRUE(session->SetSectionAlong("x"));
  ASSERT_EQ(session->GetSection().Plane()->normal, (Vec3{ 1, 0, 0 }));
  const double at = session->GetSection().Plane()->offset;
  Drag(fingers, *session, 400, 300, 100, 0);
  EXPECT_EQ(session->GetCamera(), before);
  // The plane moves by the finger's way on the screen, without the distance before it counted as a
  // drag.
  const double unit = session->GetCamera().PixelsPerUnit();
  EXPECT_NEAR(session->GetSection().Plane()->offset - at, 100 / unit, 11 / unit);
  const double turned = session->GetSection().Plane()->offset;
  DragTwo(fingers, *session, 0, 12);
  DragTwo(fingers, *session, 5, 0);
  EXPECT_EQ(session->GetSection().Plane()->normal, (Vec3{ 1, 0, 0 })) << "snapped";
  DragTwo(fingers, *session, 200, 0);
  EXPECT_LT(session->GetSection().Plane()->normal[0], 0.9);
  EXPECT_NEAR(Length(session->GetSection().Plane()->normal), 1, 1e-12);
  EXPECT_NE(session->GetSection().Plane()->offset, turned);
  // For a plane across the line of sight, dragging down brings the plane nearer.
  ASSERT_TRUE(session->SetSectionAlong("view"));
  const double depth = session->GetSection().Depth();
  Drag(fingers, *session, 400, 200, 0, 60);
  EXPECT_LT(session->GetSection().Depth(), depth);
  session->SetTool(Tool::None);
  Drag(fingers, *session, 400, 200, 60, 0);
  EXPECT_NE(session->GetCamera().Orientation(), before.Orientation());
}

// Whatever the model's home view is. The side of the eye is cut away.
TEST(TestSessionSection, IsCalledByWhereItIsSeenFrom)
{
  for (const HomeView& homeView :
    { HomeView{ { 0, 0, 1 }, { 0, -1, 0 }, true }, { { 1, 0, 0 }, { 0, 0.8, -0.6 }, false } })
  {
    MemoryServer server = SmallTorus();
    server.SetHomeView(homeView);
    ViewerSession session;
    EXPECT_TRUE(session.SetSectionAlong("front")) << "no model is open";
    EXPECT_FALSE(session.GetSection().Plane());
    Open(session);
    server.Serve(session);
    const Vec3 right = Cross(homeView.up, homeView.view);
    for (const auto& [word, direction] :
      { std::pair{ "front", homeView.view }, { "side", right }, { "above", homeView.up } })
    {
      SCOPED_TRACE(word);
      ASSERT_TRUE(session.SetSectionAlong(word));
      const SectionPlane plane = *session.GetSection().Plane();
      EXPECT_NEAR(std::abs(Dot(plane.normal, direction)), 1, 1e-12);
      EXPECT_GE(Dot(plane.normal, session.GetCamera().Forward()), -1 - 1e-12);
      EXPECT_LE(Dot(plane.normal, session.GetCamera().Forward()), 1e-12);
      EXPECT_NEAR(session.GetSection().Depth(), 0.5, 1e-12);
    }
    EXPECT_FALSE(session.SetSectionAlong("top"));
    EXPECT_FALSE(session.SetSectionAlong("right"));
  }
}

TEST(TestSessionSection, TheCapIsWhatIsPicked)
{
  Fingers fingers;
  MemoryServer server = SmallTorus();
  const auto session = OpenedForSections(server);
  ASSERT_TRUE(session->SetSectionAlong("z"));
  session->BeginFrame();
  const ViewerScene scene = session->Scene();
  ASSERT_TRUE(scene.section);
  ASSERT_TRUE(scene.cap);
  EXPECT_GT(scene.cap->triangles.size(), 100u);
  session->SetTool(Tool::Measure);
  const auto [x, y] = OnModel(*session);
  fingers.now += 1;
  fingers.Tap(*session, x, y);
  ASSERT_EQ(session->Measurements().size(), 1u);
  const MeasuredPoint end = session->Measurements().front().from;
  EXPECT_NEAR(scene.section->Above(end.point), 0, 1e-9);
  EXPECT_EQ(end.error, 0);
  EXPECT_FALSE(end.waits) << "a point of the plane is exact";
}

// A distance across a ring of the torus: both ends move to the outline of the original.
TEST(TestSessionSection, MeasuresAlongTheOutline)
{
  Fingers fingers;
  MemoryServer server = SmallTorus();
  const auto session = OpenedForSections(server);
  ASSERT_TRUE(session->SetSectionAlong("z"));
  server.Serve(*session);
  session->SetTool(Tool::Measure);
  const Camera& camera = session->GetCamera();
  const SectionPlane plane = *session->GetSection().Plane();
  const auto tapAt = [&](double radius)
  {
    const auto pixel = camera.PixelOf(plane.NearestTo({ radius, 0, 0 }));
    ASSERT_TRUE(pixel);
    fingers.now += 1;
    fingers.Tap(*session, (*pixel)[0], (*pixel)[1]);
  };
  // Where the outline of the shown surface crosses the x axis.
  std::vector<double> crossings;
  for (const SectionSegment& segment : session->GetSection().Outline())
  {
    if ((segment.from[1] > 0) != (segment.to[1] > 0) && segment.from[0] > 0)
    {
      crossings.push_back(segment.from[0]);
    }
  }
  ASSERT_EQ(crossings.size(), 2u);
  std::sort(crossings.begin(), crossings.end());
  tapAt(crossings[0] + 0.01);
  tapAt(crossings[1] - 0.01);
  server.Serve(*session);
  ASSERT_EQ(session->Measurements().size(), 1u);
  const Measurement& width = session->Measurements().front();
  ASSERT_TRUE(width.to);
  EXPECT_TRUE(width.IsExact());
  EXPECT_NEAR(plane.Above(width.from.point), 0, 1e-9);
  EXPECT_NEAR(plane.Above(width.to->point), 0, 1e-9);
  EXPECT_NEAR(width.Distance(), crossings[1] - crossings[0], 0.02);
  for (const MeasuredPoint* end : { &width.from, &*width.to })
  {
    const auto near = session->GetSection().NearestOnOutline(end->point, 1e-9);
    EXPECT_TRUE(near) << "on the outline";
  }
}

// With a section, too, the user finds the way back.
TEST(TestSessionSection, NobodyGetsLost)
{
  Fingers fingers;
  for (unsigned seed = 0; seed < 30; ++seed)
  {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> any(0, 1);
    MemoryServer server = SmallTorus();
    const auto session = OpenedForSections(server);
    session->SetSectionAlong(seed % 2 == 0 ? "x" : "view");
    for (int i = 0; i < 20; ++i)
    {
      const double x = any(random) * width, y = any(random) * height;
      session->SetTool(any(random) < 0.2 ? Tool::Section : Tool::None);
      any(random) < 0.5
        ? Drag(fingers, *session, x, y, 300 * any(random) - 150, 300 * any(random) - 150)
      : any(random) < 0.7 ? session->Zoom(any(random) < 0.6 ? 1.4 : 0.6, x, y)
                          : DragTwo(fingers, *session, 400 * any(random) - 200, 100);
      server.Serve(*session);
    }
    session->SetTool(Tool::None);
    session->Zoom(0.9, width / 2.0, height / 2.0);
    const SectionPlane plane = *session->GetSection().Plane();
    const auto nearest =
      NearestOnSurface(*session->Scene().surface, session->GetCamera().Focal(), 0, &plane);
    if (nearest)
    {
      EXPECT_LE(nearest->distance, 1.0001 * session->GetCamera().Reach());
    }
  }
}

TEST(TestSessionSection, LightComesFromTheFinger)
{
  Fingers fingers;
  MemoryServer server = SmallTorus();
  const auto session = OpenedForSections(server);
  EXPECT_EQ(session->Scene().lighting, SceneLighting{});
  session->SetTool(Tool::Light);
  const Camera before = session->GetCamera();
  Drag(fingers, *session, 400, 300, -200, 0);
  EXPECT_EQ(session->GetCamera(), before);
  ASSERT_TRUE(session->GetLight());
  EXPECT_NEAR(session->GetLight()->lightSource.x, -200 / (0.45 * height), 1e-9);
  EXPECT_NEAR(session->GetLight()->lightSource.y, 0, 1e-9);
  const Vec3 from = session->Scene().lighting.lights[0].position;
  EXPECT_NEAR(Length(from), 1, 1e-9);
  EXPECT_LT(from[0], -0.7);
  EXPECT_EQ(session->Scene().lighting.lights[1].intensity, 0);
  fingers.DoubleTap(*session, 790, 300); // beyond the rim: clamped to it, and no region
  EXPECT_NEAR(session->GetLight()->lightSource.x, RakingLight::rim, 1e-9);
  EXPECT_GT(session->Scene().lighting.lights[0].position[2], 0.05);
  EXPECT_FALSE(session->GetStatus().region);
  session->SetTool(Tool::SecondLight);
  Drag(fingers, *session, 400, 300, 0, -100);
  ASSERT_TRUE(session->GetLight()->second);
  EXPECT_GT(session->GetLight()->second->y, 0.2);
  EXPECT_GT(session->Scene().lighting.lights[1].intensity, 0);
  fingers.Pinch(*session, 400, 300, 2);
  EXPECT_NE(session->GetCamera(), before) << "two fingers zoom as ever";
  session->SetLight({});
  EXPECT_EQ(session->Scene().lighting, SceneLighting{});
  const double nan = std::numeric_limits<double>::quiet_NaN();
  session->SetLight(RakingLight{ { nan, 1e300, -4 }, LightSource{ 1e300, nan, nan }, 7 });
  for (const SceneLight& lightSource : session->Scene().lighting.lights)
  {
    EXPECT_TRUE(std::isfinite(Length(lightSource.position)));
    EXPECT_GE(lightSource.intensity, 0);
  }
  EXPECT_EQ(session->Scene().lighting.relief, 1);
  ASSERT_TRUE(session->SelectModel("other"));
  EXPECT_FALSE(session->GetLight());
  EXPECT_FALSE(session->GetSection().Plane());
}

TEST(TestSessionSection, ALinkNamesBoth)
{
  Fingers fingers;
  MemoryServer server = SmallTorus();
  const auto mine = OpenedForSections(server);
  ASSERT_TRUE(mine->SetSectionAlong("y"));
  mine->SetSectionDepth(0.3);
  mine->SetTool(Tool::Section);
  DragTwo(fingers, *mine, 130, 50);
  mine->SetTool(Tool::SecondLight);
  Drag(fingers, *mine, 400, 300, 90, 30);
  const std::string text = FormatViewLink(mine->Link());
  EXPECT_LT(text.size(), 150u) << text;
  ViewerSession theirs;
  theirs.Resize({ width, height, 1 });
  ASSERT_TRUE(theirs.Follow(*ParseViewLink(text)));
  server.Serve(theirs);
  server.Serve(*mine);
  ASSERT_TRUE(theirs.GetSection().Plane());
  const SectionPlane &a = *mine->GetSection().Plane(), &b = *theirs.GetSection().Plane();
  EXPECT_LT(Length(a.normal - b.normal), 1e-6);
  EXPECT_NEAR(a.offset, b.offset, 1e-7);
  ASSERT_TRUE(theirs.GetLight() && theirs.GetLight()->second);
  EXPECT_NEAR(mine->GetLight()->second->x, theirs.GetLight()->second->x, 1e-4);
  EXPECT_NEAR(
    mine->GetLight()->lightSource.intensity, theirs.GetLight()->lightSource.intensity, 0.01);
  EXPECT_EQ(FormatViewLink(theirs.Link()), text) << "told on as it came";
  for (const char* wrong : { "section=", "section=AAAA", "section=AAAAAAAAAAAAAAAAAAA",
         "lamps=", "lamps=!", "lamps=AAAA" })
  {
    EXPECT_FALSE(ParseViewLink("model=torus&" + std::string(wrong))) << wrong;
  }
}

TEST(TestSessionSection, FilesNameBoth)
{
  const std::string file = "{\"select\":\"torus\"}\n{\"wait\":\"idle\"}\n{\"section\":\"view\"}\n"
                           "{\"depth\":0.25}\n{\"tool\":\"section\"}\n{\"section\":\"flip\"}\n"
                           "{\"tool\":\"second light\"}\n{\"lamps\":\"" +
                           FormatLights(RakingLight{ { -0.5, 0.25, 1 }, {}, 0.5 }) +
                           "\"}\n{\"tool\":\"light\"}\n{\"lamps\":\"standard\"}\n";
  const auto steps = ParseSession(file);
  ASSERT_TRUE(steps) << steps.GetError().message;
  std::string again;
  MemoryServer server = SmallTorus();
  ViewerSession session;
  session.Resize({ width, height, 1 });
  for (const SessionStep& step : *steps)
  {
    ASSERT_TRUE(Perform(step, session));
    server.Serve(session);
    again += FormatSessionStep(step) + "\n";
    if (step.kind == SessionStep::Kind::Lights && step.name != "standard")
    {
      ASSERT_TRUE(session.GetLight());
      EXPECT_NEAR(session.GetLight()->relief, 0.5, 0.01);
    }
  }
  EXPECT_EQ(again, file);
  EXPECT_EQ(session.GetTool(), Tool::Light);
  EXPECT_FALSE(session.GetLight());
  ASSERT_TRUE(session.GetSection().Plane());
  EXPECT_NEAR(session.GetSection().Depth(), 0.75, 1e-9);
  for (const auto& [wrong, what] :
    std::vector<std::pair<std::string, std::string>>{ { "{\"section\":\"w\"}", "'section'" },
      { "{\"depth\":1.5}", "'depth'" }, { "{\"depth\":\"x\"}", "'depth'" },
      { "{\"depth\":1,\"x\":1}", "'x'" }, { "{\"lamps\":\"A\"}", "'lamps'" } })
  {
    const auto parsed = ParseSession(wrong);
    ASSERT_FALSE(parsed) << wrong;
    EXPECT_TRUE(fixtures::Mentions(parsed.GetError().message, { "line 1: ", what })) << wrong;
  }
}

// The same steps give the same trace.
TEST(TestSessionSection, IsTheSameEveryTime)
{
  std::vector<std::string> traces[2];
  for (auto& trace : traces)
  {
    Fingers fingers;
    MemoryServer server = SmallTorus();
    SessionOptions options;
    options.TraceTo([&trace](std::string_view line) { trace.emplace_back(line); });
    const auto session = OpenedForSections(server, options);
    session->SetSectionAlong("view");
    session->SetTool(Tool::Section);
    Drag(fingers, *session, 200, 200, 90, 40);
    DragTwo(fingers, *session, 70, -30);
    server.Serve(*session);
    session->SetTool(Tool::Light);
    Drag(fingers, *session, 200, 200, 90, 40);
    server.Serve(*session);
  }
  EXPECT_EQ(traces[0], traces[1]);
}

TEST(TestSessionSection, OutlinesAreDrawn)
{
  MemoryServer server = SmallTorus();
  const auto session = OpenedForSections(server);
  EXPECT_EQ(session->SectionOutline(), "");
  session->SetSectionAlong("z");
  server.Serve(*session);
  const std::string svg = session->SectionOutline();
  EXPECT_NE(svg.find("<svg "), std::string::npos);
  EXPECT_EQ(std::count(svg.begin(), svg.end(), 'Z'), 2) << "an inner and an outer line";
  EXPECT_NE(svg.find("<desc>Of a coarser level: about "), std::string::npos);
}

}
