// SPDX-License-Identifier: BSD-3-Clause
// Two numbers, triangles and memory (SharesOfBudgets), limit everything that a session has in
// memory: levels for the whole model, regions around taps, and decoded pictures of textures.
#include "viewer/session/MemoryBudget.h"
#include "viewer/session/SessionParts.h"
#include "viewer/session/Testing/SessionsByLevel.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <tuple>

using namespace kdstream;
using namespace kdstream::testing;

namespace
{

constexpr std::uint64_t manyTriangles = 2'000'000;
constexpr std::size_t muchMemory = std::size_t{ 1 } << 30;

std::uint64_t TrianglesOfPartition()
{
  return SmallTorus().Description().triangles / SmallTorus().Description().partitions;
}

TEST(TestSessionBudgets, SharesGrowWithThem)
{
  MemoryShares before = SharesOfBudgets(0, 0);
  for (std::uint64_t step = 1; step < 40; ++step)
  {
    const MemoryShares shares =
      SharesOfBudgets(std::uint64_t{ 1 } << (step / 2 + 10), std::size_t{ 1 } << ((step + 1) / 2));
    EXPECT_GE(shares.levelTriangles, before.levelTriangles);
    EXPECT_GE(shares.regionTriangles, before.regionTriangles);
    EXPECT_GE(shares.pictureBytes, before.pictureBytes);
    EXPECT_LE(shares.levelTriangles, shares.triangles);
    EXPECT_LE(shares.regionTriangles, shares.triangles / 2);
    before = shares;
  }
  EXPECT_EQ(SharesOfBudgets(manyTriangles, muchMemory).levelTriangles, manyTriangles);
}

// Makes a session with these budgets, set at the beginning or later: both must have the same
// effect.
ViewerSession SessionWith(
  SessionOptions options, std::uint64_t triangles, std::size_t memory, bool later)
{
  options.TakeShares(
    later ? SharesOfBudgets(manyTriangles, muchMemory) : SharesOfBudgets(triangles, memory));
  ViewerSession session(options);
  if (later)
  {
    session.SetBudgets(triangles, memory);
  }
  return session;
}

std::size_t PictureBytes(const ViewerSession& session)
{
  std::size_t bytes = 0;
  for (const TexturedPiece& each : *session.Scene().tiles)
  {
    bytes += std::size_t{ 4 } * each.tile->width * each.tile->height;
  }
  return bytes;
}

TEST(TestSessionBudgets, MemoryBoundsPicturesOfTextures)
{
  constexpr std::uint32_t side = 512; // 1 MiB for each tile
  MemoryServer textured = SmallTorus();
  textured.AddTiles(side);
  for (const bool later : { false, true })
  {
    std::size_t last = 0;
    for (const std::size_t memory : { std::size_t{ 8 } << 20, muchMemory })
    {
      MemoryServer server = textured;
      ViewerSession session = SessionWith({}, manyTriangles, memory, later);
      OpenFullScreen(session, server);
      session.Zoom(4, onRingX, onRingY);
      server.Serve(session, nullptr, [&] { ASSERT_LE(PictureBytes(session), memory / 2); });
      EXPECT_TRUE(session.IsIdle());
      EXPECT_GT(PictureBytes(session), last) << "there is room for more";
      last = PictureBytes(session);
    }
    EXPECT_GT(last, std::size_t{ 4 } << 20);
  }
}

// With a smaller limit, pictures that are already there are dropped.
TEST(TestSessionBudgets, LessMemoryLetsPicturesGo)
{
  MemoryServer server = SmallTorus();
  server.AddTiles(512);
  ViewerSession session;
  OpenFullScreen(session, server);
  session.Zoom(4, onRingX, onRingY);
  server.Serve(session);
  ASSERT_GT(PictureBytes(session), std::size_t{ 4 } << 20);
  session.SetBudgets(manyTriangles, std::size_t{ 8 } << 20);
  EXPECT_LE(PictureBytes(session), std::size_t{ 4 } << 20);
}

// Taps a region of three rings, and then another place beside it.
TEST(TestSessionBudgets, BothBoundRegionsAroundTaps)
{
  Fingers fingers;
  struct Case
  {
    std::uint64_t triangles;
    std::size_t memory;
    std::uint32_t partitions;
  };
  const std::uint64_t each = TrianglesOfPartition();
  for (const auto& [triangles, memory, partitions] : { Case{ 8 * each, muchMemory, 4 },
         Case{ manyTriangles, std::size_t{ 300 * 6 * each }, 6 }, Case{ 1, muchMemory, 1 } })
  {
    for (const bool later : { false, true })
    {
      MemoryServer server = SmallTorus();
      SessionOptions options;
      options.rings = 3;
      ViewerSession session = SessionWith(options, triangles, memory, later);
      OpenFullScreen(session, server);
      const double move = 12; // pixels
      for (int tap = 0; tap < 4; ++tap)
      {
        fingers.DoubleTap(session, onRingX, onRingY + move * tap);
        server.Serve(session);
        const auto region = session.GetStatus().region;
        ASSERT_TRUE(region);
        EXPECT_EQ(region->partitions, partitions);
        EXPECT_EQ(region->shown, partitions);
        EXPECT_TRUE(session.IsIdle());
        ExpectClosed(session);
        std::uint64_t originals = 0;
        for (const PieceId piece : session.Parts().model.surface.Pieces())
        {
          originals += piece.resolution.IsOriginal() ? 1 : 0;
        }
        if (triangles != manyTriangles)
        {
          EXPECT_LE(originals, 2 * partitions) << "with the taps before";
          EXPECT_LE(session.GetStatus().triangles, triangles + 5'000) << "and the preview";
        }
      }
    }
  }
}

TEST(TestSessionBudgets, LessCutsTheRegionThatIsThere)
{
  Fingers fingers;
  MemoryServer server = SmallTorus();
  SessionOptions options;
  options.rings = 3;
  ViewerSession session(options);
  OpenFullScreen(session, server);
  fingers.DoubleTap(session, onRingX, onRingY);
  server.Serve(session);
  const auto whole = session.GetStatus().region;
  ASSERT_TRUE(whole);
  ASSERT_GT(whole->partitions, 8u);
  session.SetBudgets(8 * TrianglesOfPartition(), muchMemory);
  server.Serve(session);
  ASSERT_TRUE(session.GetStatus().region);
  EXPECT_EQ(session.GetStatus().region->cell, whole->cell);
  EXPECT_EQ(session.GetStatus().region->partitions, 4u);
  ExpectClosed(session);
}

// One level for the whole model: the finest that both budgets allow.
TEST(TestSessionBudgets, BothBoundTheLevel)
{
  const auto& levels = SmallTorus().Description().levels;
  const std::uint64_t fits = levels[12].triangles; // but level 13 does not fit
  for (const bool later : { false, true })
  {
    for (const auto& [triangles, memory, level] :
      { std::tuple{ manyTriangles, muchMemory, 13u }, std::tuple{ fits, muchMemory, 12u },
        std::tuple{ manyTriangles, std::size_t{ 121 * fits }, 12u },
        std::tuple{ manyTriangles, std::size_t{ 1 }, 11u } })
    {
      MemoryServer server = SmallTorus();
      ViewerSession session = SessionWith(ByLevel(), triangles, memory, later);
      Open(session);
      server.Serve(session);
      session.EnterFullScreen();
      session.Zoom(50, width * 0.5, height * 0.5);
      server.Serve(session);
      EXPECT_EQ(session.GetStatus().shownLevel, level) << triangles << " " << memory;
      EXPECT_EQ(session.GetStatus().triangles, levels[level].triangles);
    }
  }
}

}
