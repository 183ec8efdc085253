// SPDX-License-Identifier: BSD-3-Clause
// Models textured by a photograph, as tiles and as a whole: see TiledScenes.h.
#include "viewer/mobile/Testing/TiledScenes.h"

#include "filters/codec/PieceCodec.h"
#include "filters/core/drawing/PartNormals.h"
#include "filters/core/drawing/SurfaceParts.h"
#include "filters/core/tree/PieceDepth.h"
#include "filters/texture/MakeTile.h"
#include "filters/texture/WritePicture.h"
#include "filters/texture/levels/LevelTile.h"
#include "viewer/session/Testing/MemoryServer.h"
#include "viewer/session/ViewerSession.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>

namespace kdstream::test
{
namespace
{

constexpr std::uint32_t side = 1024; // of the photograph, in texels

// 1 between 0 and `length`, 0 outside. Each edge is a ramp of four texels, as if blurred by a lens.
double Within(double at, double length)
{
  return std::clamp(at / 4 + 0.5, 0.0, 1.0) - std::clamp((at - length) / 4 + 0.5, 0.0, 1.0);
}

// Makes a picture like a photograph: waves down to a length of `least` texels, fainter the shorter
// they are; and optionally marks like letters, with slightly soft edges.
Picture MakePhotograph(double least, bool withScript)
{
  Picture picture{ side, side, 3, {} };
  for (std::uint32_t y = 0; y < side; ++y)
  {
    for (std::uint32_t x = 0; x < side; ++x)
    {
      double light = 130;
      for (double length = 200, angle = 0.3; length > least; length /= 2.3, angle += 1.9)
      {
        light += 0.25 * length * std::sin((x * std::cos(angle) + y * std::sin(angle)) / length * 6);
      }
      const double across = std::fmod(x + 24 * std::floor(y / 40.0), 120), down = y % 40;
      light -= withScript ? 60 * Within(across - 12, 24) * Within(down - 12, 8) : 0;
      for (const double share : { 1.0, 0.9, 0.75 })
      {
        picture.texels.push_back(static_cast<std::uint8_t>(std::clamp(share * light, 0.0, 255.0)));
      }
    }
  }
  return picture;
}

// The place in the photograph that shows a point, if it was taken from the model's front; v is
// downwards.
PictureCoordinate PlaceInPhotograph(const Vec3& p)
{
  return { static_cast<float>((p[0] + 1.5) / 3),
    static_cast<float>((1.5 - p[1] - 0.1 * p[2]) / 3) };
}

Piece PieceOf(kdstream::testing::MemoryServer& server, PieceId id)
{
  auto piece =
    DecodePiece(server.Blob(BlobOfPiece(id, server.Description().depths)), id, server.Codec());
  if (!piece)
  {
    throw std::runtime_error(piece.GetError().message);
  }
  return std::move(*piece);
}

// Textures made from the photograph: tiles as a lossless build makes them, or all of it.
class Photograph
{
public:
  explicit Photograph(double least = 4, bool withScript = true)
    : Taken(MakePhotograph(least, withScript))
    , Source({ this->Taken })
    , Encoded(EncodePicture(this->Taken, PictureType::Png))
  {
    TexturedMaterial material;
    material.picture = 0;
    this->How = { { material }, 1 };
  }

  std::shared_ptr<const TextureTile> TileOf(const Piece& piece) const
  {
    TexturedTriangles textured{ piece.triangles, this->CornersOf(piece), {} };
    textured.materialOf.assign(piece.triangles.size(), 0);
    const auto made = MakeTile(textured, this->How, this->Source, { 0, longestTileSide });
    if (!made)
    {
      throw std::runtime_error(made.GetError().message);
    }
    auto tile = DecodeTextureTile(
      EncodeTextureTile(made->tile, piece.triangles), piece.triangles, piece.positions);
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

ViewerScene OriginalOf(kdstream::testing::MemoryServer& server, int width, int height)
{
  SessionOptions options;
  options.detail = DetailMode::Full;
  ViewerSession session(options);
  session.Resize({ width, height, 1 });
  if (!session.SelectModel("torus"))
  {
    throw std::runtime_error("the torus cannot be selected");
  }
  server.Serve(session);
  session.EnterFullScreen();
  server.Serve(session);
  return session.Scene();
}

// distance: relative to the distance at which everything is visible. aside: how far the middle of
// the picture is from the middle of the model, towards its ring.
TiledScene LookFrom(
  const std::string& name, double distance, double aside, const Photograph& photograph)
{
  TiledScene made{ name, 400, 400, {}, {}, {} };
  kdstream::testing::MemoryServer server(kdstream::testing::MakeTorus(200, 80), 1000, 2);
  server.AddTiles(128); // so that parts have texture corners
  made.scene = OriginalOf(server, made.width, made.height);
  const Vec3 away = (made.scene.eye - made.scene.focal) * distance;
  made.scene.focal = made.scene.focal + made.scene.up * aside;
  made.scene.eye = made.scene.focal + away;
  auto tiles = std::make_shared<TileList>(), whole = std::make_shared<TileList>();
  for (const TexturedPiece& textured : *made.scene.tiles)
  {
    const Piece piece = PieceOf(server, textured.piece);
    tiles->push_back({ textured.piece, photograph.TileOf(piece) });
    whole->push_back({ textured.piece, photograph.WholeOf(piece) });
  }
  if (tiles->empty())
  {
    throw std::runtime_error("nothing is painted");
  }
  made.scene.tiles = tiles;
  made.whole = whole;
  return made;
}

using TiledPieces = std::map<PieceId, FinerTile>;

// The level's piece, with a tile that is made from the tiles of the next finer resolution.
FinerTile LevelPieceOf(
  kdstream::testing::MemoryServer& server, PieceId id, Resolution finer, const TiledPieces& tiled)
{
  Piece piece = PieceOf(server, id);
  FinerTiles around;
  std::vector<const FinerTile*> places;
  for (const auto& [other, tile] : tiled)
  {
    if (other.resolution == finer)
    {
      Box box;
      for (std::uint32_t v = 0; v < tile.piece.ownVertices; ++v)
      {
        box.Add(tile.piece.positions[v]);
      }
      const unsigned down = DepthOfNode(other.node) - DepthOfNode(id.node);
      around.places.push_back({ box, other.node >> down == id.node });
      places.push_back(&tile);
    }
  }
  around.read = [&places](std::size_t place) -> Result<std::shared_ptr<const FinerColors>>
  { return std::shared_ptr<const FinerColors>(std::make_shared<FinerColors>(*places[place])); };
  auto made = MakeLevelTile(piece, around, {});
  if (!made)
  {
    throw std::runtime_error(made.GetError().message);
  }
  auto tile = DecodeTextureTile(
    EncodeTextureTile(made->tile, piece.triangles), piece.triangles, piece.positions);
  if (!tile)
  {
    throw std::runtime_error(tile.GetError().message);
  }
  return { std::move(piece), std::move(*tile) };
}

// Makes the pieces of the original and of all levels down to `least`.
TiledPieces MakeTiledPieces(
  kdstream::testing::MemoryServer& server, unsigned least, const Photograph& photograph)
{
  const TreeDepths& depths = server.Description().depths;
  TiledPieces tiled;
  Resolution finer = Resolution::Original();
  const auto addAll = [&](Resolution resolution, const auto& make)
  {
    const NodeId first = NodeId{ 1 } << PieceDepth(resolution, depths);
    for (NodeId node = first; node < 2 * first; ++node)
    {
      const PieceId id{ resolution, node };
      tiled.emplace(id, make(id));
    }
    finer = resolution;
  };
  addAll(finer,
    [&](PieceId id)
    {
      Piece piece = PieceOf(server, id);
      TextureTile tile = *photograph.TileOf(piece);
      return FinerTile{ std::move(piece), std::move(tile) };
    });
  for (unsigned depth = depths.finest + 1; depth-- > least;)
  {
    addAll(
      Resolution::Level(depth), [&](PieceId id) { return LevelPieceOf(server, id, finer, tiled); });
  }
  return tiled;
}

// A tile that has one colour everywhere.
std::shared_ptr<const TextureTile> OneColor(const Piece& piece, std::size_t channel)
{
  Picture picture{ 4, 4, 3, std::vector<std::uint8_t>(48) };
  for (std::size_t i = channel; i < picture.texels.size(); i += 3)
  {
    picture.texels[i] = 255;
  }
  TextureTile tile{ 4, 4, TileImage::Png, EncodePicture(picture, PictureType::Png), {} };
  const TileCoordinate middle{ 2, 2 };
  tile.corners.assign(piece.triangles.size(), { middle, middle, middle });
  return std::make_shared<const TextureTile>(std::move(tile));
}

std::shared_ptr<const DrawnSurface> DrawCut(const Cut& cut, const TiledPieces& tiled)
{
  SurfaceParts parts;
  parts.KeepCorners(true, true);
  const Status shown = parts.GoTo(cut,
    [&tiled](PieceId id)
    {
      const auto found = tiled.find(id);
      return found == tiled.end() ? nullptr : &found->second.piece;
    });
  if (!shown)
  {
    throw std::runtime_error(shown.GetError().message);
  }
  PartNormals normals;
  normals.GoTo(parts.Parts());
  return std::make_shared<const DrawnSurface>(parts.Parts(), normals.Of());
}

}

std::vector<TiledScene> MakeTiledScenes()
{
  const Photograph photograph;
  // About 0.6, 2.5 and 10 texels per pixel.
  return { LookFrom("TilesNear", 0.3, 1, photograph), LookFrom("TilesHere", 1, 0, photograph),
    LookFrom("TilesFar", 4, 0, photograph) };
}

// From left to right: level L - 1, level L, and the original.
TiledScene MakeSceneOfLevels()
{
  const Photograph photograph(30, false);
  TiledScene made{ "TilesOfLevels", 400, 400, {}, {}, {} };
  kdstream::testing::MemoryServer server(kdstream::testing::MakeTorus(120, 48), 128, 2);
  const TreeDepths depths = server.Description().depths;
  const TiledPieces tiled = MakeTiledPieces(server, depths.finest - 1, photograph);
  Cut cut{ depths, Resolution::Level(depths.finest - 1), {} };
  for (const auto& [id, tile] : tiled)
  {
    const Box& box = server.Tree()[id.node];
    const double from = id.resolution.IsOriginal() ? 0.3 : -0.3;
    if (id.resolution != cut.base && box.lo[0] + box.hi[0] > 2 * from)
    {
      cut.active.push_back(id);
    }
  }
  made.scene = OriginalOf(server, made.width, made.height);
  made.scene.surface = DrawCut(cut, tiled);
  auto tiles = std::make_shared<TileList>(), whole = std::make_shared<TileList>(),
       resolutions = std::make_shared<TileList>();
  for (const DrawnSurface::Part& part : made.scene.surface->Parts())
  {
    const PieceId id = part.part->piece;
    const FinerTile& tile = tiled.at(id);
    const std::size_t finer =
      id.resolution.IsOriginal() ? 2U : id.resolution.Depth() - cut.base.Depth();
    tiles->push_back({ id, std::make_shared<const TextureTile>(tile.tile) });
    whole->push_back({ id, photograph.WholeOf(tile.piece) });
    resolutions->push_back({ id, OneColor(tile.piece, finer) });
  }
  made.scene.tiles = tiles;
  made.whole = whole;
  made.resolutions = resolutions;
  return made;
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
