// SPDX-License-Identifier: BSD-3-Clause
// Encoding and decoding texture tiles, and damaged tiles.
#include "filters/codec/TextureTile.h"

#include "filters/codec/Seal.h"
#include "filters/codec/Testing/RandomTile.h"
#include "filters/core/BitCast.h"
#include "filters/core/VectorMath.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

using namespace kdstream;
using namespace kdstream::fixtures;

namespace
{

using Bytes = std::vector<std::uint8_t>;

// Compares the corners bit for bit.
void ExpectSameCorners(const ExactTile& a, const ExactTile& b)
{
  ASSERT_EQ(a.corners.size(), b.corners.size());
  for (std::size_t t = 0; t < a.corners.size(); ++t)
  {
    for (std::size_t k = 0; k < 3; ++k)
    {
      ASSERT_EQ(BitCast<std::uint64_t>(a.corners[t][k]), BitCast<std::uint64_t>(b.corners[t][k]));
    }
  }
}

std::string MessageOf(const Bytes& blob, const std::vector<Triangle>& triangles)
{
  const auto tile = DecodeTextureTile(blob, triangles);
  return tile ? "none" : tile.GetError().message;
}

// The first `size` bytes of the blob, with a correct checksum.
Bytes Sealed(Bytes blob, std::size_t size)
{
  blob.resize(size);
  SealBlob(blob);
  return blob;
}

}

TEST(TextureTile, ComesBack)
{
  std::mt19937 random(1);
  for (std::uint32_t side = 0; side < 30; ++side)
  {
    const std::vector<Triangle> triangles = TileGrid(side);
    const TextureTile tile = RandomTile(random, triangles);
    const Bytes blob = EncodeTextureTile(tile, triangles);
    const auto head = ReadTextureTileHead(blob);
    ASSERT_TRUE(head) << head.GetError().message;
    EXPECT_EQ(head->triangles, triangles.size());
    EXPECT_EQ(head->width, tile.width);
    EXPECT_EQ(head->height, tile.height);
    EXPECT_EQ(head->format, tile.format);
    EXPECT_FALSE(head->exact);
    EXPECT_EQ(Bytes(head->image.begin(), head->image.end()), tile.image);
    const auto back = DecodeTextureTile(blob, triangles);
    ASSERT_TRUE(back) << back.GetError().message;
    EXPECT_EQ(back->corners, tile.corners);
    EXPECT_EQ(back->image, tile.image);
  }
}

TEST(TextureTile, ExactOnesComeBackBitForBit)
{
  std::mt19937 random(2);
  for (std::uint32_t side = 2; side < 30; ++side)
  {
    const std::vector<Triangle> triangles = TileGrid(side);
    const TextureTile tile = RandomExactTile(random, triangles);
    const auto back = DecodeTextureTile(EncodeTextureTile(tile, triangles), triangles);
    ASSERT_TRUE(back) << back.GetError().message;
    ASSERT_TRUE(back->isExact);
    EXPECT_EQ(back->exact.halvings, tile.exact.halvings);
    EXPECT_EQ(back->exact.sources, tile.exact.sources);
    EXPECT_EQ(back->exact.charts, tile.exact.charts);
    EXPECT_EQ(back->exact.chartOf, tile.exact.chartOf);
    ExpectSameCorners(back->exact, tile.exact);
    for (std::size_t t = 0; t < triangles.size(); ++t)
    {
      const std::uint32_t chart = tile.exact.chartOf[t];
      ASSERT_EQ(back->corners[t][1], PlaceOfCorner(tile.exact, chart, tile.exact.corners[t][1]));
    }
  }
}

TEST(TextureTile, SmoothCoordinatesAreSmall)
{
  const std::vector<Triangle> triangles = TileGrid(50);
  TextureTile tile{ 2048, 2048, TileImage::Webp, {}, {} };
  for (const Triangle& t : triangles)
  {
    auto& corners = tile.corners.emplace_back();
    for (std::size_t k = 0; k < 3; ++k)
    {
      const double x = double(t[k] % 51) / 51, y = double(t[k] / 51) / 51;
      corners[k] = { float(2000 * x + 20 * std::sin(9 * y)), float(2000 * y + 20 * x * x) };
    }
  }
  // 24 bytes a triangle as floats.
  EXPECT_LT(EncodeTextureTile(tile, triangles).size(), triangles.size() * 2);
}

// Coarse tiles keep coordinates up to their last bits, and take fewer bytes than smooth ones.
TEST(TextureTile, CoarseCoordinatesAreRounded)
{
  std::mt19937 random(4);
  const std::vector<Triangle> triangles = TileGrid(20);
  TextureTile tile = RandomTile(random, triangles);
  const std::size_t fine = EncodeTextureTile(tile, triangles).size();
  tile.isCoarse = true;
  const Bytes blob = EncodeTextureTile(tile, triangles);
  EXPECT_LT(blob.size() + triangles.size() / 2, fine);
  const auto back = DecodeTextureTile(blob, triangles);
  ASSERT_TRUE(back) << back.GetError().message;
  EXPECT_TRUE(back->isCoarse);
  EXPECT_FALSE(back->isExact);
  EXPECT_EQ(back->format, tile.format);
  for (std::size_t t = 0; t < triangles.size(); ++t)
  {
    for (std::size_t k = 0; k < 3; ++k)
    {
      for (std::size_t i = 0; i < 2; ++i)
      {
        ASSERT_NEAR(back->corners[t][k][i], tile.corners[t][k][i], 0.5 / coarseTileSteps);
      }
    }
  }
  EXPECT_EQ(EncodeTextureTile(*back, triangles), blob);
}

// Planar tiles store charts, from which the coordinates of all corners follow.
TEST(TextureTile, PlanarCoordinatesFollowFromPositions)
{
  std::mt19937 random(8);
  const std::vector<Triangle> triangles = TileGrid(20);
  const std::vector<Vec3> points = TileGridPoints(20);
  const TextureTile tile = RandomPlanarTile(random, triangles);
  const Bytes blob = EncodeTextureTile(tile, triangles);
  EXPECT_LT(blob.size(), triangles.size());
  const auto back = DecodeTextureTile(blob, triangles, points);
  ASSERT_TRUE(back) << back.GetError().message;
  EXPECT_TRUE(back->isPlanar);
  EXPECT_FALSE(back->isCoarse);
  EXPECT_EQ(back->planar, tile.planar);
  EXPECT_EQ(EncodeTextureTile(*back, triangles), blob);
  const TextureTileHead head = *ReadTextureTileHead(blob);
  EXPECT_TRUE(head.planar);
  EXPECT_EQ(head.format, tile.format);
  for (std::size_t t = 0; t < triangles.size(); ++t)
  {
    const PlanarChart& chart = tile.planar.charts[tile.planar.chartOf[t]];
    const auto axes = AxesOf(chart);
    EXPECT_NEAR(Length(axes[0]), 1, 1e-9);
    EXPECT_NEAR(Dot(axes[0], axes[1]), 0, 1e-9);
    for (std::size_t k = 0; k < 3; ++k)
    {
      const Vec3 from = Minus(points[triangles[t][k]], points[0]);
      for (std::size_t i = 0; i < 2; ++i)
      {
        ASSERT_NEAR(back->corners[t][k][i],
          Dot(from, axes[i]) * tile.planar.texels + double(chart.offset[i]) / 8, 1e-3);
      }
    }
  }
}

TEST(TextureTile, DamagedPlanarTilesAreRefused)
{
  std::mt19937 random(9);
  const std::vector<Triangle> triangles = TileGrid(6);
  const std::vector<Vec3> points = TileGridPoints(6);
  const TextureTile good = RandomPlanarTile(random, triangles);
  const auto messageOf = [&](const Bytes& blob, std::span<const Vec3> positions)
  {
    const auto tile = DecodeTextureTile(blob, triangles, positions);
    return tile ? std::string("none") : tile.GetError().message;
  };
  const auto expect = [&](const TextureTile& tile, const char* what)
  {
    const std::string message = messageOf(EncodeTextureTile(tile, triangles), points);
    EXPECT_NE(message.find(what), std::string::npos) << message;
  };
  const Bytes blob = EncodeTextureTile(good, triangles);
  EXPECT_NE(messageOf(blob, {}).find("the positions of its piece are needed"), std::string::npos);
  for (const double texels : { 1e9, std::numeric_limits<double>::quiet_NaN() })
  {
    TextureTile tile = good;
    tile.planar.texels = texels;
    expect(tile, "a corner is outside the image");
  }
  TextureTile tile = good;
  tile.planar.charts[2].turn[1] = turnSteps + 1;
  expect(tile, "a chart's position is out of range");
  tile = good;
  tile.planar.charts[5].offset[0] = std::int64_t{ 1 } << 50;
  expect(tile, "a chart's position is out of range");
  tile = good;
  tile.planar.chartOf[7] = 6;
  expect(tile, "a triangle has an unknown chart");
  tile = good;
  tile.planar.charts.resize(triangles.size() + 1);
  expect(tile, "more charts than triangles");
  for (std::size_t size = 0; size + checksumSize < blob.size(); ++size)
  {
    EXPECT_NE(messageOf(Sealed(blob, size), points), "none") << size;
  }
}

TEST(TextureTile, CoordinatesOutsideAreKeptInside)
{
  const std::vector<Triangle> triangles = { { 0, 1, 2 } };
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const TextureTile tile{ 10, 20, TileImage::Png, {},
    { { { { -5, 3 }, { nan, 1e30F }, { 11, 20 } } } } };
  const auto back = DecodeTextureTile(EncodeTextureTile(tile, triangles), triangles);
  ASSERT_TRUE(back);
  const std::array<TileCoordinate, 3> inside{ { { 0, 3 }, { 0, 20 }, { 10, 20 } } };
  EXPECT_EQ(back->corners[0], inside);
}

TEST(TextureTile, ImagesHaveNames)
{
  EXPECT_EQ(NameOf(TileImage::Jpeg), "jpeg");
  EXPECT_EQ(NameOf(TileImage::Png), "png");
  EXPECT_EQ(NameOf(TileImage::Webp), "webp");
}

TEST(TextureTile, SaysWhatIsWrong)
{
  std::mt19937 random(3);
  const std::vector<Triangle> triangles = TileGrid(4);
  const TextureTile tile = RandomTile(random, triangles);
  const Bytes blob = EncodeTextureTile(tile, triangles);
  const std::size_t image =
    static_cast<std::size_t>(ReadTextureTileHead(blob)->image.data() - blob.data()) +
    tile.image.size();
  EXPECT_EQ(MessageOf(blob, TileGrid(3)),
    "texture: the number of triangles differs from the piece at byte " + std::to_string(image));
  EXPECT_EQ(MessageOf({ 'K', 'D', 'P' }, triangles), "texture: does not begin with \"KDX\"");
  Bytes other = blob;
  other[10] ^= 1;
  EXPECT_EQ(MessageOf(other, triangles), "texture: its checksum is wrong");
  other = blob;
  other[3] = 99;
  EXPECT_EQ(MessageOf(other, triangles), "texture: unknown codec version 99: this viewer knows 8");
  // A head with one byte for each number: 32 triangles, a WebP of 0 × 1 texels and 0 bytes.
  const Bytes head = { 'K', 'D', 'X', codecVersion, 32, 0, 1, 3, 0 };
  EXPECT_EQ(MessageOf(Sealed(head, 9), triangles), "texture: the image has no texels at byte 8");
  Bytes format = head;
  format[5] = 1;
  format[7] = 4;
  EXPECT_EQ(MessageOf(Sealed(format, 9), triangles), "texture: unknown image format at byte 8");
}

TEST(TextureTile, TruncatedAndDamagedOnesAreRefusedOrSound)
{
  std::mt19937 random(4);
  const std::vector<Triangle> triangles = TileGrid(6);
  for (const TextureTile& tile :
    { RandomTile(random, triangles), RandomExactTile(random, triangles) })
  {
    const Bytes blob = EncodeTextureTile(tile, triangles);
    const std::size_t content = blob.size() - checksumSize;
    for (std::size_t size = 0; size < content; ++size)
    {
      EXPECT_FALSE(DecodeTextureTile(Sealed(blob, size), triangles)) << size;
    }
    for (int i = 0; i < 3000; ++i)
    {
      Bytes damaged = blob;
      damaged[4 + random() % (content - 4)] ^= static_cast<std::uint8_t>(1 + random() % 255);
      const auto decoded = DecodeTextureTile(Sealed(damaged, content), triangles);
      for (std::size_t t = 0; decoded && t < triangles.size(); ++t)
      {
        for (const TileCoordinate& corner : decoded->corners[t])
        {
          ASSERT_TRUE(corner[0] >= 0 && corner[0] <= float(decoded->width));
          ASSERT_TRUE(corner[1] >= 0 && corner[1] <= float(decoded->height));
        }
      }
    }
  }
}
