// SPDX-License-Identifier: BSD-3-Clause
// The texture tiles for the shown surface: see ShownTiles.h.
#include "viewer/session/texture/ShownTiles.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace kdstream
{
namespace
{

constexpr double softPoints = 1.5; // points of the screen between neighbouring vertices

std::size_t PictureBytesOf(const TextureTile& tile)
{
  return std::size_t{ 4 } * tile.width * tile.height;
}

std::size_t BytesOf(const TextureTile& tile)
{
  return tile.image.size() + sizeof(tile.corners[0]) * tile.corners.size();
}

bool IsSoft(const Box& box, const Camera& camera, double spacing)
{
  const double distance = camera.DistanceTo(box);
  return distance <= 0 || camera.PointsPerUnit(distance) * spacing > softPoints;
}

}

ShownTiles::ShownTiles(std::size_t limit)
  : Limit(limit)
  , Here(std::make_shared<const TileList>())
{
}

void ShownTiles::Reset(const ModelDescription& model, std::vector<double> spacings)
{
  *this = ShownTiles(this->Limit);
  this->Depths = model.depths;
  if (!model.textures)
  {
    return;
  }
  // Clamped, because the server may claim anything.
  const auto each = [](std::uint64_t all, std::uint64_t pieces)
  {
    return static_cast<std::size_t>(std::clamp<std::uint64_t>(
      all / std::max<std::uint64_t>(pieces, 1), 1, protocol::maximumBlobBytes));
  };
  const auto add = [&](std::uint64_t bytes, std::uint64_t texels, std::uint64_t pieces)
  {
    const double spacing = spacings[this->Expected.size()];
    this->Expected.push_back(
      bytes == 0 ? ExpectedTile{}
                 : ExpectedTile{ each(bytes, pieces), 4 * each(texels, pieces), spacing });
  };
  for (const ResolutionDescription& level : model.levels)
  {
    add(model.textures->levels ? level.tileBytes : 0, level.texels, level.pieces);
  }
  add(model.textures->bytes, model.textures->texels, model.partitions);
}

const ShownTiles::ExpectedTile& ShownTiles::ExpectedOf(Resolution resolution) const
{
  return resolution.IsOriginal() ? this->Expected.back() : this->Expected[resolution.Depth()];
}

std::size_t ShownTiles::ExpectedBytes(const protocol::BlobId& blob) const
{
  return this->ExpectedOf(PieceOfBlob(blob, this->Depths).resolution).bytes;
}

void ShownTiles::SetLimit(std::size_t bytes)
{
  this->Limit = bytes;
  this->Evict();
}

std::size_t ShownTiles::PictureBytes() const
{
  std::size_t bytes = 0;
  for (const TexturedPiece& each : this->Kept)
  {
    bytes += PictureBytesOf(*each.tile);
  }
  return bytes;
}

// Moves the tile to the end, as the latest one. False if it is not kept.
bool ShownTiles::Touch(PieceId piece)
{
  const auto place = std::find_if(this->Kept.begin(), this->Kept.end(),
    [piece](const TexturedPiece& each) { return each.piece == piece; });
  if (place == this->Kept.end())
  {
    return false;
  }
  std::rotate(place, place + 1, this->Kept.end());
  return true;
}

void ShownTiles::Follow(const DrawnSurface& surface, const Camera& camera,
  const std::set<NodeId>& tapped, bool all, const std::vector<PieceId>* levels)
{
  if (!this->AreThere())
  {
    return;
  }
  std::vector<std::pair<double, PieceId>> wanted; // by distance from the middle of the screen
  for (const DrawnSurface::Part& part : surface.Parts())
  {
    const PieceId piece = part.part->piece;
    const ExpectedTile& expected = this->ExpectedOf(piece.resolution);
    const bool counts = piece.resolution.IsOriginal() || !levels ||
                        std::binary_search(levels->begin(), levels->end(), piece);
    if (!counts || expected.bytes == 0 || part.part->surface.triangles.empty())
    {
      continue;
    }
    const Box& box = part.part->Bounds();
    const bool isTapped = piece.resolution.IsOriginal() && tapped.count(piece.node) > 0;
    if (camera.MaySee(box) && (isTapped || all || IsSoft(box, camera, expected.spacing)))
    {
      wanted.emplace_back(isTapped ? 0 : camera.Eccentricity(box.lo * 0.5 + box.hi * 0.5), piece);
    }
  }
  std::sort(wanted.begin(), wanted.end());
  this->Lacking.clear();
  std::size_t room = this->Limit;
  for (const auto& [eccentricity, piece] : wanted)
  {
    const auto tile = FindTile(*this->Here, piece);
    const std::size_t bytes =
      tile ? PictureBytesOf(*tile) : this->ExpectedOf(piece.resolution).picture;
    if (bytes > room)
    {
      break;
    }
    room -= bytes;
    const protocol::BlobId blob = TextureOfPiece(piece, this->Depths);
    if (!this->Touch(piece) && this->Failed.count(blob) == 0)
    {
      this->Lacking.push_back(blob);
    }
  }
}

Status ShownTiles::Add(
  const protocol::BlobId& blob, std::span<const std::uint8_t> bytes, const Piece* piece)
{
  if (!piece)
  {
    return {};
  }
  auto tile = DecodeTextureTile(bytes, piece->triangles, piece->positions);
  KDSTREAM_TRY(tile);
  if (PictureBytesOf(*tile) > this->Limit)
  {
    this->Fail(blob); // not an error: the colours of vertices are shown instead
    return {};
  }
  if (!this->Touch(piece->id))
  {
    this->Kept.push_back({ piece->id, nullptr });
  }
  this->Kept.back().tile = std::make_shared<const TextureTile>(std::move(*tile));
  this->Evict();
  return {};
}

// Removes tiles until the rest fits: first those that were wanted longest ago, last those that are
// wanted now.
void ShownTiles::Evict()
{
  std::size_t pictures = this->PictureBytes();
  auto first = this->Kept.begin();
  for (; pictures > this->Limit; ++first)
  {
    pictures -= PictureBytesOf(*first->tile);
  }
  this->Kept.erase(this->Kept.begin(), first);
  this->Held = 0;
  for (const TexturedPiece& each : this->Kept)
  {
    this->Held += BytesOf(*each.tile);
  }
  TileList here = this->Kept;
  std::sort(here.begin(), here.end(),
    [](const TexturedPiece& a, const TexturedPiece& b) { return a.piece < b.piece; });
  this->Here = std::make_shared<const TileList>(std::move(here));
}

}
