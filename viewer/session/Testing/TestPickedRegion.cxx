// SPDX-License-Identifier: BSD-3-Clause
// The region around a tap: what it waits for, how large it may be, and which earlier regions stay.
#include "viewer/session/Testing/TorusModel.h"
#include "viewer/session/model/PickedRegion.h"

#include "filters/core/tree/Region.h"

#include <gtest/gtest.h>

using namespace kdstream;
using namespace kdstream::testing;
using protocol::BlobId;

namespace
{

constexpr std::uint64_t anyTriangles = std::numeric_limits<std::uint64_t>::max();
const Vec3 onRing{ 1, 0, 0.3 }, across{ -1, 0, 0.3 };

std::size_t SizeOf(const PickedRegion& region)
{
  std::vector<PieceId> pieces;
  if (region.IsShown())
  {
    region.AddTo(pieces);
  }
  return pieces.size();
}

TEST(TestPickedRegion, WaitsForTheTreeAroundTheTap)
{
  TorusModel torus;
  PickedRegion region(torus.model, 1, {}, anyTriangles);
  region.PickAt(onRing);
  std::size_t asked = 0;
  while (!region.Follow(true))
  {
    EXPECT_TRUE(region.IsPicking());
    EXPECT_EQ(region.Key().first, 0u);
    const auto missing = torus.model.open->tree.TakeMissing();
    ASSERT_FALSE(missing.empty());
    for (const BlobId& blob : missing)
    {
      ASSERT_TRUE(torus.TakeOfTree(blob));
      ++asked;
    }
  }
  EXPECT_GT(asked, 1u);
  EXPECT_FALSE(region.IsPicking());
  const auto [cell, rings] = region.Key();
  EXPECT_EQ(rings, 1u);
  const auto expected = FindRegion(torus.server.Tree(), torus.model.Depths(), cell, 1);
  EXPECT_EQ(SizeOf(region), expected->size());
  EXPECT_EQ(region.Boxes().size(), expected->size());
  ASSERT_TRUE(region.IsShown());
  EXPECT_EQ(region.GetStatus().partitions, expected->size());
  EXPECT_EQ(region.GetStatus().shown, 0u);
  EXPECT_LT(DistanceTo(region.Boxes().front(), onRing), 0.1); // the picked partition is first
}

TEST(TestPickedRegion, GivesUpWhereTooMuchOfTheTreeIsAskedFor)
{
  TorusModel torus;
  RegionLimits limits;
  limits.treeBlobs = 2;
  PickedRegion region(torus.model, 1, limits, anyTriangles);
  region.PickAt(onRing);
  region.NoteAsked(2);
  EXPECT_TRUE(region.IsPicking());
  region.NoteAsked(1);
  EXPECT_FALSE(region.IsPicking());
  EXPECT_NE(torus.model.failed.Message(), "");
  region.NoteAsked(3); // does not count: no pick is waiting
  region.PickAt(onRing);
  region.NoteAsked(2);
  EXPECT_TRUE(region.IsPicking());
}

TEST(TestPickedRegion, TakesNoMorePartitionsThanItMay)
{
  TorusModel torus;
  torus.TakeTree();
  RegionLimits limits;
  limits.partitions = 5;
  PickedRegion region(torus.model, 3, limits, anyTriangles);
  region.PickAt(onRing);
  ASSERT_TRUE(region.Follow(true));
  EXPECT_EQ(SizeOf(region), 5u);
  EXPECT_EQ(region.Boxes().size(), 5u);
  const Box first = region.Boxes().front();
  region.SetTriangles(2 * torus.model.TrianglesOfPartition(), anyTriangles);
  EXPECT_EQ(SizeOf(region), 2u);
  EXPECT_EQ(region.Boxes().front(), first);
  region.SetTriangles(0, anyTriangles);
  EXPECT_EQ(SizeOf(region), 1u); // the picked partition stays
}

TEST(TestPickedRegion, OtherRingsPickItsCellAnew)
{
  TorusModel torus;
  torus.TakeTree();
  PickedRegion region(torus.model, 0, {}, anyTriangles); // clamped to 1
  region.PickAt(onRing);
  ASSERT_TRUE(region.Follow(false));
  const auto [cell, rings] = region.Key();
  EXPECT_EQ(rings, 1u);
  const std::size_t small = SizeOf(region);
  region.SetRings(1);
  EXPECT_FALSE(region.IsPicking());
  region.SetRings(9);
  ASSERT_TRUE(region.Follow(false));
  EXPECT_EQ(region.Key(), std::pair(cell, 3u));
  EXPECT_GT(SizeOf(region), small);
}

TEST(TestPickedRegion, ThoseBeforeStayAsFarAsTheBudgetGoes)
{
  TorusModel torus;
  torus.TakeTree();
  PickedRegion region(torus.model, 1, {}, anyTriangles);
  region.PickAt(onRing);
  ASSERT_TRUE(region.Follow(true));
  const std::size_t first = SizeOf(region);
  region.PickAt(across);
  ASSERT_TRUE(region.Follow(true));
  const std::size_t second = region.Boxes().size();
  EXPECT_EQ(SizeOf(region), first + second);

  Camera away; // does not see the region
  away.FitTo({ { 100, 100, 100 }, { 101, 101, 101 } });
  region.ForgetEarlier(away);
  EXPECT_EQ(SizeOf(region), second);

  region.SetTriangles(anyTriangles, 4 * torus.model.TrianglesOfPartition());
  region.PickAt(onRing);
  ASSERT_TRUE(region.Follow(true));
  EXPECT_EQ(SizeOf(region), first + 2);
  region.LetGo();
  EXPECT_FALSE(region.IsShown());
  EXPECT_FALSE(region.HasEarlier());
}

TEST(TestPickedRegion, IsLetGoWhereItIsTooSmallToBeSeen)
{
  TorusModel torus;
  torus.TakeTree();
  PickedRegion region(torus.model, 1, {}, anyTriangles);
  region.PickAt(onRing);
  ASSERT_TRUE(region.Follow(true));
  region.FollowZoom(1000);
  EXPECT_TRUE(region.IsShown());
  region.FollowZoom(1);
  EXPECT_FALSE(region.IsShown());
}

TEST(TestPickedRegion, WhatTheSectionCutsAwayIsNotOfIt)
{
  TorusModel torus;
  torus.TakeTree();
  PickedRegion region(torus.model, 2, {}, anyTriangles);
  region.PickAt(onRing);
  ASSERT_TRUE(region.Follow(true));
  const std::size_t all = SizeOf(region);
  torus.model.section.Set(SectionPlane{ { 0, 0, 1 }, 0 });
  EXPECT_LT(SizeOf(region), all);
  torus.model.section.Set(SectionPlane{ { 1, 0, 0 }, -0.5 });
  EXPECT_EQ(SizeOf(region), 0u);
  EXPECT_EQ(region.GetStatus().partitions, 0u);
}

}
