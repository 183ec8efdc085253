// SPDX-License-Identifier: BSD-3-Clause
#include "filters/app/TiledTextures.h"

#include "filters/texture/TextureArrays.h"

namespace kdstream
{

TextureDescription TiledTextures::Describe() const
{
  return { std::string(NameOf(TileImage::Webp)), this->Options.quality == 0 };
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
