// SPDX-License-Identifier: BSD-3-Clause
#include "filters/app/TiledTextures.h"

#include "filters/texture/TextureArrays.h"
#include "filters/texture/levels/LevelTile.h"

#include <algorithm>
#include <utility>

namespace kdstream
{
namespace
{

// For the texture of a level that is one piece: small, because users see it first.
constexpr std::size_t mostBytesOfOnePiece = 40000;

}

TextureDescription TiledTextures::Describe() const
{
  TextureDescription description;
  description.format = NameOf(TileImage::Webp);
  description.lossless = this->Options.quality == 0;
  description.levels = true;
  return description;
}

Result<EncodedTexture> TiledTextures::Make(Piece& piece) const
{
  const TextureSet& textures = this->Folder->Content();
  const auto textured = TakeTextureArrays(piece, textures.materials.size());
  if (!textured)
  {
    return Error{ ErrorCode::InvalidInput, "the mesh has lost its textures" };
  }
  TileOptions options = this->Options;
  options.oneLarge = &this->LargeTile;
  const Result<MadeTile> made = MakeTile(*textured, textures, *this->Folder, options);
  KDSTREAM_TRY(made);
  {
    const std::lock_guard lock(this->Mutex);
    this->Sums.Add(made->counts);
  }
  return EncodedTexture{ EncodeTextureTile(made->tile, piece.triangles), made->counts.texels };
}

Result<EncodedTexture> TiledTextures::MakeOfLevel(
  const Piece& piece, const FinerPieces& finer) const
{
  FinerTiles tiles;
  for (const FinerPieces::Place& place : finer.places)
  {
    tiles.places.push_back({ place.box, place.below });
  }
  tiles.read = [this, &finer](std::size_t place) -> Result<std::shared_ptr<const FinerColors>>
  {
    const PieceId id = finer.places[place].id;
    if (auto kept = this->Finer.Find(id))
    {
      return kept;
    }
    Result<FinerPiece> read = finer.read(place);
    KDSTREAM_TRY(read);
    Result<TextureTile> tile =
      DecodeTextureTile(read->texture, read->piece.triangles, read->piece.positions);
    KDSTREAM_TRY(tile);
    auto made =
      std::make_shared<const FinerColors>(FinerTile{ std::move(read->piece), std::move(*tile) });
    this->Finer.Keep(id, made);
    return std::shared_ptr<const FinerColors>(std::move(made));
  };
  tiles.goesOn = finer.goesOn;
  LevelTileOptions options;
  if (this->Options.quality != 0)
  {
    options.quality = LevelQuality(this->Options.quality);
  }
  options.mostBytes = piece.id.node == 1 ? mostBytesOfOnePiece : 0;
  options.oneLarge = &this->LargeTile;
  // The data besides the image are known only after an attempt.
  constexpr int mostTries = 4;
  for (int tries = 1;; ++tries)
  {
    const Result<MadeTile> made = MakeLevelTile(piece, tiles, options);
    KDSTREAM_TRY(made);
    EncodedTexture encoded{ EncodeTextureTile(made->tile, piece.triangles), made->counts.texels };
    const std::size_t bytes = encoded.bytes.size();
    if (options.mostBytes == 0 || bytes <= mostBytesOfOnePiece || tries == mostTries)
    {
      return encoded;
    }
    options.mostBytes -= std::min(bytes - mostBytesOfOnePiece, options.mostBytes / 2);
  }
}

std::shared_ptr<const FinerColors> FinerCache::Find(PieceId id)
{
  const std::lock_guard lock(this->Mutex);
  const auto found = std::find_if(
    this->Kept.begin(), this->Kept.end(), [id](const auto& entry) { return entry.first == id; });
  if (found == this->Kept.end())
  {
    return nullptr;
  }
  std::rotate(found, found + 1, this->Kept.end());
  return this->Kept.back().second;
}

void FinerCache::Keep(PieceId id, std::shared_ptr<const FinerColors> finer)
{
  if (finer->IsLarge())
  {
    return; // another thread waits until this object is freed
  }
  const std::lock_guard lock(this->Mutex);
  this->Bytes += finer->Bytes();
  this->Kept.emplace_back(id, std::move(finer));
  while (this->Bytes > mostBytes)
  {
    this->Bytes -= this->Kept.front().second->Bytes();
    this->Kept.erase(this->Kept.begin());
  }
}

TileCounts TiledTextures::Counts() const
{
  const std::lock_guard lock(this->Mutex);
  return this->Sums;
}

std::vector<std::string> TiledTextures::Warnings() const
{
  const TileCounts counts = this->Counts();
  std::vector<std::string> warnings;
  if (counts.halved > 0)
  {
    warnings.push_back(std::to_string(counts.halved) + " of " + std::to_string(counts.tiles) +
                       " texture tiles would exceed " + std::to_string(this->Options.mostSide) +
                       " texels per side, so they are coarser than the input's textures");
  }
  if (counts.repeating > 0)
  {
    warnings.push_back(
      std::to_string(counts.repeating) +
      (counts.repeating == 1 ? " triangle repeats" : " triangles repeat") +
      " a texture more than twice along one side: painted in the texture's mean colour");
  }
  return warnings;
}

}
