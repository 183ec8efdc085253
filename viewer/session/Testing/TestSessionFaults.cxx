// SPDX-License-Identifier: BSD-3-Clause
// Blobs that fail, are lost, or come too late: there is a sentence about them, and the rest stays
// usable.
#include "Testing/Fixtures/ErrorAt.h"
#include "viewer/session/SessionFile.h"
#include "viewer/session/Testing/SessionsByLevel.h"

#include "filters/core/tree/Region.h"

#include <algorithm>
#include <cmath>
#include <limits>

using namespace kdstream;
using namespace kdstream::testing;
using protocol::BlobId;
using protocol::BlobKind;

namespace
{

TEST(TestSessionFaults, WhatIsShownIsKeptWhileSomethingElseComes)
{
  Fingers fingers;
  MemoryServer server = SmallTorus();
  SessionOptions options = ByLevel();
  options.cacheBytes = 1; // keeps nothing beyond what is shown or requested
  ViewerSession session(options);
  Open(session);
  server.Serve(session);
  const auto [x, y] = OnModel(session);
  fingers.Pinch(session, x, y, 16);
  server.Take(session);
  ASSERT_TRUE(server.Answer(session)); // one piece of the finer level
  fingers.Pinch(session, x, y, 0.02);
  server.Serve(session, nullptr, [&] { ExpectClosed(session); });
  EXPECT_EQ(session.GetStatus().shownLevel, 11u);
  EXPECT_EQ(server.sent.count(BlobId::LevelPiece(11, 1)), 1u);
}

TEST(TestSessionFaults, AnswersToCancelledRequestsAreIgnored)
{
  Fingers fingers;
  MemoryServer server = SmallTorus();
  SessionOptions options = ByLevel();
  options.policy.tolerance = 4; // the preview is fine enough for the whole torus
  ViewerSession session(options);
  OpenFullScreen(session, server);
  const auto [x, y] = OnModel(session);
  fingers.Pinch(session, x, y, 16);
  std::uint32_t request = 0;
  BlobId blob;
  for (const SessionRequest& sent : session.TakeRequests())
  {
    if (!sent.blobs.empty() && sent.blobs.back().kind == BlobKind::Level)
    {
      request = sent.id;
      blob = sent.blobs.back();
    }
  }
  ASSERT_NE(request, 0u);
  fingers.Pinch(session, x, y, 0.05);
  session.FollowView();
  const std::size_t blobs = session.Statistics().size();
  session.BlobArrived(request, blob, server.Blob(blob), 1, false);
  session.BlobFailed(request, blob, "late");
  session.RequestFailed(request, "late");
  session.RequestEnded(request);
  session.Opened(request, server.Description());
  EXPECT_EQ(session.Statistics().size(), blobs);
  EXPECT_EQ(session.GetStatus().error, "");
  EXPECT_TRUE(session.IsIdle());
}

TEST(TestSessionFaults, DamagedBytesBecomeASentenceAndTheNextCoarserLevel)
{
  Fingers fingers;
  MemoryServer server = SmallTorus();
  server.Blob(BlobId::LevelPiece(13, 5)).resize(40);
  ViewerSession session(ByLevel());
  Open(session);
  server.Serve(session);
  const auto [x, y] = OnModel(session);
  fingers.Pinch(session, x, y, 6);
  server.Serve(session, nullptr, [&] { ExpectClosed(session); });
  EXPECT_TRUE(session.IsIdle());
  ViewerStatus status = session.GetStatus();
  EXPECT_EQ(status.error.rfind("levels/13/5 of torus cannot be loaded: ", 0), 0u) << status.error;
  EXPECT_EQ(status.targetLevel, 13u);
  EXPECT_EQ(status.shownLevel, 12u);
  // The session stays usable: when the blob is undamaged again, the next pinch gets it, and nothing
  // else.
  server.Blob(BlobId::LevelPiece(13, 5)) =
    MemoryServer(SmallTorus()).Blob(BlobId::LevelPiece(13, 5));
  server.sent.clear();
  fingers.Pinch(session, x, y, 1.1);
  server.Serve(session);
  EXPECT_EQ(session.GetStatus().error, "");
  EXPECT_EQ(session.GetStatus().shownLevel, 13u);
  EXPECT_EQ(server.sent.count(BlobId::LevelPiece(13, 5)), 1u);
}

TEST(TestSessionFaults, ARefusedPartitionLeavesTheRestOfTheRegion)
{
  Fingers fingers;
  MemoryServer server = SmallTorus();
  ViewerSession session(ByLevel());
  Open(session);
  server.Serve(session);
  const auto [x, y] = OnModel(session);
  fingers.DoubleTap(session, x, y);
  TakeTree(session, server);
  const NodeId cell = session.GetStatus().region->cell;
  const std::uint32_t bad = cell - (1u << server.Codec().depths.partition);
  server.refused.insert(BlobId::Partition(bad));
  server.Serve(session, nullptr, [&] { ExpectClosed(session); });
  ViewerStatus status = session.GetStatus();
  EXPECT_TRUE(session.IsIdle());
  EXPECT_TRUE(fixtures::Mentions(
    status.error, { "partitions/" + std::to_string(bad) + " ", "torus", "it is damaged" }));
  EXPECT_EQ(status.region->shown + 1, status.region->partitions);
  // It is not requested again by itself, but by the next double tap.
  server.refused.clear();
  server.log.clear();
  session.Resize({ width, height, 1 });
  server.Serve(session);
  EXPECT_TRUE(server.log.empty());
  fingers.DoubleTap(session, x, y);
  server.Serve(session);
  status = session.GetStatus();
  EXPECT_EQ(status.region->shown, status.region->partitions);
  EXPECT_EQ(status.error, "");
}

TEST(TestSessionFaults, ALostConnectionFailsWhatWasOutstanding)
{
  Fingers fingers;
  MemoryServer server = SmallTorus();
  ViewerSession session(ByLevel());
  Open(session);
  server.Serve(session);
  const auto [x, y] = OnModel(session);
  fingers.DoubleTap(session, x, y);
  // The finer levels and the region fail, and then the coarser levels that would replace them.
  for (int round = 0; round < 4; ++round)
  {
    for (const SessionRequest& request : session.TakeRequests())
    {
      session.RequestFailed(request.id, "the connection was lost");
    }
  }
  EXPECT_TRUE(session.IsIdle());
  EXPECT_NE(session.GetStatus().error.find("the connection was lost"), std::string::npos);
  fingers.DoubleTap(session, x, y);
  server.Serve(session);
  EXPECT_EQ(session.GetStatus().region->shown, session.GetStatus().region->partitions);
}

TEST(TestSessionFaults, ModelsThatCannotBeShownAreRefusedWithAReason)
{
  ViewerSession session(ByLevel());
  ModelDescription model = MemoryServer(SmallTorus()).Description();
  model.levels.clear();
  Open(session);
  session.Opened(session.TakeRequests()[0].id, model);
  EXPECT_TRUE(fixtures::Mentions(session.GetStatus().error, { "torus", "no levels" }));
  EXPECT_TRUE(session.IsIdle());
  // Whatever the user does then, what is not there is not requested.
  session.EnterFullScreen();
  session.Zoom(2, width / 2, height / 2);
  session.SetRings(3);
  for (const double t : { 1.0, 1.1 })
  {
    session.HandleTouches({ t, { { 1, width / 2, height / 2 } } });
    session.HandleTouches({ t + 0.05, {} });
  }
  session.Resize({ 300, 500, 2 });
  session.BeginFrame();
  session.EndFrame(0.01);
  EXPECT_TRUE(session.Scene().surface->Whole().points.empty());
  EXPECT_TRUE(session.TakeRequests().empty());
  session.LeaveFullScreen();
  EXPECT_TRUE(session.IsIdle());
  ViewerSession deep(ByLevel());
  model = MemoryServer(SmallTorus()).Description();
  model.depths = { 30, 30, 30 };
  model.levels.resize(31);
  Open(deep);
  deep.Opened(deep.TakeRequests()[0].id, model);
  EXPECT_EQ(deep.GetStatus().error, "") << "nothing is taken for a tree that has not come";
}

}
