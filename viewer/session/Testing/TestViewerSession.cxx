// SPDX-License-Identifier: BSD-3-Clause
// The session with one level for the whole model, and a server in memory: the drawn surface is
// closed at every moment, for any order of arrivals.
#include "Testing/Fixtures/ErrorAt.h"
#include "viewer/session/SessionFile.h"
#include "viewer/session/SessionParts.h"
#include "viewer/session/Testing/SessionsByLevel.h"

#include "filters/core/tree/Region.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>

using namespace kdstream;
using namespace kdstream::testing;
using protocol::BlobId;
using protocol::BlobKind;

namespace
{

TEST(TestViewerSession, WalksFromBrowsingToAStreamedRegion)
{
  Fingers fingers;
  MemoryServer server = SmallTorus();
  SessionOptions options = ByLevel();
  options.policy.tolerance = 4; // the preview is fine enough for the whole torus
  ViewerSession session(options);
  EXPECT_EQ(session.GetStatus().mode, ViewerMode::NoModel);
  EXPECT_TRUE(session.IsIdle());
  Open(session);
  EXPECT_FALSE(session.IsIdle());
  EXPECT_EQ(session.Parts().fetcher.Wishes().Book().Describe(), "open torus");
  server.Serve(session);
  ASSERT_TRUE(session.IsIdle());
  ViewerStatus status = session.GetStatus();
  EXPECT_EQ(status.mode, ViewerMode::Browsing);
  EXPECT_EQ(status.shownLevel, 11u);
  EXPECT_EQ(status.triangles, server.Description().levels[11].triangles);
  EXPECT_EQ(server.log.size(), 2u); // open, preview

  // A tap leads to full screen; a pinch leads nearer, and to a finer level.
  const auto [x, y] = OnModel(session);
  fingers.Tap(session, x, y);
  EXPECT_EQ(session.GetStatus().mode, ViewerMode::FullScreen);
  server.Serve(session);
  fingers.Pinch(session, x, y, 16);
  EXPECT_EQ(session.GetStatus().targetLevel, 13u);
  EXPECT_EQ(session.GetStatus().shownLevel, 11u); // until all of the other level has arrived
  server.Serve(session);
  status = session.GetStatus();
  EXPECT_EQ(status.shownLevel, 13u);
  EXPECT_EQ(status.triangles, server.Description().levels[13].triangles);

  // A double tap requests the region's partitions, nearest first: the same as those found in the
  // server's tree.
  server.log.clear();
  const auto [px, py] = OnModel(session);
  fingers.DoubleTap(session, px, py);
  TakeTree(session, server);
  server.Take(session);
  EXPECT_GE(server.sent.count(BlobId::TreePage(1)), 1u);
  status = session.GetStatus();
  ASSERT_TRUE(status.region);
  const auto region = *FindRegion(server.Tree(), server.Codec().depths, status.region->cell, 1);
  EXPECT_EQ(status.region->partitions, region.size());
  std::vector<BlobId> expected, asked;
  for (const std::uint32_t partition : region)
  {
    expected.push_back(BlobId::Partition(partition));
  }
  for (session.BeginFrame(); !server.Outstanding().empty(); session.BeginFrame())
  {
    asked.push_back(server.Outstanding().front());
    ASSERT_TRUE(server.Answer(session));
  }
  EXPECT_EQ(asked, expected);
  EXPECT_EQ(session.GetStatus().region->shown, region.size());
  EXPECT_TRUE(session.IsIdle());
  ExpectClosed(session);
  // All vertices of these partitions are drawn.
  std::size_t originals = 0;
  for (const auto& source : session.Scene().surface->Whole().sources)
  {
    originals += source.resolution.IsOriginal() ? 1 : 0;
  }
  EXPECT_EQ(originals, region.size() * 125);

  // A double tap beside the model drops the region and goes home; nothing is requested.
  server.log.clear();
  session.Resize({ width, height, 1 });
  fingers.DoubleTap(session, -1e6, -1e6);
  server.Serve(session);
  EXPECT_FALSE(session.GetStatus().region);
  EXPECT_TRUE(server.log.empty());
  EXPECT_LT(session.GetStatus().triangles, server.Description().levels[13].triangles)
    << "it is home, where less is seen";
}

TEST(TestViewerSession, SelectingTwiceEntersFullScreenAndAnotherModelBrowses)
{
  MemoryServer server = SmallTorus();
  ViewerSession session(ByLevel());
  session.SetModels({ Summarize(server.Description()), { "other", {}, {}, 1, 1 } });
  Open(session);
  EXPECT_TRUE(session.SelectModel("torus"));
  EXPECT_EQ(session.GetStatus().mode, ViewerMode::FullScreen);
  const auto unknown = session.SelectModel("nobody");
  ASSERT_FALSE(unknown);
  EXPECT_NE(unknown.GetError().message.find("'nobody'"), std::string::npos);
  server.Serve(session);
  EXPECT_GT(session.GetStatus().triangles, 0u);
  // The other model cannot be opened: there is a message, nothing is drawn, and the first model can
  // be selected again.
  EXPECT_TRUE(session.SelectModel("other"));
  EXPECT_EQ(session.GetStatus().mode, ViewerMode::Browsing);
  server.Serve(session);
  EXPECT_TRUE(fixtures::Mentions(session.GetStatus().error, { "other", "no such model" }));
  EXPECT_EQ(session.GetStatus().triangles, 0u);
  EXPECT_TRUE(session.IsIdle());
  EXPECT_TRUE(session.SelectModel("torus"));
  server.Serve(session);
  EXPECT_EQ(session.GetStatus().error, "");
  EXPECT_EQ(session.GetStatus().shownLevel, 11u);
}

TEST(TestViewerSession, AWheelZoomsAsAPinchDoesAndBackShowsThePreviewAgain)
{
  Fingers fingers;
  MemoryServer server = SmallTorus();
  SessionOptions options = ByLevel();
  options.policy.tolerance = 4;
  ViewerSession session(options);
  Open(session);
  server.Serve(session);
  const auto [x, y] = OnModel(session);
  const double before = session.Scene().eye[2];
  // Invalid factors change nothing.
  for (const double factor : { 0.0, -2.0, std::nan(""), std::numeric_limits<double>::infinity() })
  {
    session.Zoom(factor, x, y);
  }
  session.Zoom(2, std::nan(""), y);
  EXPECT_EQ(session.Scene().eye[2], before);
  EXPECT_EQ(session.GetStatus().mode, ViewerMode::Browsing);

  // The point under the pointer stays under it.
  session.Zoom(4, x, y);
  session.Zoom(4, x, y);
  EXPECT_EQ(session.GetStatus().mode, ViewerMode::FullScreen);
  const auto [nowX, nowY] = OnModel(session);
  EXPECT_NEAR(nowX, x, 30);
  EXPECT_NEAR(nowY, y, 30);
  EXPECT_EQ(session.GetStatus().targetLevel, 13u);
  server.Serve(session);
  EXPECT_EQ(session.GetStatus().shownLevel, 13u);
  fingers.DoubleTap(session, nowX, nowY);
  server.Serve(session);
  ASSERT_TRUE(session.GetStatus().region);

  session.LeaveFullScreen();
  server.log.clear();
  server.Serve(session);
  const ViewerStatus status = session.GetStatus();
  EXPECT_EQ(status.mode, ViewerMode::Browsing);
  EXPECT_FALSE(status.region);
  EXPECT_EQ(status.shownLevel, 11u);
  EXPECT_EQ(status.triangles, server.Description().levels[11].triangles);
  EXPECT_EQ(session.Scene().eye[2], before);
  EXPECT_TRUE(server.log.empty()); // the preview is still in the cache
}

// The preview would be fine enough for the shape, but not for the colours.
TEST(TestViewerSession, AColoredModelIsShownFiner)
{
  Mesh torus = MakeTorus(200, 80);
  const auto levelOf = [&torus]()
  {
    MemoryServer server(torus, 128, 2);
    SessionOptions options = ByLevel();
    options.policy.tolerance = 3;
    options.policy.hysteresis = 1;
    ViewerSession session(options);
    Open(session);
    server.Serve(session);
    session.EnterFullScreen();
    server.Serve(session);
    EXPECT_EQ(session.Scene().surface->Whole().attributes.size(), torus.attributes.size());
    return *session.GetStatus().shownLevel;
  };
  EXPECT_EQ(levelOf(), 11u);
  kdstream::testing::AddVertexColors(torus);
  EXPECT_GT(levelOf(), 11u);
  torus.attributes.erase(torus.attributes.begin()); // only normals are left
  EXPECT_EQ(levelOf(), 11u);
}

TEST(TestViewerSession, FullScreenBeforeTheModelIsOpenFollowsTheZoomToo)
{
  MemoryServer server = SmallTorus();
  SessionOptions options = ByLevel();
  options.policy.tolerance = 0.5; // the preview is too coarse for the whole torus
  ViewerSession early(options), late(options);
  Open(early);
  early.EnterFullScreen();
  server.Serve(early);
  Open(late);
  server.Serve(late);
  late.EnterFullScreen();
  server.Serve(late);
  EXPECT_GT(late.GetStatus().shownLevel, 11u);
  EXPECT_EQ(early.GetStatus().shownLevel, late.GetStatus().shownLevel);
}

void TurnSlowly(Fingers& fingers, ViewerSession& session)
{
  for (int i = 0; i <= 20; ++i)
  {
    session.HandleTouches({ fingers.now += 0.02, { { 1, 100.0 + 20 * i, 200.0 + 7 * i } } });
  }
  session.HandleTouches({ fingers.now += 0.02, {} });
}

// How much of the way from the middle of the box to its outermost corner is inside the window,
// horizontally and vertically; 1: all of it.
std::array<double, 2> SeenPart(const ViewerSession& session)
{
  const Viewport& window = session.GetCamera().GetViewport();
  const Box box = session.Scene().box;
  std::array<double, 2> out{ 1, 1 };
  for (unsigned corner = 0; corner < 8; ++corner)
  {
    Vec3 v;
    for (unsigned k = 0; k < 3; ++k)
    {
      v[k] = (corner >> k & 1 ? box.hi : box.lo)[k];
    }
    const auto pixel = session.GetCamera().PixelOf(v);
    EXPECT_TRUE(pixel);
    out[0] = std::max(out[0], std::abs(2 * (*pixel)[0] / window.width - 1));
    out[1] = std::max(out[1], std::abs(2 * (*pixel)[1] / window.height - 1));
  }
  return { 1 / out[0], 1 / out[1] };
}

constexpr Viewport portrait{ height / 2, width, 1 }, landscape{ width, height, 1 };

// A window's size changes for a moment when a picture is saved, or when a browser's bars come and
// go.
TEST(TestViewerSession, TheSameWindowShowsTheSameView)
{
  Fingers fingers;
  MemoryServer server = SmallTorus();
  ViewerSession session(ByLevel());
  Open(session);
  server.Serve(session);
  const auto expectTheSame = [&session](const char* what)
  {
    SCOPED_TRACE(what);
    const Camera before = session.GetCamera();
    session.Resize(landscape);
    EXPECT_TRUE(session.GetCamera() == before);
    session.Resize({ width, height - 40, 1 });
    session.Resize({ height, height, 2 });
    session.Resize(portrait);
    session.Resize(landscape);
    EXPECT_TRUE(session.GetCamera() == before);
  };
  expectTheSame("first view");
  TurnSlowly(fingers, session);
  expectTheSame("turned");
  session.SetSpinning(true);
  session.Advance(1000);
  session.Advance(1000.05);
  session.SetSpinning(false);
  expectTheSame("turned by itself");
  ASSERT_TRUE(session.LookFromSide("top"));
  expectTheSame("from above");
  TurnSlowly(fingers, session);
  expectTheSame("turned from above");
  fingers.Pinch(session, 420, 310, 4);
  expectTheSame("pinched");
  session.Zoom(0.7, 200, 100);
  expectTheSame("wheel");
  for (int i = 0; i < 10; ++i)
  {
    session.HandleTouches(
      { fingers.now += 0.02, { { 1, 300.0 + 9 * i, 200.0 }, { 2, 400.0 + 9 * i, 200.0 } } });
  }
  session.HandleTouches({ fingers.now += 0.02, {} });
  expectTheSame("panned");
  session.SetTurning(Turning::Free);
  TurnSlowly(fingers, session);
  expectTheSame("turned freely");
  const ViewLink link = session.Link();
  session.GoHome();
  expectTheSame("home again");
  ASSERT_TRUE(session.Follow(link));
  expectTheSame("a link");
  session.UndoView();
  expectTheSame("undone");
}

// A turned preview opens in full screen from the same side, and as large.
TEST(TestViewerSession, AnotherWindowShowsWhatWasSeenOfATurnedModel)
{
  Fingers fingers;
  MemoryServer server = SmallTorus();
  for (const bool isPortrait : { false, true })
  {
    ViewerSession session(ByLevel());
    session.Resize(isPortrait ? portrait : landscape);
    ASSERT_TRUE(session.SelectModel("torus"));
    server.Serve(session);
    TurnSlowly(fingers, session);
    const Quaternion turned = session.Scene().orientation;
    ASSERT_NE(turned, Quaternion{});
    const auto [across, up] = SeenPart(session);
    session.Resize(isPortrait ? landscape : portrait);
    EXPECT_EQ(session.Scene().orientation, turned);
    const auto [newAcross, newUp] = SeenPart(session);
    EXPECT_GE(newAcross, across - 1e-9);
    EXPECT_GE(newUp, up - 1e-9);
    session.Zoom(2, 10, 10);
    const Vec3 eye = session.Scene().eye;
    session.Resize(landscape);
    EXPECT_EQ(session.Scene().eye, eye);
  }
}

// A first view or a side fits every window, by whatever jumps the user comes back to it.
TEST(TestViewerSession, WhatNobodyHasTouchedFitsAnotherWindow)
{
  Fingers fingers;
  MemoryServer server = SmallTorus();
  ViewerSession session(ByLevel()), upright(ByLevel());
  Open(session);
  upright.Resize(portrait);
  ASSERT_TRUE(upright.SelectModel("torus"));
  server.Serve(session);
  server.Serve(upright);
  const auto expectAlike = [&](const char* what)
  {
    SCOPED_TRACE(what);
    session.Resize(portrait);
    EXPECT_EQ(session.Scene().eye, upright.Scene().eye);
    EXPECT_EQ(session.Scene().orientation, upright.Scene().orientation);
    session.Resize(landscape);
  };
  expectAlike("first view");
  TurnSlowly(fingers, session);
  session.GoHome();
  expectAlike("home");
  fingers.Pinch(session, 420, 310, 4);
  session.Resize(portrait);
  session.GoHome();
  session.Resize(landscape);
  expectAlike("home in another window");
  ASSERT_TRUE(session.LookFromSide("left") && upright.LookFromSide("left"));
  expectAlike("a side");
  session.Zoom(3, 400, 300);
  session.GoHome();
  upright.GoHome();
  session.Resize(portrait);
  session.LookFromSide("top");
  session.UndoView();
  session.Resize(landscape);
  expectAlike("undone to home");
}

TEST(TestViewerSession, CancelledTouchesAreNotATap)
{
  Fingers fingers;
  MemoryServer server = SmallTorus();
  ViewerSession session(ByLevel());
  Open(session);
  server.Serve(session);
  const auto [x, y] = OnModel(session);
  session.HandleTouches({ fingers.now += 1, { { 1, x, y } } });
  session.CancelTouches();
  session.HandleTouches({ fingers.now += 0.1, {} });
  EXPECT_EQ(session.GetStatus().mode, ViewerMode::Browsing);
}

// Random fingers, random order of blobs, refusals and damage: the surface is closed at every frame,
// and the session is idle at the end.
class TestRandomSessions : public ::testing::TestWithParam<bool>
{
};

TEST_P(TestRandomSessions, DrawAClosedSurfaceAtEveryMoment)
{
  Fingers fingers;
  const bool faults = GetParam();
  for (unsigned seed = 0; seed < 8; ++seed)
  {
    std::mt19937 random(seed);
    MemoryServer server = seed % 2 == 0 ? SmallTorus() : SmallCells();
    std::set<BlobId> damaged;
    SessionOptions options = ByLevel();
    options.cacheBytes = seed % 3 == 0 ? 1 : 1u << 26; // 1: keeps nothing but what is shown
    options.policy.tolerance = 1;
    ViewerSession session(options);
    Open(session);
    server.Serve(session, &random);
    for (int step = 0; step < 25; ++step)
    {
      if (faults && random() % 4 == 0)
      {
        const BlobId blob =
          BlobId::Partition(static_cast<std::uint32_t>(random() % server.Description().partitions));
        server.refused.insert(blob);
      }
      const auto [x, y] = OnModel(session);
      const double dx = static_cast<double>(random() % 100) - 50;
      switch (random() % 5)
      {
        case 0:
          fingers.Pinch(session, x, y, 2.5);
          break;
        case 1:
          fingers.Pinch(session, x, y, 0.4);
          break;
        case 2:
          session.SetRings(static_cast<unsigned>(1 + random() % 3));
          fingers.DoubleTap(session, x + dx, y);
          break;
        case 3:
          fingers.DoubleTap(session, x, y + dx);
          break;
        default:
          session.HandleTouches({ fingers.now += 1, { { 1, x, y } } });
          session.HandleTouches({ fingers.now += 0.1, { { 1, x + dx, y } } });
          session.HandleTouches({ fingers.now += 0.1, {} });
          break;
      }
      // A random number of answers arrives before the next gesture, sometimes all.
      auto answers = random() % 40;
      while (answers-- > 0 && server.Answer(session, &random))
      {
        if (random() % 3 != 0) // sometimes several answers arrive before a frame
        {
          session.BeginFrame();
        }
        ExpectClosed(session);
        ASSERT_GT(session.GetStatus().triangles, 0u);
      }
    }
    server.Serve(session, &random, [&] { ExpectClosed(session); });
    EXPECT_TRUE(session.IsIdle()) << session.Parts().fetcher.Wishes().Book().Describe();
    const ViewerStatus status = session.GetStatus();
    if (!faults)
    {
      EXPECT_EQ(status.error, "");
      EXPECT_EQ(status.shownLevel, status.targetLevel);
      EXPECT_TRUE(!status.region || status.region->shown == status.region->partitions);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(WithAndWithoutFaults, TestRandomSessions, ::testing::Bool());

TEST(TestViewerSession, TheOrderOfArrivalDoesNotMatterInTheEnd)
{
  Fingers fingers;
  std::optional<Surface> first;
  for (unsigned seed = 0; seed < 4; ++seed)
  {
    std::mt19937 random(seed);
    MemoryServer server = SmallCells();
    ViewerSession session(ByLevel());
    Open(session);
    server.Serve(session, &random);
    const auto [x, y] = OnModel(session);
    fingers.DoubleTap(session, x, y);
    server.Serve(session, &random);
    const Surface& surface = session.Scene().surface->Whole();
    EXPECT_TRUE(session.GetStatus().region);
    if (!first)
    {
      first = surface;
    }
    EXPECT_EQ(surface.points, first->points);
    EXPECT_EQ(surface.triangles, first->triangles);
  }
}

TEST(TestViewerSession, AFasterZoomCancelsTheLevelInBetween)
{
  Fingers fingers;
  MemoryServer server = SmallTorus();
  SessionOptions options = ByLevel();
  options.policy.tolerance = 4; // the preview is fine enough for the whole torus
  ViewerSession session(options);
  OpenFullScreen(session, server);
  server.log.clear();
  const auto [x, y] = OnModel(session);
  fingers.Pinch(session, x, y, 16);
  server.Take(session);
  const std::uint64_t answered = server.sent.size();
  fingers.Pinch(session, x, y, 0.05); // back before anything has arrived
  session.FollowView();
  server.Take(session);
  EXPECT_EQ(session.GetStatus().targetLevel, 11u);
  EXPECT_NE(server.log.back().find("cancel"), std::string::npos);
  server.Serve(session);
  EXPECT_EQ(server.sent.size(), answered);
  EXPECT_TRUE(session.IsIdle());
  EXPECT_EQ(session.GetStatus().shownLevel, 11u);
}

TEST(TestViewerSession, KeepsEveryBlobsTimes)
{
  Fingers fingers;
  MemoryServer server = SmallTorus();
  double seconds = 0;
  SessionOptions options = ByLevel();
  options.clock = [&seconds] { return seconds += 0.125; };
  ViewerSession session(options);
  Open(session);
  server.Serve(session);
  ASSERT_EQ(session.Statistics().size(), 1u);
  const BlobStatistics& preview = session.Statistics()[0];
  EXPECT_EQ(preview.what, "preview");
  EXPECT_EQ(preview.id, "levels/11/1");
  EXPECT_EQ(preview.vertices, server.Description().levels[11].vertices);
  EXPECT_EQ(preview.triangles, server.Description().levels[11].triangles);
  EXPECT_EQ(preview.bytes, server.Blob(BlobId::LevelPiece(11, 1)).size());
  EXPECT_EQ(preview.transmissionSeconds, 0.25);
  EXPECT_EQ(preview.parsingSeconds, 0.125);
  EXPECT_EQ(preview.renderingSeconds, 0.5);
  const auto [x, y] = OnModel(session);
  fingers.DoubleTap(session, x, y);
  while (server.Answer(session))
  {
  }
  session.BeginFrame(); // all partitions appear in one frame, and share its time
  session.EndFrame(3);
  double sum = 0;
  for (const BlobStatistics& blob : session.Statistics())
  {
    sum += blob.what == "preview" ? 0 : blob.renderingSeconds;
  }
  EXPECT_NEAR(sum, 3, 1e-9);
  const std::string json = StatisticsJson(session.Statistics());
  EXPECT_EQ(json.rfind("[\n {\"what\":\"preview\",\"id\":\"levels/11/1\",\"vertices\":", 0), 0u);
  EXPECT_NE(
    json.find(
      "\"transmission_s\":0.25,\"parsing_s\":0.125,\"rendering_s\":0.5,\"from_cache\":false}"),
    std::string::npos);
  EXPECT_EQ(StatisticsJson({}), "[\n]\n");
}

TEST(TestViewerSession, KeepsTheTimesOfTheNewestBlobsOnly)
{
  Fingers fingers;
  MemoryServer server = SmallTorus();
  SessionOptions options = ByLevel();
  options.mostStatistics = 3;
  ViewerSession session(options);
  Open(session);
  server.Serve(session);
  const auto [x, y] = OnModel(session);
  fingers.Pinch(session, x, y, 6);
  server.Serve(session);
  ASSERT_GT(server.sent.size(), 5u); // a page of the tree among them
  ASSERT_EQ(session.Statistics().size(), 3u);
  for (const BlobStatistics& blob : session.Statistics())
  {
    EXPECT_EQ(blob.id.rfind("levels/13/", 0), 0u) << blob.id;
    EXPECT_GT(blob.renderingSeconds, 0) << blob.id;
  }
}

// This matters: with a region in a level coarser than S, a choice visits every vertex of the level
// to find which clusters are split.
TEST(TestViewerSession, MovingTheCameraDoesNotChooseAnew)
{
  Fingers fingers;
  MemoryServer server = SmallCells();
  SessionOptions options = ByLevel();
  options.policy.tolerance = 4;
  ViewerSession session(options);
  OpenFullScreen(session, server);
  const auto [x, y] = OnModel(session);
  fingers.DoubleTap(session, x, y);
  server.Serve(session);
  ASSERT_TRUE(session.GetStatus().region);
  ASSERT_EQ(session.GetStatus().region->shown, session.GetStatus().region->partitions);
  ASSERT_LT(session.GetStatus().shownLevel, server.Codec().depths.stitch);
  session.HandleTouches({ fingers.now += 1, {} });
  const std::uint64_t choices = session.Parts().lod.Choices();
  const Vec3 eye = session.Scene().eye;
  for (int i = 0; i <= 50; ++i)
  {
    session.HandleTouches({ fingers.now += 0.02, { { 1, x + 3 * i, y } } });
  }
  session.HandleTouches({ fingers.now += 0.02, {} });
  fingers.Pinch(session, x, y, 1.01);
  session.Resize({ width + 10, height, 1 });
  EXPECT_NE(session.Scene().eye, eye);
  EXPECT_EQ(session.Parts().lod.Choices(), choices);
  // Inputs that change something lead to a new choice.
  fingers.Pinch(session, x, y, 16);
  server.Serve(session);
  EXPECT_GT(session.Parts().lod.Choices(), choices);
  EXPECT_EQ(session.GetStatus().shownLevel, 13u);
}

TEST(TestViewerSession, EveryInputIsTracedBeforeAModelIsOpen)
{
  std::vector<std::string> trace;
  ViewerSession session(WithTrace(trace));
  session.LookFrom({ 0, 0, 3 }, { 0, 0, 0 }, { 0, 1, 0 }, 0.3);
  ASSERT_EQ(trace.size(), 1u);
  EXPECT_NE(trace[0].find("\"input\":\"camera\""), std::string::npos);
}

TEST(TestViewerSession, AnotherOneTakesItsPlace)
{
  MemoryServer server = SmallTorus(), other = SmallTorus();
  ViewerSession session(ByLevel());
  OpenFullScreen(session, server);
  session = ViewerSession(ByLevel());
  EXPECT_EQ(session.GetStatus().mode, ViewerMode::NoModel);
  OpenFullScreen(session, other);
  EXPECT_GT(session.GetStatus().triangles, 0u);
}

// A session's parts refer to each other.
TEST(TestViewerSession, PartsAreNeverCopied)
{
  EXPECT_FALSE(std::is_copy_constructible_v<SessionParts>);
  EXPECT_FALSE(std::is_copy_constructible_v<CameraControl>);
  EXPECT_FALSE(std::is_copy_constructible_v<Fetcher>);
  EXPECT_FALSE(std::is_copy_constructible_v<LodSelection>);
  EXPECT_FALSE(std::is_copy_constructible_v<MeasureTool>);
  EXPECT_FALSE(std::is_copy_constructible_v<PickedRegion>);
  EXPECT_FALSE(std::is_copy_constructible_v<Tools>);
}

// A recorded session, played twice: the same requests and the same trace, line for line.
TEST(TestViewerSession, TheSameReplayGivesTheSameTraceTwice)
{
  const std::string recorded =
    "{\"select\":\"torus\"}\n{\"wait\":\"idle\"}\n"
    "{\"t\":0,\"touches\":[{\"id\":1,\"x\":300,\"y\":300}]}\n"
    "{\"t\":0.1,\"touches\":[{\"id\":1,\"x\":360,\"y\":310}]}\n"
    "{\"t\":0.2,\"touches\":[{\"id\":1,\"x\":550,\"y\":300},{\"id\":2,\"x\":650,\"y\":300}]}\n"
    "{\"t\":0.3,\"touches\":[{\"id\":1,\"x\":450,\"y\":300},{\"id\":2,\"x\":750,\"y\":300}]}\n"
    "{\"t\":0.4,\"touches\":[]}\n{\"wait\":\"idle\"}\n"
    "{\"t\":1.0,\"touches\":[{\"id\":1,\"x\":600,\"y\":300}]}\n{\"t\":1.05,\"touches\":[]}\n"
    "{\"t\":1.2,\"touches\":[{\"id\":1,\"x\":601,\"y\":300}]}\n{\"t\":1.25,\"touches\":[]}\n"
    "{\"wait\":\"idle\"}\n";
  const auto steps = ParseSession(recorded);
  ASSERT_TRUE(steps);
  std::vector<std::string> traces[2], logs[2];
  for (std::size_t run = 0; run < 2; ++run)
  {
    MemoryServer server = SmallCells();
    ViewerSession session(WithTrace(traces[run]));
    session.Resize({ width, height, 1 });
    for (const SessionStep& step : *steps)
    {
      if (step.kind == SessionStep::Kind::Select)
      {
        ASSERT_TRUE(session.SelectModel(step.name));
      }
      else if (step.kind == SessionStep::Kind::Touches)
      {
        session.HandleTouches(step.frame);
      }
      else
      {
        server.Serve(session);
      }
      server.Take(session);
    }
    logs[run] = server.log;
    EXPECT_TRUE(session.GetStatus().region);
  }
  EXPECT_EQ(logs[0], logs[1]);
  EXPECT_EQ(traces[0], traces[1]);
  EXPECT_GT(traces[0].size(), 20u);
}

}
