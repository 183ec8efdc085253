// SPDX-License-Identifier: BSD-3-Clause
// Models that a picture paints, tiled and whole: see TiledScenes.h.
#include "viewer/mobile/Testing/TiledScenes.h"

#include "filters/codec/PieceCodec.h"
#include "filters/texture/MakeTile.h"
#include "filters/texture/WritePicture.h"
#include "viewer/session/Testing/MemoryServer.h"
#include "viewer/session/ViewerSession.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace kdstream::test
{
namespace
{

constexpr std::uint32_t side = 1024; // texels of the picture

// Of a stretch of `length`: 1 inside, 0 outside, over four texels at each end, as a lens leaves it.
double Within(double at, double length)
{
  return std::clamp(at / 4 + 0.5, 0.0, 1.0) - std::clamp((at - length) / 4 + 0.5, 0.0, 1.0);
}

// As photographs are: the finer, the fainter; and a script whose edges are a little soft.
Picture MakePhotograph()
{
  Picture picture{ side, side, 3, {} };
  for (std::uint32_t y = 0; y < side; ++y)
  {
    for (std::uint32_t x = 0; x < side; ++x)
    {
      double light = 130;
      for (double length = 200, angle = 0.3; length > 4; length /= 2.3, angle += 1.9)
      {
        light += 0.25 * length * std::sin((x * std::cos(angle) + y * std::sin(angle)) / length * 6);
      }
      const double across = std::fmod(x + 24 * std::floor(y / 40.0), 120), down = y % 40;
      light -= 60 * Within(across - 12, 24) * Within(down - 12, 8);
      for (const double share : { 1.0, 0.9, 0.75 })
      {
        picture.texels.push_back(static_cast<std::uint8_t>(std::clamp(share * light, 0.0, 255.0)));
      }
    }
  }
  return picture;
}

// Where the picture, seen from the model's front, meets a place; v down.
PictureCoordinate PlaceInPhotograph(const Vec3& p)
{
  return { static_cast<float>((p[0] + 1.5) / 3),
    static_cast<float>((1.5 - p[1] - 0.1 * p[2]) / 3) };
}

Piece OriginalPiece(kdstream::testing::MemoryServer& server, PieceId id)
{
  const auto partition =
    static_cast<std::uint32_t>(id.node - NodeOfPartition(0, server.Description().depths));
  auto piece = DecodePiece(server.Blob(protocol::BlobId::Partition(partition)), id, server.Codec());
  if (!piece)
  {
    throw std::runtime_error(piece.GetError().message);
  }
  return std::move(*piece);
}

// By the photograph, as a lossless build makes it, or the whole of it.
class Photograph
{
public:
  Photograph()
    : Taken(MakePhotograph())
    , Source({ this->Taken })
    , Encoded(EncodePicture(this->Taken, PictureType::Png))
  {
    TexturedMaterial material;
    material.picture = 0;
    this->How = { { material }, 1 };
  }

  std::shared_ptr<const TextureTile> TileOf(const Piece& piece) const
  {
    TexturedTriangles painted{ piece.triangles, this->CornersOf(piece), {} };
    painted.materialOf.assign(piece.triangles.size(), 0);
    const auto made = MakeTile(painted, this->How, this->Source, { 0, longestTileSide });
    if (!made)
    {
      throw std::runtime_error(made.GetError().message);
    }
    auto tile = DecodeTextureTile(EncodeTextureTile(made->tile, piece.triangles), piece.triangles);
    if (!tile)
    {
      throw std::runtime_error(tile.GetError().message);
    }
    return std::make_shared<const TextureTile>(std::move(*tile));
  }

  std::shared_ptr<const TextureTile> WholeOf(const Piece& piece) const
  {
    TextureTile tile{ side, side, TileImage::Png, this->Encoded, {} };
    for (const std::array<PictureCoordinate, 3>& triangle : this->CornersOf(piece))
    {
      std::array<TileCoordinate, 3>& corners = tile.corners.emplace_back();
      for (std::size_t k = 0; k < 3; ++k)
      {
        corners[k] = { triangle[k][0] * side, triangle[k][1] * side };
      }
    }
    return std::make_shared<const TextureTile>(std::move(tile));
  }

private:
  static std::vector<std::array<PictureCoordinate, 3>> CornersOf(const Piece& piece)
  {
    std::vector<std::array<PictureCoordinate, 3>> corners;
    for (const Triangle& t : piece.triangles)
    {
      corners.push_back({ PlaceInPhotograph(piece.positions[t[0]]),
        PlaceInPhotograph(piece.positions[t[1]]), PlaceInPhotograph(piece.positions[t[2]]) });
    }
    return corners;
  }

  Picture Taken;
  PicturesInMemory Source;
  std::vector<std::uint8_t> Encoded;
  TextureSet How;
};

// distance: relative to that at which everything is visible. aside: the distance of the picture's
// middle from the model's, towards its ring.
TiledScene LookFrom(
  const std::string& name, double distance, double aside, const Photograph& photograph)
{
  TiledScene made{ name, 400, 400, {}, {} };
  kdstream::testing::MemoryServer server(kdstream::testing::MakeTorus(200, 80), 1000, 2);
  server.AddTiles(128); // so that parts tell corners
  SessionOptions options;
  options.detail = DetailMode::Full;
  ViewerSession session(options);
  session.Resize({ made.width, made.height, 1 });
  if (!session.SelectModel("torus"))
  {
    throw std::runtime_error("the torus cannot be selected");
  }
  server.Serve(session);
  session.EnterFullScreen();
  server.Serve(session);
  made.scene = session.Scene();
  const Vec3 away = (made.scene.eye - made.scene.focal) * distance;
  made.scene.focal = made.scene.focal + made.scene.up * aside;
  made.scene.eye = made.scene.focal + away;
  auto tiles = std::make_shared<TileList>(), whole = std::make_shared<TileList>();
  for (const TexturedPiece& painted : *made.scene.tiles)
  {
    const Piece piece = OriginalPiece(server, painted.piece);
    tiles->push_back({ painted.piece, photograph.TileOf(piece) });
    whole->push_back({ painted.piece, photograph.WholeOf(piece) });
  }
  if (tiles->empty())
  {
    throw std::runtime_error("nothing is painted");
  }
  made.scene.tiles = tiles;
  made.whole = whole;
  return made;
}

}

std::vector<TiledScene> MakeTiledScenes()
{
  const Photograph photograph;
  // Some 0.6, 2.5 and 10 texels a pixel.
  return { LookFrom("TilesNear", 0.3, 1, photograph), LookFrom("TilesHere", 1, 0, photograph),
    LookFrom("TilesFar", 4, 0, photograph) };
}

Result<std::vector<std::uint8_t>> TexelsOf(const TextureTile& tile)
{
  const Result<Picture> picture = DecodePicture(tile.image);
  KDSTREAM_TRY(picture);
  std::vector<std::uint8_t> texels;
  for (std::size_t i = 0; i < picture->texels.size(); i += picture->components)
  {
    texels.insert(
      texels.end(), { picture->texels[i], picture->texels[i + 1], picture->texels[i + 2] });
  }
  return texels;
}

}
