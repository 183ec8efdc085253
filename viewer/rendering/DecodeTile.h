// SPDX-License-Identifier: BSD-3-Clause
// Decodes the picture of a texture tile: a TileDecoder for scenes. Including this requires
// filters/texture; the scenes themselves do not need it. Step "render" of the pipeline picture.
#pragma once

#include "filters/texture/Picture.h"
#include "viewer/rendering/SurfaceScene.h"

#include <utility>

namespace kdstream
{

// Errors: those of DecodePicture; InvalidInput if the picture's size differs from the tile's.
inline Result<TilePicture> DecodeTile(const TextureTile& tile)
{
  auto picture = DecodePicture(tile.image, std::uint64_t{ tile.width } * tile.height);
  KDSTREAM_TRY(picture);
  if (picture->width != tile.width || picture->height != tile.height)
  {
    return Error{ ErrorCode::InvalidInput,
      "its image does not have the size that the tile states" };
  }
  TilePicture colors{ tile.width, tile.height, {} };
  if (picture->components == 3)
  {
    colors.texels = std::move(picture->texels);
    return colors;
  }
  // Drops alpha, and repeats grey three times.
  const std::size_t count = picture->width * picture->height;
  colors.texels.reserve(3 * count);
  for (std::size_t i = 0; i < count; ++i)
  {
    const std::uint8_t* texel = picture->texels.data() + i * picture->components;
    const bool isGrey = picture->components < 3;
    colors.texels.insert(
      colors.texels.end(), { texel[0], texel[isGrey ? 0 : 1], texel[isGrey ? 0 : 2] });
  }
  return colors;
}

}
