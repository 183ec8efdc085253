// SPDX-License-Identifier: BSD-3-Clause
// The picture of a tile of texture: see DecodeTile.h.
#include "viewer/desktop/DecodeTile.h"

#include "filters/texture/Picture.h"

#include <utility>

namespace kdstream
{
namespace
{

// Without alpha, and grey as three times the same.
std::vector<std::uint8_t> OnlyColors(Picture picture)
{
  if (picture.components == 3)
  {
    return std::move(picture.texels);
  }
  const std::size_t count = picture.width * picture.height;
  std::vector<std::uint8_t> colors;
  colors.reserve(3 * count);
  for (std::size_t i = 0; i < count; ++i)
  {
    const std::uint8_t* texel = picture.texels.data() + i * picture.components;
    const bool isGrey = picture.components < 3;
    colors.insert(colors.end(), { texel[0], texel[isGrey ? 0 : 1], texel[isGrey ? 0 : 2] });
  }
  return colors;
}

}

Result<TilePicture> DecodeTile(const TextureTile& tile)
{
  auto picture = DecodePicture(tile.image, std::uint64_t{ tile.width } * tile.height);
  KDSTREAM_TRY(picture);
  if (picture->width != tile.width || picture->height != tile.height)
  {
    return Error{ ErrorCode::InvalidInput, "its picture has another size" };
  }
  return TilePicture{ tile.width, tile.height, OnlyColors(std::move(*picture)) };
}

}
