// SPDX-License-Identifier: BSD-3-Clause
// The session in view mode, with a server in memory: visible parts are fine, the drawn surface is
// closed at every moment, and the session comes to rest. TestViewFetching tests what it fetches.
#include "viewer/session/SessionParts.h"
#include "viewer/session/Testing/SessionsByView.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

using namespace kdstream;
using namespace kdstream::testing;
using protocol::BlobId;
using protocol::BlobKind;

namespace
{

TEST(TestViewDetail, WhatIsSeenIsFineAndTheRestCostsNothing)
{
  MemoryServer server = Torus();
  ViewerSession session;
  OpenFullScreen(session, server);
  ASSERT_TRUE(session.IsIdle());
  const ViewerStatus whole = session.GetStatus();
  EXPECT_GT(whole.shownLevel, 11u);
  EXPECT_EQ(whole.shownLevel, whole.targetLevel);
  session.Zoom(40, onRingX, onRingY);
  server.Serve(session);
  const ViewerStatus near = session.GetStatus();
  EXPECT_TRUE(session.IsIdle());
  EXPECT_EQ(near.error, "");
  EXPECT_EQ(near.shownLevel, server.Codec().depths.finest);
  EXPECT_GT(VerticesOfOriginal(session), 100u) << "the finest is the original";
  EXPECT_LT(near.triangles, whole.triangles / 2) << "what is not on the screen is coarse";
  std::size_t partitions = 0, sent = 0;
  for (const BlobId& blob : server.sent)
  {
    partitions += blob.kind == BlobKind::Partition ? 1 : 0;
    sent += server.sent.count(blob) == 1 ? 0 : 1;
  }
  EXPECT_EQ(sent, 0u) << "nothing comes twice";
  EXPECT_LT(partitions, server.Description().partitions / 16);

  // Zooming back needs nothing from the server.
  server.log.clear();
  session.Zoom(1.0 / 40, onRingX, onRingY);
  server.Serve(session);
  EXPECT_TRUE(server.log.empty());
  EXPECT_NEAR(
    double(session.GetStatus().triangles), double(whole.triangles), 0.3 * double(whole.triangles));
}

TEST(TestViewDetail, AStillCameraComesToRest)
{
  MemoryServer server = Torus();
  ViewerSession session;
  OpenFullScreen(session, server);
  session.Zoom(6, onRingX, onRingY);
  server.Serve(session);
  const auto version = session.Scene().surfaceVersion;
  const auto choices = session.Parts().lod.Choices();
  server.log.clear();
  for (int i = 0; i < 10; ++i)
  {
    session.Resize({ width, height, 1 });
    session.BeginFrame();
    session.EndFrame(0.01);
    server.Take(session);
  }
  EXPECT_TRUE(session.IsIdle());
  EXPECT_TRUE(server.log.empty());
  EXPECT_EQ(session.Scene().surfaceVersion, version);
  EXPECT_EQ(session.Parts().lod.Choices(), choices);
}

// While the view moves, there are never holes, in whatever order pieces arrive.
TEST(TestViewDetail, TheSurfaceIsWholeAfterEveryArrival)
{
  for (const unsigned seed : { 1u, 2u, 3u, 4u })
  {
    std::mt19937 random(seed);
    MemoryServer server = Torus();
    SessionOptions options;
    options.refinement.triangles = seed == 4 ? 9'000 : 2'000'000;
    ViewerSession session(options);
    OpenFullScreen(session, server);
    double clock = 0;
    const auto chance = [&random](double most)
    { return most * double(random()) / double(std::mt19937::max()); };
    for (int step = 0; step < 12; ++step)
    {
      switch (random() % 4)
      {
        case 0:
          session.Zoom(1 + chance(3), 100 + chance(600), 100 + chance(400));
          break;
        case 1:
          session.Zoom(0.3 + chance(0.7), 400, 300);
          break;
        case 2:
          DoubleTap(session, 100 + chance(600), 100 + chance(400), clock);
          break;
        default:
          clock += 1;
          session.HandleTouches({ clock, { { 1, 300, 300 } } });
          session.HandleTouches({ clock += 0.1, { { 1, 300 + chance(200), 250 + chance(100) } } });
          session.HandleTouches({ clock += 0.1, {} });
      }
      for (auto answers = random() % 25; answers > 0; --answers)
      {
        session.BeginFrame();
        session.EndFrame(0.01);
        ExpectClosed(session);
        if (!server.Answer(session, &random))
        {
          break;
        }
      }
    }
    server.Serve(session, &random, [&session] { ExpectClosed(session); });
    EXPECT_TRUE(session.IsIdle());
    EXPECT_EQ(session.GetStatus().error, "");
  }
}

TEST(TestViewDetail, BudgetsHold)
{
  MemoryServer server = Torus();
  SessionOptions options;
  options.refinement.triangles = 8'000;
  ViewerSession session(options);
  OpenFullScreen(session, server);
  std::uint64_t most = 0;
  for (int i = 0; i < 8; ++i)
  {
    session.Zoom(1.6, onRingX, onRingY);
    server.Serve(session, nullptr, [&] { most = std::max(most, session.GetStatus().triangles); });
    EXPECT_TRUE(session.IsIdle());
  }
  EXPECT_GT(most, 5'000u);
  EXPECT_LT(most, 10'000u);
}

// Pieces that were found to be invisible, and then evicted, are not requested again.
TEST(TestViewDetail, WithoutRoomForMoreThanIsShownItComesToRestToo)
{
  MemoryServer server = Torus();
  SessionOptions options;
  options.cacheBytes = 0;
  ViewerSession session(options);
  OpenFullScreen(session, server);
  std::size_t frames = 0;
  for (int i = 0; i < 6; ++i)
  {
    session.Zoom(1.7, onRingX, onRingY);
    do
    {
      session.BeginFrame();
      session.EndFrame(0.01);
      ASSERT_LT(++frames, 3000u);
    } while (server.Answer(session));
    EXPECT_TRUE(session.IsIdle());
  }
}

TEST(TestViewDetail, WithPreviewsOnlyZoomsAndTapsWait)
{
  MemoryServer server = Torus();
  ViewerSession session;
  session.SetPreviewsOnly(true);
  OpenFullScreen(session, server);
  session.SetPrefetch(1 << 20);
  const std::size_t sent = server.sent.size();
  ASSERT_GT(sent, 0u);
  double clock = 0;
  session.Zoom(4, onRingX, onRingY);
  server.Serve(session);
  DoubleTap(session, width / 2.0, height / 2.0, clock); // goes home, or picks a partition
  session.Zoom(4, onRingX, onRingY);
  DoubleTap(session, onRingX, onRingY, clock);
  server.Serve(session);
  EXPECT_EQ(server.sent.size(), sent) << "nothing but the preview";
  EXPECT_EQ(session.GetStatus().shownLevel, 11u);
  EXPECT_EQ(session.GetStatus().error, "");
  EXPECT_FALSE(session.GetStatus().region);
  EXPECT_TRUE(session.GetStatus().picking);

  session.SetPreviewsOnly(false);
  server.Serve(session);
  EXPECT_TRUE(session.GetStatus().region) << "the last tap";
  EXPECT_FALSE(session.GetStatus().picking);
  EXPECT_GT(VerticesOfOriginal(session), 100u);
  EXPECT_TRUE(session.IsIdle());
  ExpectClosed(session);
}

// Seen from far away, nothing is left of what was tapped or refined.
TEST(TestViewDetail, FarAwayThePreviewIsEnough)
{
  MemoryServer server = Torus();
  ViewerSession session;
  OpenFullScreen(session, server);
  double clock = 0;
  for (int i = 0; i < 3; ++i)
  {
    session.Zoom(1.7, 400, 300);
    session.Zoom(1.1, onRingX, onRingY);
    server.Serve(session);
    DoubleTap(session, 200 + 60 * i, 300, clock);
    server.Serve(session);
  }
  EXPECT_TRUE(session.GetStatus().original);
  for (int i = 0; i < 40; ++i)
  {
    session.Zoom(0.87, 400, 300);
    server.Serve(session);
    ExpectClosed(session);
  }
  const ViewerStatus status = session.GetStatus();
  EXPECT_FALSE(status.region);
  EXPECT_FALSE(status.original);
  EXPECT_EQ(status.shownLevel, 11u);
}

// A scan with fewer vertices than the preview could have is shown as it is.
TEST(TestViewDetail, ASmallScanIsShownAsItIs)
{
  const Mesh mesh = MakeTorus(60, 30);
  MemoryServer server(mesh, 128, 2);
  ViewerSession session;
  OpenFullScreen(session, server);
  session.Zoom(3, 400, 300);
  session.Zoom(0.4, 400, 300);
  session.Resize({ 4 * width, 4 * height, 1 });
  server.Serve(session);
  EXPECT_EQ(VerticesOfOriginal(session), mesh.points.size());
  EXPECT_EQ(session.GetStatus().triangles, mesh.triangles.size());
}

TEST(TestViewDetail, FullShowsAllOfTheOriginal)
{
  MemoryServer server = Torus();
  SessionOptions options;
  options.detail = DetailMode::Full;
  ViewerSession session(options);
  OpenFullScreen(session, server);
  EXPECT_TRUE(session.IsIdle());
  EXPECT_EQ(session.GetStatus().triangles, server.Description().triangles);
  ExpectClosed(session);
  session.LeaveFullScreen();
  server.Serve(session);
  EXPECT_EQ(session.GetStatus().triangles, server.Description().levels[11].triangles);
}

// A server sends wrong pieces, parts of pieces, nothing, or the same twice, and its pages have
// wrong errors. There is no endless refinement, and no livelock. The surface is whole, unless a
// piece was sent in place of another one, which the session cannot detect.
TEST(TestViewDetail, AServerThatLiesIsSurvived)
{
  for (const unsigned seed : { 1u, 2u, 3u, 4u, 5u, 6u })
  {
    std::mt19937 random(seed);
    MemoryServer server = Torus();
    PieceTable lies = server.Table();
    for (unsigned d = 11; d <= server.Codec().depths.finest; ++d)
    {
      const NodeId first = NodeId{ 1 } << PieceDepth(Resolution::Level(d), server.Codec().depths);
      for (NodeId node = first; node < 2 * first; ++node)
      {
        auto& facts = lies.At({ Resolution::Level(d), node });
        facts.most99 = random() % 3 == 0 ? 1e30F : 0;
        facts.most = std::max(facts.most99, facts.most);
        facts.bytes = static_cast<std::uint32_t>(random() % 5 == 0 ? 60'000'000 : 1);
      }
    }
    server.TellOfPieces(lies);
    SessionOptions options;
    options.refinement.triangles = 60'000;
    ViewerSession session(options);
    OpenFullScreen(session, server);
    const std::vector<BlobId> all = server.AllBlobs();
    const bool swaps = seed % 2 == 0;
    std::size_t answers = 0, reported = 0;
    for (int step = 0; step < 8; ++step)
    {
      session.Zoom(step % 3 == 2 ? 0.4 : 2.5, 100 + 40 * step, 300);
      server.lie = [&](const BlobId& blob, std::vector<std::uint8_t>& bytes)
      {
        const auto generator = random() % 10;
        if (generator == 0 && swaps)
        {
          bytes = server.Blob(all[random() % all.size()]);
        }
        else if (generator == 1)
        {
          bytes.resize(random() % (bytes.size() + 1));
        }
        else if (generator == 2)
        {
          session.BlobArrived(static_cast<std::uint32_t>(random() % 100), blob, bytes, 0.01, false);
        }
        return generator != 3; // 3: the blob fails
      };
      do
      {
        session.BeginFrame();
        if (!swaps)
        {
          ExpectClosed(session);
        }
        session.EndFrame(0.01);
        ASSERT_LT(++answers, 20'000u);
      } while (server.Answer(session, &random));
      EXPECT_TRUE(session.IsIdle());
      EXPECT_LT(session.GetStatus().triangles, 100'000u);
      reported += session.GetStatus().error.find(" of torus cannot be loaded") != std::string::npos;
    }
    EXPECT_GT(reported, 0u);
  }
}

}
