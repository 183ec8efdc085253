// SPDX-License-Identifier: BSD-3-Clause
// Double taps: regions, and the part of the tree that they need.
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

TEST(TestSessionTaps, OtherRingsChangeTheRegionThatIsThere)
{
  Fingers fingers;
  MemoryServer server = SmallTorus();
  ViewerSession session(ByLevel());
  OpenFullScreen(session, server);
  const auto [x, y] = OnModel(session);
  fingers.DoubleTap(session, x, y);
  server.Serve(session);
  const auto first = session.GetStatus().region;
  ASSERT_TRUE(first);
  const auto regionOf = [&](unsigned rings)
  { return FindRegion(server.Tree(), server.Codec().depths, first->cell, rings)->size(); };
  ASSERT_GT(regionOf(2), regionOf(1));
  server.sent.clear();
  session.SetRings(2);
  server.Serve(session);
  auto region = session.GetStatus().region;
  EXPECT_EQ(region->cell, first->cell);
  EXPECT_EQ(region->rings, 2u);
  EXPECT_EQ(region->partitions, regionOf(2));
  EXPECT_EQ(region->shown, regionOf(2));
  EXPECT_EQ(server.sent.size(), regionOf(2) - regionOf(1)); // only the new ones
  ExpectClosed(session);
  session.SetRings(1);
  server.Serve(session);
  EXPECT_EQ(session.GetStatus().region->shown, regionOf(1));
  EXPECT_EQ(server.sent.size(), regionOf(2) - regionOf(1));
  session.LeaveFullScreen();
  session.SetRings(3);
  EXPECT_FALSE(session.GetStatus().region);
}

// A region that is small already when it is tapped stays. Only a zoom drops it.
TEST(TestSessionTaps, ASmallRegionStaysUntilOneZooms)
{
  Fingers fingers;
  MemoryServer server = SmallTorus();
  SessionOptions options = ByLevel();
  options.region.points = 10000;
  ViewerSession session(options);
  OpenFullScreen(session, server);
  const auto [x, y] = OnModel(session);
  fingers.DoubleTap(session, x, y);
  server.Serve(session);
  ASSERT_TRUE(session.GetStatus().region);
  session.HandleTouches({ fingers.now += 1, { { 1, x, y } } });
  session.HandleTouches({ fingers.now += 1, { { 1, x + 50, y } } });
  session.HandleTouches({ fingers.now += 1, {} });
  EXPECT_TRUE(session.GetStatus().region) << "turned";
  session.SetTool(Tool::Measure);
  session.SetTool(Tool::None);
  EXPECT_TRUE(session.GetStatus().region) << "a tool in hand";
  session.AskAgain();
  session.SetTurning(Turning::Free);
  session.SetSectionDepth(0.5);
  session.EnterFullScreen();
  session.SetDetail(DetailMode::Level);
  EXPECT_FALSE(session.LookFromSide("beside"));
  EXPECT_TRUE(session.GetStatus().region) << "nothing has changed";
  session.SetRings(2);
  server.Serve(session);
  EXPECT_EQ(session.GetStatus().region->rings, 2u);
  fingers.Pinch(session, x, y, 1.1);
  EXPECT_FALSE(session.GetStatus().region);
}

// A double tap that a tool uses requests nothing, so it does not request again what has failed.
TEST(TestSessionTaps, ATapThatAToolTakesLeavesTheMessage)
{
  Fingers fingers;
  MemoryServer server = SmallTorus();
  ViewerSession session(ByLevel());
  OpenFullScreen(session, server);
  ViewLink link = session.Link();
  link.digest = "0123456789abcdef";
  ASSERT_TRUE(session.Follow(link));
  const std::string message = session.GetStatus().error;
  ASSERT_NE(message, "");
  const auto [x, y] = OnModel(session);
  session.SetTool(Tool::Light);
  fingers.DoubleTap(session, x, y);
  EXPECT_EQ(session.GetStatus().error, message);
  session.SetTool(Tool::None);
  fingers.DoubleTap(session, x, y);
  EXPECT_EQ(session.GetStatus().error, "");
}

// The levels of a very small mesh have only points. A double tap on them still picks the original.
TEST(TestSessionTaps, PicksOnPointsWhereThereAreNoTriangles)
{
  Fingers fingers;
  Mesh mesh;
  mesh.points = { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 } };
  mesh.triangles = { { 0, 1, 2 } };
  MemoryServer server(mesh, 2000, 8);
  ViewerSession session(ByLevel());
  OpenFullScreen(session, server);
  const auto shown = session.Scene().surface;
  const Surface& coarse = shown->Whole();
  ASSERT_TRUE(coarse.triangles.empty());
  ASSERT_FALSE(coarse.points.empty());
  const ViewerScene scene = session.Scene();
  const Vec3 v = coarse.points[0] - scene.eye;
  const double scale =
    height / (2 * Camera::tangentOfHalfAngle * Dot(v, scene.orientation.Rotate({ 0, 0, -1 })));
  const double x = width * 0.5 + v[0] * scale, y = height * 0.5 - v[1] * scale;
  fingers.DoubleTap(session, x + 60, y); // too far away
  server.Serve(session);
  EXPECT_FALSE(session.GetStatus().region);
  fingers.DoubleTap(session, x + 20, y);
  server.Serve(session);
  ASSERT_TRUE(session.GetStatus().region);
  EXPECT_EQ(session.GetStatus().triangles, 1u);
}

TEST(TestSessionTaps, ARegionInALevelCoarserThanTheStitchLevelAsksForPiecesInBetween)
{
  Fingers fingers;
  MemoryServer server = SmallCells();
  SessionOptions options = ByLevel();
  options.policy.tolerance = 1000; // the preview is always fine enough
  ViewerSession session(options);
  Open(session);
  server.Serve(session);
  const auto [x, y] = OnModel(session);
  fingers.DoubleTap(session, x, y);
  server.Serve(session, nullptr, [&] { ExpectClosed(session); });
  const ViewerStatus status = session.GetStatus();
  EXPECT_EQ(status.shownLevel, 11u);
  ASSERT_TRUE(status.region);
  EXPECT_GT(status.region->shown, 1u);
  EXPECT_EQ(status.region->shown, status.region->partitions);
  EXPECT_GT(
    server.sent.count(BlobId::LevelPiece(12, 2)) + server.sent.count(BlobId::LevelPiece(12, 3)),
    0u);
}

TEST(TestSessionTaps, MovingTheRegionOnReusesPartitions)
{
  Fingers fingers;
  MemoryServer server = SmallTorus();
  SessionOptions options = ByLevel();
  options.region.points = 60;
  ViewerSession session(options);
  Open(session);
  server.Serve(session);
  const auto [x, y] = OnModel(session);
  fingers.DoubleTap(session, x, y);
  server.Serve(session);
  const NodeId cell = session.GetStatus().region->cell;
  const auto before = server.sent;
  double shift = 0;
  while (session.GetStatus().region->cell == cell && shift < 200)
  {
    shift += 5;
    fingers.DoubleTap(session, x, y + shift);
    ASSERT_TRUE(session.GetStatus().region);
  }
  server.Serve(session);
  EXPECT_NE(session.GetStatus().region->cell, cell);
  EXPECT_EQ(session.GetStatus().region->shown, session.GetStatus().region->partitions);
  for (const BlobId& blob : server.sent)
  {
    EXPECT_EQ(server.sent.count(blob), 1u) << protocol::BlobName(blob);
  }
  EXPECT_GT(server.sent.size(), before.size());
  // Turning and pinching keep the region; far away it is dropped.
  fingers.Pinch(session, x, y, 1.5);
  EXPECT_TRUE(session.GetStatus().region);
  for (int i = 0; i < 6; ++i)
  {
    fingers.Pinch(session, x, y, 0.3);
  }
  EXPECT_FALSE(session.GetStatus().region);
}

TEST(TestSessionTaps, ADoubleTapBeforeTheTreeWaitsForIt)
{
  Fingers fingers;
  MemoryServer server = SmallTorus();
  ViewerSession session(ByLevel());
  Open(session);
  server.Answer(session); // the model is opened
  server.Answer(session); // the preview
  session.BeginFrame();
  const auto [x, y] = OnModel(session);
  fingers.DoubleTap(session, x, y);
  EXPECT_FALSE(session.GetStatus().region);
  server.Serve(session);
  ASSERT_TRUE(session.GetStatus().region);
  EXPECT_EQ(session.GetStatus().region->shown, session.GetStatus().region->partitions);
}

// However large the model is, only pages and boxes on the way to the tap are fetched.
TEST(TestSessionTaps, OnlyTheTreeAroundATapComes)
{
  Fingers fingers;
  MemoryServer server(MakeTorus(200, 80), 4, 2); // P = 12: pages at the root, and at depth 7
  ViewerSession session(ByLevel());
  Open(session);
  server.Serve(session);
  const auto count = [&server](BlobKind kind)
  {
    return std::count_if(server.sent.begin(), server.sent.end(),
      [kind](const BlobId& blob) { return blob.kind == kind; });
  };
  EXPECT_EQ(count(BlobKind::Tree), 0) << "a preview needs none";
  session.EnterFullScreen();
  server.Serve(session);
  EXPECT_EQ(count(BlobKind::Tree), 1);
  const auto [x, y] = OnModel(session);
  fingers.DoubleTap(session, x, y);
  server.Serve(session);
  const auto region = session.GetStatus().region;
  ASSERT_TRUE(region);
  EXPECT_EQ(region->shown, region->partitions);
  EXPECT_EQ(region->partitions,
    FindRegion(server.Tree(), server.Codec().depths, region->cell, region->rings)->size());
  EXPECT_GE(count(BlobKind::Tree), 2);
  EXPECT_LE(count(BlobKind::Tree), 20) << "of 129";
  EXPECT_GE(count(BlobKind::Boxes), 1);
  EXPECT_LE(count(BlobKind::Boxes), 12) << "of 128";
}

TEST(TestSessionTaps, ATapThatNeedsTooMuchOfTheTreeIsDropped)
{
  Fingers fingers;
  MemoryServer server(MakeTorus(200, 80), 4, 2);
  SessionOptions options = ByLevel();
  options.region.treeBlobs = 2;
  ViewerSession session(options);
  OpenFullScreen(session, server);
  const auto [x, y] = OnModel(session);
  fingers.DoubleTap(session, x, y);
  server.Serve(session);
  EXPECT_FALSE(session.GetStatus().region);
  EXPECT_TRUE(session.IsIdle());
  EXPECT_TRUE(fixtures::Mentions(session.GetStatus().error, { "too large" }));
}

TEST(TestSessionTaps, APageThatFailsEndsTheTapWithAReasonAndTheNextTapRequestsItAgain)
{
  Fingers fingers;
  MemoryServer server(MakeTorus(200, 80), 4, 2);
  ViewerSession session(ByLevel());
  Open(session);
  server.Serve(session);
  const auto whole = server.Blob(BlobId::TreePage(1));
  server.Blob(BlobId::TreePage(1)).resize(20);
  const auto [x, y] = OnModel(session);
  fingers.DoubleTap(session, x, y);
  server.Serve(session);
  EXPECT_TRUE(session.IsIdle());
  EXPECT_FALSE(session.GetStatus().region);
  EXPECT_EQ(session.GetStatus().error.rfind("tree/1 of torus cannot be loaded: ", 0), 0u)
    << session.GetStatus().error;
  server.Blob(BlobId::TreePage(1)) = whole;
  fingers.DoubleTap(session, x, y);
  server.Serve(session);
  EXPECT_EQ(session.GetStatus().error, "");
  EXPECT_TRUE(session.GetStatus().region);
}

}
