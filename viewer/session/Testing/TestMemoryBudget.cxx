// SPDX-License-Identifier: BSD-3-Clause
// With less memory, a viewer shows a coarser surface, but always some surface.
#include "viewer/session/MemoryBudget.h"
#include "viewer/session/SessionParts.h"
#include "viewer/session/Testing/SessionsByView.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <limits>

using namespace kdstream;
using namespace kdstream::testing;

namespace
{

// Shares for this number of triangles; the torus takes more if it may.
MemoryShares SharesOf(std::uint64_t triangles)
{
  MemoryShares shares = MemoryBudget().Shares();
  shares.triangles = shares.levelTriangles = shares.regionTriangles = triangles;
  shares.cacheBytes = 60 * triangles;
  shares.viewBytes = 120 * triangles;
  return shares;
}

TEST(TestMemoryBudget, IsBroughtIntoItsRange)
{
  EXPECT_EQ(MemoryBudget().Bytes(), 150'000'000u);
  EXPECT_EQ(MemoryBudget(0).Bytes(), MemoryBudget::least);
  EXPECT_EQ(MemoryBudget(std::numeric_limits<std::size_t>::max()).Bytes(), MemoryBudget::most);
  EXPECT_EQ(MemoryBudget(64'000'000).Bytes(), 64'000'000u);
}

TEST(TestMemoryBudget, LeavesRoomForWhatIsDrawn)
{
  for (const std::size_t bytes :
    { MemoryBudget::least, MemoryBudget::standard, MemoryBudget::most })
  {
    const MemoryShares shares = MemoryBudget(bytes).Shares();
    EXPECT_LE(shares.cacheBytes + shares.treeBytes, bytes / 2);
    EXPECT_LE(shares.viewBytes, bytes / 2);
    EXPECT_GE(shares.triangles, bytes / 1000);
    EXPECT_LE(shares.triangles, bytes / 120); // decoded, drawn and uploaded
  }
}

TEST(TestMemoryBudget, SharesShrinkWithEachGrowthNearTheBudgetAndNeverToNothing)
{
  MemoryBudget budget(100'000'000);
  const MemoryShares whole = budget.Shares();
  EXPECT_FALSE(budget.Follow(80'000'000));
  EXPECT_FALSE(budget.Follow(87'500'000));
  EXPECT_EQ(budget.Shares(), whole);
  ASSERT_TRUE(budget.Follow(90'000'000));
  const MemoryShares less = budget.Shares();
  EXPECT_LT(less.triangles, whole.triangles);
  EXPECT_LT(less.regionTriangles, whole.regionTriangles);
  EXPECT_LT(less.levelTriangles, whole.levelTriangles);
  EXPECT_LT(less.cacheBytes, whole.cacheBytes);
  EXPECT_LT(less.viewBytes, whole.viewBytes);
  EXPECT_FALSE(budget.Follow(90'000'000)) << "it has been answered";
  EXPECT_FALSE(budget.Follow(70'000'000)) << "the graphics' part has gone";
  EXPECT_EQ(budget.Shares(), less) << "what was taken once may be taken again";
  std::size_t taken = 90'000'000;
  for (int i = 0; i < 100; ++i)
  {
    budget.Follow(taken += 2'000'000);
  }
  EXPECT_FALSE(budget.Follow(taken + 10'000'000)) << "it ends";
  EXPECT_GE(budget.Shares().triangles, whole.triangles / 6);
  EXPECT_GE(budget.Shares().cacheBytes, whole.cacheBytes / 6);
}

TEST(TestMemoryBudget, LessMakesWhatIsSeenCoarserAndMoreFinerAgain)
{
  MemoryServer server = Torus();
  ViewerSession session;
  OpenFullScreen(session, server);
  session.Zoom(3, onRingX, onRingY);
  server.Serve(session);
  const ViewerStatus whole = session.GetStatus();
  const std::size_t held = session.Parts().model.Bytes();
  ASSERT_GT(whole.triangles, 12'000u);
  ASSERT_EQ(whole.remainingError, 0);

  session.SetMemory(SharesOf(8'000));
  server.Serve(session);
  const ViewerStatus less = session.GetStatus();
  EXPECT_TRUE(session.IsIdle());
  EXPECT_EQ(less.error, "");
  EXPECT_LT(less.triangles, 10'000u);
  EXPECT_GT(less.triangles, 2'000u);
  EXPECT_GT(less.remainingError, 0);
  EXPECT_LT(session.Parts().model.Bytes(), held / 2);
  ExpectClosed(session);

  session.SetMemory(SharesOf(300'000));
  server.Serve(session);
  EXPECT_TRUE(session.IsIdle());
  EXPECT_EQ(session.GetStatus().remainingError, 0);
  EXPECT_GT(session.GetStatus().triangles, whole.triangles / 2);
}

TEST(TestMemoryBudget, ARegionIsCutToWhatThereIsRoomFor)
{
  MemoryServer server = Torus();
  SessionOptions options;
  options.rings = 3;
  ViewerSession session(options);
  OpenFullScreen(session, server);
  double clock = 0;
  for (int i = 0; i < 2; ++i)
  {
    session.HandleTouches({ clock += 0.1, { { 1, onRingX, onRingY } } });
    session.HandleTouches({ clock += 0.05, {} });
  }
  server.Serve(session);
  const auto whole = session.GetStatus().region;
  ASSERT_TRUE(whole);
  ASSERT_GT(whole->partitions, 8u);
  const std::uint64_t each = server.Description().triangles / server.Description().partitions;

  session.SetMemory(SharesOf(5 * each + each / 2));
  server.Serve(session);
  auto region = session.GetStatus().region;
  ASSERT_TRUE(region);
  EXPECT_EQ(region->cell, whole->cell);
  EXPECT_EQ(region->partitions, 5u);
  EXPECT_EQ(region->shown, 5u);
  EXPECT_TRUE(session.IsIdle());

  session.SetMemory(SharesOf(1));
  server.Serve(session);
  region = session.GetStatus().region;
  ASSERT_TRUE(region);
  EXPECT_EQ(region->partitions, 1u) << "what was picked is shown, whatever there is";
  EXPECT_EQ(region->shown, 1u);
  EXPECT_TRUE(session.IsIdle());
  ExpectClosed(session);
}

}
