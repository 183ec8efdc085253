// SPDX-License-Identifier: BSD-3-Clause
// Textures of levels: a level's tile shows at each place what the finer tiles show there.
#include "filters/core/Light.h"
#include "filters/core/VectorMath.h"
#include "filters/texture/WritePicture.h"
#include "filters/texture/levels/LevelCharts.h"
#include "filters/texture/levels/LevelTile.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <utility>

using namespace kdstream;

namespace
{

constexpr double pi = 3.14159265358979;
using Rgb = std::array<double, 3>; // 0-255

// The colour of everything at a place.
Rgb PaintAt(const Vec3& p)
{
  return { 128 + 100 * std::sin(4 * p[0] + 1), 128 + 100 * std::sin(5 * p[1]),
    128 + 100 * std::sin(3 * p[2] - 2) };
}

// Half a sphere, x >= 0 or x <= 0, of about rings × rings × 4 triangles.
Piece HalfSphere(int rings, bool right)
{
  Piece piece;
  piece.id = { Resolution::Original(), right ? 3U : 2U };
  const int columns = 2 * rings;
  for (int i = 0; i <= rings; ++i)
  {
    for (int k = 0; k <= columns; ++k)
    {
      const double down = pi * i / rings, around = pi * k / columns - pi / 2;
      const double x = std::sin(down) * std::cos(around);
      piece.positions.push_back(
        { right ? x : -x, std::sin(down) * std::sin(around), std::cos(down) });
    }
  }
  for (int i = 0; i < rings; ++i)
  {
    for (int k = 0; k < columns; ++k)
    {
      const auto a = static_cast<VertexId>(i * (columns + 1) + k);
      const auto b = a + 1, c = a + static_cast<VertexId>(columns) + 1, d = c + 1;
      piece.triangles.push_back(right ? Triangle{ a, c, b } : Triangle{ a, b, c });
      piece.triangles.push_back(right ? Triangle{ b, c, d } : Triangle{ b, d, c });
    }
  }
  piece.ownVertices = piece.VertexCount();
  return piece;
}

Piece Joined(const Piece& a, const Piece& b)
{
  Piece both = a;
  for (const Triangle& t : b.triangles)
  {
    const VertexId first = a.VertexCount();
    both.triangles.push_back({ first + t[0], first + t[1], first + t[2] });
  }
  both.positions.insert(both.positions.end(), b.positions.begin(), b.positions.end());
  both.ownVertices = both.VertexCount();
  return both;
}

// Textured by two maps, for z >= 0 and for z < 0; the centre of a triangle decides.
FinerTile WithTexture(Piece piece)
{
  constexpr std::uint32_t side = 400;
  const auto along = [](double at) { return (at + 1.1) / 2.2 * side; };
  Picture picture{ 2 * side, side, 3, {} };
  for (std::uint32_t y = 0; y < side; ++y)
  {
    for (std::uint32_t x = 0; x < 2 * side; ++x)
    {
      const auto back = [](double at) { return (at + 0.5) / side * 2.2 - 1.1; };
      const double u = back(x % side), v = back(y);
      const double z = std::sqrt(std::max(0.0, 1 - u * u - v * v));
      for (const double value : PaintAt({ u, v, x < side ? z : -z }))
      {
        picture.texels.push_back(static_cast<std::uint8_t>(value));
      }
    }
  }
  TextureTile tile{ 2 * side, side, TileImage::Png, EncodePicture(picture, PictureType::Png), {} };
  for (const Triangle& t : piece.triangles)
  {
    const bool upper =
      piece.positions[t[0]][2] + piece.positions[t[1]][2] + piece.positions[t[2]][2] >= 0;
    auto& corners = tile.corners.emplace_back();
    for (std::size_t k = 0; k < 3; ++k)
    {
      const Vec3& p = piece.positions[t[k]];
      corners[k] = { float(along(p[0]) + (upper ? 0 : double(side))), float(along(p[1])) };
    }
  }
  return { std::move(piece), std::move(tile) };
}

Result<std::shared_ptr<const FinerColors>> Prepared(const FinerTile& finer)
{
  return std::shared_ptr<const FinerColors>(std::make_shared<const FinerColors>(finer));
}

// Two halves of a sphere, which are read one at a time.
struct PaintedSphere
{
  FinerTile left = WithTexture(HalfSphere(24, false)), right = WithTexture(HalfSphere(24, true));
  FinerTiles tiles{ { { { { -1, -1, -1 }, { 0, 1, 1 } } }, { { { 0, -1, -1 }, { 1, 1, 1 } } } },
    [this](std::size_t place) { return Prepared(place == 0 ? left : right); } };
};

Rgb TexelOf(const Picture& picture, double x, double y)
{
  const auto column = std::min(static_cast<std::size_t>(x), picture.width - 1);
  const auto row = std::min(static_cast<std::size_t>(y), picture.height - 1);
  const auto texel = RgbaOf(
    &picture.texels[(row * picture.width + column) * picture.components], picture.components);
  return { double(texel[0]), double(texel[1]), double(texel[2]) };
}

// The mean difference at places in the triangles, in grey values.
double DifferenceOf(const Piece& piece, const TextureTile& tile)
{
  const auto picture = DecodePicture(tile.image);
  EXPECT_TRUE(picture);
  EXPECT_EQ(picture->width, tile.width);
  double sum = 0;
  std::size_t count = 0;
  constexpr std::array<Vec3, 4> weights{ { { 0.34, 0.33, 0.33 }, { 0.8, 0.1, 0.1 },
    { 0.1, 0.8, 0.1 }, { 0.1, 0.1, 0.8 } } };
  for (std::size_t t = 0; t < piece.triangles.size(); ++t)
  {
    for (const Vec3& w : weights)
    {
      Vec3 p{};
      std::array<double, 2> at{};
      for (std::size_t k = 0; k < 3; ++k)
      {
        p = Plus(p, Times(piece.positions[piece.triangles[t][k]], w[k]));
        at[0] += w[k] * double(tile.corners[t][k][0]);
        at[1] += w[k] * double(tile.corners[t][k][1]);
      }
      const Rgb expected = PaintAt(Times(p, 1 / Length(p))),
                found = TexelOf(*picture, at[0], at[1]);
      for (std::size_t k = 0; k < 3; ++k)
      {
        sum += std::abs(expected[k] - found[k]);
        ++count;
      }
    }
  }
  return sum / double(count);
}

double AreaOf(const std::array<std::array<double, 2>, 3>& at)
{
  return (at[1][0] - at[0][0]) * (at[2][1] - at[0][1]) -
         (at[1][1] - at[0][1]) * (at[2][0] - at[0][0]);
}

}

TEST(LevelCharts, EachTriangleIsInOneAndTurnsTheSameWay)
{
  Piece piece = Joined(HalfSphere(9, false), HalfSphere(9, true));
  piece.triangles.push_back({ 3, 3, 5 }); // a triangle without area
  const auto charts = GrowLevelCharts(piece.positions, piece.triangles, 0.02);
  EXPECT_LT(charts.size(), piece.triangles.size() / 8);
  std::map<std::uint32_t, int> count;
  for (const LevelChart& chart : charts)
  {
    EXPECT_NEAR(Dot(chart.u, chart.v), 0, 1e-9);
    EXPECT_NEAR(Length(chart.u), 1, 1e-9);
    for (const std::uint32_t t : chart.triangles)
    {
      ++count[t];
      std::array<std::array<double, 2>, 3> at{};
      for (std::size_t k = 0; k < 3; ++k)
      {
        const Vec3& p = piece.positions[piece.triangles[t][k]];
        at[k] = { Dot(p, chart.u), Dot(p, chart.v) };
        for (std::size_t i = 0; i < 2; ++i)
        {
          EXPECT_GE(at[k][i], chart.lo[i]);
          EXPECT_LE(at[k][i], chart.hi[i]);
        }
      }
      EXPECT_GE(AreaOf(at), -1e-12);
    }
  }
  EXPECT_EQ(count.size(), piece.triangles.size());
  EXPECT_TRUE(
    std::all_of(count.begin(), count.end(), [](const auto& of) { return of.second == 1; }));
}

// A ramp that winds twice around an axis: its normals agree, but it overlaps itself.
TEST(LevelCharts, NothingLiesOverAnother)
{
  std::vector<Vec3> points;
  std::vector<Triangle> triangles;
  for (VertexId i = 0; i <= 128; ++i)
  {
    const double turn = 4 * pi * i / 128, up = 0.2 * i / 128;
    points.push_back({ std::cos(turn), std::sin(turn), up });
    points.push_back({ 2 * std::cos(turn), 2 * std::sin(turn), up });
    if (i > 0)
    {
      const VertexId a = 2 * i - 2;
      triangles.push_back({ a, a + 1, a + 2 });
      triangles.push_back({ a + 2, a + 1, a + 3 });
    }
  }
  const auto charts = GrowLevelCharts(points, triangles, 0.01);
  EXPECT_GE(charts.size(), 2U);
  EXPECT_LE(charts.size(), 6U);
  for (const LevelChart& chart : charts)
  {
    double area = 0;
    for (const std::uint32_t t : chart.triangles)
    {
      std::array<std::array<double, 2>, 3> at{};
      for (std::size_t k = 0; k < 3; ++k)
      {
        at[k] = { Dot(points[triangles[t][k]], chart.u), Dot(points[triangles[t][k]], chart.v) };
      }
      area += AreaOf(at) / 2;
    }
    EXPECT_LE(area, 1.02 * 3 * pi) << "a whole turn";
  }
}

TEST(LevelTile, ShowsWhatTheFinerTilesShow)
{
  const PaintedSphere sphere;
  Piece level = Joined(HalfSphere(12, false), HalfSphere(12, true));
  level.id = { Resolution::Level(3), 1 };
  const auto made = MakeLevelTile(level, sphere.tiles, {});
  ASSERT_TRUE(made) << made.GetError().message;
  ASSERT_EQ(made->tile.corners.size(), level.triangles.size());
  EXPECT_LT(DifferenceOf(level, made->tile), 4);
  // About this number of texels for each vertex, plus the gutters.
  EXPECT_LT(made->counts.texels, 3 * 64 * level.positions.size());
  // The decoded coordinates are those with which texels were sampled.
  const auto back = DecodeTextureTile(
    EncodeTextureTile(made->tile, level.triangles), level.triangles, level.positions);
  ASSERT_TRUE(back) << back.GetError().message;
  EXPECT_EQ(back->corners, made->tile.corners);

  const auto again = MakeLevelTile(level, sphere.tiles, {});
  ASSERT_TRUE(again);
  EXPECT_EQ(again->tile.image, made->tile.image);
}

// Samples again from that tile, as coarser levels do.
TEST(LevelTile, IsGoodEnoughForTheNextCoarserOne)
{
  const PaintedSphere sphere;
  FinerTile finer{ Joined(HalfSphere(20, false), HalfSphere(20, true)), {} };
  for (const int rings : { 20, 16, 12, 9 })
  {
    Piece level = Joined(HalfSphere(rings, false), HalfSphere(rings, true));
    const FinerTiles one{ { { { { -1, -1, -1 }, { 1, 1, 1 } } } },
      [&finer](std::size_t) { return Prepared(finer); } };
    const auto made = MakeLevelTile(level, rings == 20 ? sphere.tiles : one, {});
    ASSERT_TRUE(made) << made.GetError().message;
    EXPECT_LT(DifferenceOf(level, made->tile), 7) << rings;
    finer = { std::move(level), made->tile };
  }
}

TEST(LevelTile, HasNoMoreBytesThanItMay)
{
  const PaintedSphere sphere;
  const Piece level = HalfSphere(7, true);
  LevelTileOptions options;
  const auto all = MakeLevelTile(level, sphere.tiles, options);
  ASSERT_TRUE(all);
  options.mostBytes = all->tile.image.size() / 3;
  const auto fewer = MakeLevelTile(level, sphere.tiles, options);
  ASSERT_TRUE(fewer);
  EXPECT_LE(fewer->tile.image.size(), options.mostBytes);
  options = {};
  options.mostSide = 64;
  const auto small = MakeLevelTile(level, sphere.tiles, options);
  ASSERT_TRUE(small);
  EXPECT_LE(std::max(small->tile.width, small->tile.height), 64U);
}

// The triangles of flat walls are large. So a place may be in the box of one piece's own vertices,
// but on another piece's surface.
TEST(LevelTile, SamplesThePieceWhoseSurfaceIsNearestNotItsBox)
{
  const auto painted = [](std::vector<Vec3> points, std::vector<Triangle> triangles, Rgb color)
  {
    FinerTile finer;
    finer.piece.positions = std::move(points);
    finer.piece.triangles = std::move(triangles);
    finer.piece.ownVertices = 1;
    Picture picture{ 8, 8, 3, {} };
    for (std::size_t i = 0; i < 64; ++i)
    {
      for (const double value : color)
      {
        picture.texels.push_back(static_cast<std::uint8_t>(value));
      }
    }
    finer.tile = { 8, 8, TileImage::Png, EncodePicture(picture, PictureType::Png), {} };
    finer.tile.corners.assign(finer.piece.triangles.size(),
      { TileCoordinate{ 0, 0 }, TileCoordinate{ 8, 0 }, TileCoordinate{ 0, 8 } });
    return finer;
  };
  const Rgb red{ 255, 0, 0 }, blue{ 0, 0, 255 };
  const FinerTile wall = painted({ { 0, 0, 0 }, { 4, 0, 0 }, { 0, 4, 0 } }, { { 0, 1, 2 } }, red);
  const FinerTile ends = painted(
    { { 4, 0, 0 }, { 4.1, 0, 0 }, { 4, 0.1, 0 }, { 0, 4, 0 }, { 0.1, 4, 0 }, { 0, 4.1, 0 } },
    { { 0, 1, 2 }, { 3, 4, 5 } }, blue);
  const FinerTiles finer{ { { { { 0, 0, 0 }, { 4.1, 4.1, 0 } } },
                            { { { 0, 0, 0 }, { 0, 0, 0 } } } },
    [&](std::size_t place) { return Prepared(place == 0 ? ends : wall); } };
  Piece level = wall.piece;
  level.id = { Resolution::Level(2), 1 };
  LevelTileOptions options;
  options.texelsPerVertex = 2000;
  const auto made = MakeLevelTile(level, finer, options);
  ASSERT_TRUE(made) << made.GetError().message;
  const auto picture = DecodePicture(made->tile.image);
  ASSERT_TRUE(picture);
  const auto& at = made->tile.corners[0];
  for (const std::array<double, 3> weights :
    { std::array<double, 3>{ 0.34, 0.33, 0.33 }, { 0.1, 0.45, 0.45 }, { 0.9, 0.05, 0.05 } })
  {
    double x = 0, y = 0;
    for (std::size_t k = 0; k < 3; ++k)
    {
      x += weights[k] * double(at[k][0]);
      y += weights[k] * double(at[k][1]);
    }
    const Rgb color = TexelOf(*picture, x, y);
    EXPECT_GT(color[0], 200) << weights[0];
    EXPECT_LT(color[2], 60) << weights[0];
  }
}

// The two sides of a leaf have different colours.
TEST(LevelTile, DistinguishesTheTwoSidesOfALeaf)
{
  FinerTile leaf;
  for (const double z : { 0.0, 0.001 })
  {
    leaf.piece.positions.insert(
      leaf.piece.positions.end(), { { 0, 0, z }, { 1, 0, z }, { 1, 1, z }, { 0, 1, z } });
  }
  leaf.piece.triangles = { { 0, 2, 1 }, { 0, 3, 2 }, { 4, 5, 6 }, { 4, 6, 7 } };
  leaf.piece.ownVertices = 8;
  const Picture halves{ 2, 1, 3, { 255, 0, 0, 0, 0, 255 } };
  leaf.tile = { 2, 1, TileImage::Png, EncodePicture(halves, PictureType::Png), {} };
  const TileCoordinate red{ 0.5F, 0.5F }, blue{ 1.5F, 0.5F };
  leaf.tile.corners = { { red, red, red }, { red, red, red }, { blue, blue, blue },
    { blue, blue, blue } };
  Piece level = leaf.piece;
  for (std::size_t v = 0; v < 4; ++v) // the two sides have crossed, as in a level
  {
    level.positions[v][2] = 0.002;
  }
  const FinerTiles finer{ { { { { 0, 0, 0 }, { 1, 1, 0.001 } } } },
    [&leaf](std::size_t) { return Prepared(leaf); } };
  const auto made = MakeLevelTile(level, finer, {});
  ASSERT_TRUE(made) << made.GetError().message;
  const auto picture = DecodePicture(made->tile.image);
  ASSERT_TRUE(picture);
  for (std::size_t t = 0; t < 4; ++t)
  {
    const auto& at = made->tile.corners[t];
    const Rgb color = TexelOf(*picture, double(at[0][0] + at[1][0] + at[2][0]) / 3,
      double(at[0][1] + at[1][1] + at[2][1]) / 3);
    EXPECT_GT(color[t < 2 ? 0 : 2], 200) << t;
    EXPECT_LT(color[t < 2 ? 2 : 0], 60) << t;
  }
}

// A red wall meets a blue underside at its foot. The level's wall lies inside of the finer wall, so
// near the edge the underside is nearer.
TEST(LevelTile, AnEdgeShowsOneSide)
{
  const auto add = [](Piece& piece, VertexId cells, const auto& placeOf)
  {
    const VertexId first = piece.VertexCount(), row = cells + 1;
    for (VertexId i = 0; i < row * row; ++i)
    {
      piece.positions.push_back(placeOf(double(i % row) / cells, double(i / row) / cells));
    }
    for (VertexId i = 0; i < cells * cells; ++i)
    {
      const VertexId a = first + i / cells * row + i % cells;
      piece.triangles.push_back({ a, a + row, a + 1 });
      piece.triangles.push_back({ a + 1, a + row, a + row + 1 });
    }
    piece.ownVertices = piece.VertexCount();
  };
  FinerTile foot;
  add(foot.piece, 10, [](double y, double z) { return Vec3{ 0, y, z }; });
  const std::size_t ofWall = foot.piece.triangles.size();
  add(foot.piece, 10, [](double y, double x) { return Vec3{ x, 1 - y, 0 }; });
  const Picture halves{ 2, 1, 3, { 255, 0, 0, 0, 0, 255 } };
  foot.tile = { 2, 1, TileImage::Png, EncodePicture(halves, PictureType::Png), {} };
  const TileCoordinate red{ 0.5F, 0.5F }, blue{ 1.5F, 0.5F };
  foot.tile.corners.assign(ofWall, { red, red, red });
  foot.tile.corners.insert(foot.tile.corners.end(), ofWall, { blue, blue, blue });
  Piece level;
  add(level, 4, [](double y, double z) { return Vec3{ 0.03, y, z }; });
  const FinerTiles finer{ { { { { 0, 0, 0 }, { 1, 1, 1 } } } },
    [&foot](std::size_t) { return Prepared(foot); } };
  const auto made = MakeLevelTile(level, finer, {});
  ASSERT_TRUE(made) << made.GetError().message;
  const auto picture = DecodePicture(made->tile.image);
  ASSERT_TRUE(picture);
  for (std::size_t t = 0; t < level.triangles.size(); ++t)
  {
    for (const TileCoordinate& at : made->tile.corners[t])
    {
      const Rgb color = TexelOf(*picture, double(at[0]), double(at[1]));
      EXPECT_GT(color[0], 200) << t;
      EXPECT_LT(color[2], 60) << t;
    }
  }
}

// Hostile or odd meshes: triangles without area, no triangles, very many charts.
TEST(LevelTile, OddPieces)
{
  const PaintedSphere sphere;
  Piece flat;
  flat.positions = { { 0, 0, 0 }, { 1, 0, 0 }, { 2, 0, 0 }, { 1e30, 0, 0 } };
  flat.triangles = { { 0, 1, 2 }, { 0, 1, 3 } };
  flat.ownVertices = 4;
  Piece none;
  none.positions = { { 0, 0, 0 } };
  none.ownVertices = 1;
  Piece crowd;
  for (VertexId i = 0; i < 2000; ++i)
  {
    const double x = std::sin(i * 1.7), y = std::sin(i * 2.9), z = std::sin(i * 3.3);
    crowd.positions.insert(crowd.positions.end(),
      { { x, y, z }, { x + 0.001, y, z + 0.001 * (i % 3) }, { x, y + 0.001, z } });
    crowd.triangles.push_back({ 3 * i, 3 * i + 1, 3 * i + 2 });
  }
  crowd.ownVertices = crowd.VertexCount();
  for (const Piece& piece : { flat, none, crowd })
  {
    const auto made = MakeLevelTile(piece, sphere.tiles, {});
    ASSERT_TRUE(made) << made.GetError().message;
    EXPECT_TRUE(DecodeTextureTile(
      EncodeTextureTile(made->tile, piece.triangles), piece.triangles, piece.positions));
  }
}

TEST(LevelTile, WrongImagesAreErrors)
{
  PaintedSphere sphere;
  sphere.right.tile.image = { 1, 2, 3 };
  EXPECT_FALSE(MakeLevelTile(HalfSphere(5, true), sphere.tiles, {}));
  sphere.right.tile.image = EncodePicture({ 1, 1, 3, { 1, 2, 3 } }, PictureType::Png);
  const auto made = MakeLevelTile(HalfSphere(5, true), sphere.tiles, {});
  ASSERT_FALSE(made);
  EXPECT_EQ(made.GetError().code, ErrorCode::Damaged);
}

TEST(LevelTile, StopsWithinAPiece)
{
  PaintedSphere sphere;
  Piece level = Joined(HalfSphere(12, false), HalfSphere(12, true));
  std::size_t asked = 0;
  sphere.tiles.goesOn = [&asked]
  {
    ++asked;
    return true;
  };
  const auto whole = MakeLevelTile(level, sphere.tiles, {});
  ASSERT_TRUE(whole) << whole.GetError().message;
  EXPECT_GE(asked, whole->counts.texels / 2 / FinerTiles::texelsBetween); // some have no owner

  asked = 0;
  sphere.tiles.goesOn = [&asked] { return ++asked < 2; };
  const auto stopped = MakeLevelTile(level, sphere.tiles, {});
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.GetError().code, ErrorCode::Cancelled);
  EXPECT_EQ(asked, 2U);
}
