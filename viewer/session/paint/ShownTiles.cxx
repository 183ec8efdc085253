// SPDX-License-Identifier: BSD-3-Clause
// The tiles of texture that paint what is shown: see ShownTiles.h.
#include "viewer/session/paint/ShownTiles.h"

#include "viewer/session/SessionTypes.h"
#include "viewer/session/ViewRefinement.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace kdstream
{
namespace
{

constexpr double softPoints = 1.5; // of the screen between neighbouring vertices

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
  , Here(std::make_shared<const TileMap>())
{
}

void ShownTiles::Reset(const ModelDescription& model)
{
  *this = ShownTiles(this->Limit);
  this->Depths = model.depths;
  this->Spacing = VertexSpacing(model.box, static_cast<double>(model.vertices));
  if (model.textures)
  {
    // What a server claims is a guess at most.
    const std::uint64_t partitions = std::max<std::uint64_t>(model.partitions, 1);
    const auto each = [partitions](std::uint64_t all)
    { return std::clamp<std::uint64_t>(all / partitions, 1, protocol::maximumBlobBytes); };
    this->Expected.bytes = static_cast<std::size_t>(each(model.textures->bytes));
    this->Expected.picture = 4 * static_cast<std::size_t>(each(model.textures->texels));
  }
}

void ShownTiles::SetLimit(std::size_t bytes)
{
  this->Limit = bytes;
  this->Evict();
}

std::size_t ShownTiles::PictureBytes() const
{
  std::size_t bytes = 0;
  for (const auto& [piece, tile] : *this->Here)
  {
    bytes += PictureBytesOf(*tile);
  }
  return bytes;
}

void ShownTiles::Follow(
  const DrawnSurface& surface, const Camera& camera, const std::set<NodeId>& tapped)
{
  if (!this->AreThere())
  {
    return;
  }
  std::vector<std::pair<double, PieceId>> wanted; // by how far from the middle of the screen
  for (const DrawnSurface::Part& part : surface.Parts())
  {
    const PieceId piece = part.part->piece;
    if (!piece.resolution.IsOriginal() || part.part->surface.triangles.empty())
    {
      continue;
    }
    const Box& box = part.part->Bounds();
    const bool isTapped = tapped.count(piece.node) > 0;
    if (camera.MaySee(box) && (isTapped || IsSoft(box, camera, this->Spacing)))
    {
      wanted.emplace_back(isTapped ? 0 : camera.Eccentricity(box.lo * 0.5 + box.hi * 0.5), piece);
    }
  }
  std::sort(wanted.begin(), wanted.end());
  ++this->Looks;
  this->Wanted.clear();
  this->Lacking.clear();
  std::size_t room = this->Limit;
  for (const auto& [eccentricity, piece] : wanted)
  {
    const auto here = this->Here->find(piece);
    const bool isHere = here != this->Here->end();
    const std::size_t bytes = isHere ? PictureBytesOf(*here->second) : this->Expected.picture;
    if (bytes > room)
    {
      break;
    }
    room -= bytes;
    this->Wanted.push_back(piece);
    const auto blob = protocol::BlobId::Texture(BlobOfPiece(piece, this->Depths).number);
    if (isHere)
    {
      this->LastWanted[piece] = this->Looks;
    }
    else if (this->Failed.count(blob) == 0)
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
  auto tile = DecodeTextureTile(bytes, piece->triangles);
  KDSTREAM_TRY(tile);
  if (PictureBytesOf(*tile) > this->Limit)
  {
    this->Fail(blob); // no error: the colours of the vertices stay
    return {};
  }
  auto tiles = std::make_shared<TileMap>(*this->Here);
  (*tiles)[piece->id] = std::make_shared<const TextureTile>(std::move(*tile));
  this->Here = std::move(tiles);
  this->LastWanted[piece->id] = this->Looks;
  this->Evict();
  return {};
}

// Those that were wanted longest ago go first; those that are wanted now only where they do not
// fit.
void ShownTiles::Evict()
{
  std::size_t pictures = this->PictureBytes();
  if (pictures > this->Limit)
  {
    auto tiles = std::make_shared<TileMap>(*this->Here);
    while (pictures > this->Limit)
    {
      const auto oldest = std::min_element(this->LastWanted.begin(), this->LastWanted.end(),
        [](const auto& a, const auto& b) { return a.second < b.second; });
      const auto tile = tiles->find(oldest->first);
      pictures -= PictureBytesOf(*tile->second);
      tiles->erase(tile);
      this->LastWanted.erase(oldest);
    }
    this->Here = std::move(tiles);
  }
  this->Held = 0;
  for (const auto& [piece, tile] : *this->Here)
  {
    this->Held += BytesOf(*tile);
  }
}

}
