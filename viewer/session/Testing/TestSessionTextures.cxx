// SPDX-License-Identifier: BSD-3-Clause
// The textures of a model are wanted where the view is near enough, stay within their budget, and
// are shown on the right parts.
#include "viewer/session/Testing/SessionsByView.h"
#include "viewer/session/texture/ShownTiles.h"
#include "viewer/session/texture/TexturedCorners.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

using namespace kdstream;
using namespace kdstream::testing;
using protocol::BlobId;
using protocol::BlobKind;

namespace
{

constexpr std::uint32_t side = 128; // of a tile, texels
constexpr std::size_t pictureBytes = 4 * side * side;

// P = 7: 16,000 vertices.
const MemoryServer& Plain()
{
  static const MemoryServer server(MakeTorus(200, 80), 128, 2);
  return server;
}

const MemoryServer& Textured()
{
  static const MemoryServer server = []
  {
    MemoryServer made = Plain();
    made.AddTiles(side);
    return made;
  }();
  return server;
}

std::size_t TexturesSent(const MemoryServer& server)
{
  return static_cast<std::size_t>(std::count_if(
    server.sent.begin(), server.sent.end(), [](const BlobId& blob) { return IsOfTexture(blob); }));
}

const MemoryServer& TexturedLevels()
{
  static const MemoryServer server = []
  {
    MemoryServer made = Textured();
    made.AddTilesOfLevels(side);
    return made;
  }();
  return server;
}

// Checks that the tile of each vertex of the original agrees with its place. Returns how many parts
// are textured.
std::size_t CountTexturedParts(const ViewerSession& session)
{
  const ViewerScene scene = session.Scene();
  std::size_t textured = 0;
  for (const DrawnSurface::Part& each : scene.surface->Parts())
  {
    const SurfacePart& part = *each.part;
    const auto found = FindTile(*scene.tiles, part.piece);
    if (!found)
    {
      continue;
    }
    ++textured;
    const TextureTile& tile = *found;
    EXPECT_TRUE(CanTexture(part.surface, part.corners, tile));
    const TexturedCorners corners = TexturedCornersOf(part.surface, part.corners, tile);
    EXPECT_EQ(corners.triangles.size(), part.surface.triangles.size());
    for (std::size_t v = 0; v < corners.points.size(); ++v)
    {
      if (part.surface.sources[corners.points[v]].resolution == part.piece.resolution)
      {
        const TileCoordinate expected = TilePlaceOf(part.surface.points[corners.points[v]]);
        EXPECT_FLOAT_EQ(corners.places[v][0] * side, expected[0]);
        EXPECT_FLOAT_EQ(corners.places[v][1] * side, expected[1]);
      }
    }
  }
  return textured;
}

TEST(TestSessionTextures, AreWantedWhereTheOriginalIsSeenClosely)
{
  MemoryServer server = Textured();
  ViewerSession session;
  OpenSmall(session, server);
  EXPECT_EQ(TexturesSent(server), 0u) << "colours of vertices are enough for a small picture";
  session.Resize({ width, height, 1 });
  session.Zoom(8, onRingX, onRingY);
  server.Serve(session);
  EXPECT_TRUE(session.IsIdle());
  EXPECT_EQ(session.GetStatus().error, "");
  EXPECT_GT(CountTexturedParts(session), 0u);
  EXPECT_LT(TexturesSent(server), server.Description().partitions / 2) << "what is not seen";
  for (const DrawnSurface::Part& each : session.Scene().surface->Parts())
  {
    const PieceId piece = each.part->piece;
    if (piece.resolution.IsOriginal() && session.GetCamera().MaySee(each.part->Bounds()))
    {
      EXPECT_TRUE(FindTile(*session.Scene().tiles, piece)) << "partition of node " << piece.node;
    }
  }
  const std::size_t sent = server.sent.size();
  session.Zoom(1.02, onRingX, onRingY);
  session.Zoom(1 / 1.02, onRingX, onRingY);
  server.Serve(session);
  EXPECT_EQ(server.sent.size(), sent) << "what is here is not asked for again";
}

// Wherever the camera is, everything that is drawn and may be visible is textured, in all
// resolutions.
TEST(TestSessionTextures, OfLevelsAreWantedToo)
{
  MemoryServer server = TexturedLevels();
  ViewerSession session;
  OpenFullScreen(session, server);
  std::size_t ofLevels = 0;
  for (const double zoom : { 1.0, 3.0, 8.0 })
  {
    session.Zoom(zoom, onRingX, onRingY);
    server.Serve(session);
    ASSERT_TRUE(session.IsIdle());
    EXPECT_EQ(session.GetStatus().error, "");
    EXPECT_GT(CountTexturedParts(session), 0u);
    for (const DrawnSurface::Part& each : session.Scene().surface->Parts())
    {
      const PieceId piece = each.part->piece;
      ofLevels += !piece.resolution.IsOriginal() && FindTile(*session.Scene().tiles, piece) ? 1 : 0;
    }
  }
  EXPECT_GT(ofLevels, 0u);
  EXPECT_TRUE(std::any_of(server.sent.begin(), server.sent.end(),
    [](const BlobId& blob) { return blob.kind == BlobKind::LevelTexture; }));
}

// If a level's texture cannot be fetched, the colours of vertices are shown, and the surface is
// whole.
TEST(TestSessionTextures, OfLevelsThatCannotBeHadAreNamed)
{
  MemoryServer server = TexturedLevels();
  server.lie = [](const BlobId& blob, std::vector<std::uint8_t>& bytes)
  {
    bytes[bytes.size() / 2] ^= blob.kind == BlobKind::LevelTexture ? 1 : 0;
    return true;
  };
  ViewerSession session;
  OpenFullScreen(session, server);
  EXPECT_TRUE(session.IsIdle());
  for (const DrawnSurface::Part& each : session.Scene().surface->Parts())
  {
    const PieceId piece = each.part->piece;
    EXPECT_TRUE(piece.resolution.IsOriginal() || !FindTile(*session.Scene().tiles, piece));
  }
  EXPECT_EQ(CountBoundaryEdges(session.Scene().surface->Whole().triangles), 0u);
  const std::string error = session.GetStatus().error;
  EXPECT_EQ(error.rfind("level-textures/", 0), 0u) << error;
}

// The parts of the original that may be visible.
std::size_t CountSeenParts(const ViewerSession& session)
{
  const auto& parts = session.Scene().surface->Parts();
  return static_cast<std::size_t>(std::count_if(parts.begin(), parts.end(),
    [&](const DrawnSurface::Part& each)
    {
      return each.part->piece.resolution.IsOriginal() && !each.part->surface.triangles.empty() &&
             session.GetCamera().MaySee(each.part->Bounds());
    }));
}

// Showing all as the original includes its pictures, however small the model is on the screen.
TEST(TestSessionTextures, AreAllWantedWhereAllIsTheOriginal)
{
  MemoryServer server = Textured();
  ViewerSession session;
  session.SetDetail(DetailMode::Full);
  OpenSmall(session, server);
  const std::size_t seen = CountSeenParts(session);
  EXPECT_GT(seen, server.Description().partitions / 2);
  EXPECT_EQ(CountTexturedParts(session), seen);

  ShownTiles tiles(std::size_t{ 1 } << 30);
  const auto wanted = [&](double spacing, bool all)
  {
    const std::size_t resolutions = server.Description().levels.size() + 1;
    tiles.Reset(server.Description(), std::vector<double>(resolutions, spacing));
    tiles.Follow(*session.Scene().surface, session.GetCamera(), {}, all);
    return tiles.Missing().size();
  };
  EXPECT_EQ(wanted(1, false), seen) << "vertices that are far apart";
  EXPECT_EQ(wanted(1e-6, false), 0u) << "colours of vertices are enough there";
  EXPECT_EQ(wanted(1e-6, true), seen);
}

// Two triangles of a piece at a common edge, which lies at two places of the tile. The corners of
// one triangle begin with another vertex than in the piece.
TEST(TestTexturedCorners, AVertexForEachPlace)
{
  Surface surface;
  surface.points = { {}, {}, {}, {} };
  surface.triangles = { { 0, 1, 2 }, { 0, 2, 3 } };
  TextureTile tile{ 10, 20, TileImage::Png, {}, {} };
  tile.corners = { { { { 6, 6 }, { 1, 2 }, { 3, 2 } } }, { { { 3, 4 }, { 1, 2 }, { 3, 2 } } } };
  const std::vector<std::uint32_t> corners{ 3 * 1 + 1, 3 * 0 + 0 };
  ASSERT_TRUE(CanTexture(surface, corners, tile));
  const TexturedCorners textured = TexturedCornersOf(surface, corners, tile);
  EXPECT_EQ(textured.points, (std::vector<VertexId>{ 0, 1, 2, 0, 2, 3 }));
  EXPECT_EQ(textured.triangles, (std::vector<Triangle>{ { 0, 1, 2 }, { 3, 4, 5 } }));
  const std::vector<std::array<float, 2>> places{ { 0.1f, 0.1f }, { 0.3f, 0.1f }, { 0.3f, 0.2f },
    { 0.6f, 0.3f }, { 0.1f, 0.1f }, { 0.3f, 0.1f } };
  EXPECT_EQ(textured.places, places);

  EXPECT_FALSE(CanTexture(surface, std::vector<std::uint32_t>{ 0, 6 }, tile))
    << "a triangle beyond";
  EXPECT_FALSE(CanTexture(surface, std::vector<std::uint32_t>{ 0 }, tile));
  EXPECT_FALSE(CanTexture(surface, {}, tile));
}

// A hostile case: a point that has another place in each of its many triangles. The time must not
// grow with the square of their number.
TEST(TestTexturedCorners, APointInManyPlaces)
{
  constexpr std::uint32_t count = 200'000;
  Surface surface;
  surface.points.resize(count + 2);
  TextureTile tile{ 16000, 16000, TileImage::Png, {}, {} };
  std::vector<std::uint32_t> corners;
  for (std::uint32_t i = 0; i < count; ++i)
  {
    const auto x = static_cast<float>(i) / 16;
    surface.triangles.push_back({ 0, i + 1, i + 2 });
    tile.corners.push_back({ { { x, 1 }, { 2, 2 }, { 3, 3 } } });
    corners.push_back(3 * i);
  }
  const TexturedCorners textured = TexturedCornersOf(surface, corners, tile);
  EXPECT_EQ(std::count(textured.points.begin(), textured.points.end(), 0u), count);
  EXPECT_EQ(textured.triangles.size(), count);
}

TEST(TestSessionTextures, AModelWithoutHasNone)
{
  MemoryServer server = Plain();
  ViewerSession session;
  OpenFullScreen(session, server);
  session.Zoom(30, onRingX, onRingY);
  server.Serve(session);
  EXPECT_EQ(TexturesSent(server), 0u);
  EXPECT_TRUE(session.Scene().tiles->empty());
  for (const DrawnSurface::Part& each : session.Scene().surface->Parts())
  {
    EXPECT_TRUE(each.part->corners.empty());
  }
}

// Also if the whole model is shown in one level, or as the original.
TEST(TestSessionTextures, OfATappedRegionComeByOneLevelToo)
{
  for (const DetailMode detail : { DetailMode::View, DetailMode::Level, DetailMode::Full })
  {
    MemoryServer server = Textured();
    ViewerSession session;
    session.SetDetail(detail);
    OpenFullScreen(session, server);
    for (int i = 0; i < 2; ++i)
    {
      session.HandleTouches({ 1 + 0.15 * i, { { 1, onRingX, onRingY } } });
      session.HandleTouches({ 1.05 + 0.15 * i, {} });
    }
    server.Serve(session);
    EXPECT_TRUE(session.IsIdle());
    ASSERT_TRUE(session.GetStatus().region);
    EXPECT_GE(CountTexturedParts(session), session.GetStatus().region->partitions / 2);
  }
}

TEST(TestSessionTextures, ThatCannotBeHadAreNamedAndTheSurfaceStays)
{
  for (const bool isRefused : { true, false })
  {
    MemoryServer server = Textured();
    if (isRefused)
    {
      for (std::uint32_t p = 0; p < server.Description().partitions; ++p)
      {
        server.refused.insert(BlobId::Texture(p));
      }
    }
    else
    {
      server.lie = [](const BlobId& blob, std::vector<std::uint8_t>& bytes)
      {
        bytes[bytes.size() / 2] ^= blob.kind == BlobKind::Texture ? 1 : 0;
        return true;
      };
    }
    ViewerSession session;
    OpenFullScreen(session, server);
    session.Zoom(30, onRingX, onRingY);
    server.Serve(session);
    EXPECT_TRUE(session.IsIdle());
    EXPECT_TRUE(session.Scene().tiles->empty());
    EXPECT_EQ(CountBoundaryEdges(session.Scene().surface->Whole().triangles), 0u);
    const std::string error = session.GetStatus().error;
    EXPECT_EQ(error.rfind("textures/", 0), 0u) << error;
    EXPECT_NE(error.find(" of torus cannot be loaded: "), std::string::npos) << error;
    const std::size_t asked = server.log.size();
    session.SetRings(2);
    server.Serve(session);
    for (std::size_t i = asked; i < server.log.size(); ++i)
    {
      EXPECT_EQ(server.log[i].find("textures/"), std::string::npos) << server.log[i];
    }
    server.refused.clear();
    server.lie = {};
    ASSERT_TRUE(session.SelectModel("torus")); // requests the failed textures again
    server.Serve(session);
    EXPECT_GT(CountTexturedParts(session), 0u);
    EXPECT_EQ(session.GetStatus().error, "");
  }
}

// In every view, the pictures stay within their limit, and those in the middle of the screen are
// there.
TEST(TestSessionTextures, StayWithinTheirBudget)
{
  constexpr std::size_t most = 5;
  MemoryServer server = Textured();
  SessionOptions options;
  options.pictureBytes = most * pictureBytes + 1;
  ViewerSession session(options);
  OpenFullScreen(session, server);
  std::mt19937 random(11);
  std::uniform_real_distribution<double> part(0, 1);
  std::size_t full = 0;
  for (int step = 0; step < 60; ++step)
  {
    session.Zoom(0.2 + 4 * part(random), width * part(random), height * part(random));
    server.Serve(session, &random, [&] { ASSERT_LE(session.Scene().tiles->size(), most); });
    ASSERT_TRUE(session.IsIdle());
    full += session.Scene().tiles->size() == most ? 1 : 0;
    CountTexturedParts(session);
    if (step % 10 == 9)
    {
      session.GoHome();
    }
  }
  EXPECT_GT(full, 10u);
  session.SetMemory({ std::size_t{ 1 } << 28, 1 << 24, std::size_t{ 1 } << 28, 1'000'000, 1'000'000,
    1'000'000, pictureBytes });
  EXPECT_LE(session.Scene().tiles->size(), 1u);
}

// A picture that is larger than the limit for all pictures is not decoded, and not requested
// endlessly.
TEST(TestSessionTextures, TooLargeOnesAreLeftOut)
{
  MemoryServer server = Plain();
  server.AddTiles(16000);
  SessionOptions options;
  options.pictureBytes = std::size_t{ 64 } << 20;
  ViewerSession session(options);
  OpenFullScreen(session, server);
  session.Zoom(30, onRingX, onRingY);
  server.Serve(session);
  EXPECT_TRUE(session.IsIdle());
  EXPECT_TRUE(session.Scene().tiles->empty());
  EXPECT_EQ(session.GetStatus().error, "");
}

}
