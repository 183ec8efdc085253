// SPDX-License-Identifier: BSD-3-Clause
// Decodes the pictures of texture tiles, and assembles the input's pictures from them: for
// kdstream-store extract.
#pragma once

#include "filters/codec/TextureTile.h"
#include "filters/core/Result.h"
#include "filters/protocol/BlobId.h"
#include "filters/texture/Picture.h"

#include <array>
#include <cstdint>
#include <vector>

namespace kdstream
{

// The image of a tile. Errors: Damaged, naming the blob, if the image cannot be decoded or its size
// differs from the tile's.
Result<Picture> DecodeTileImage(const protocol::BlobId& blob, const TextureTile& tile);

// Makes a picture: RGBA, grey and opaque.
Picture GreyPicture(std::size_t width, std::size_t height);

// Copies an exact tile's part of the input's picture `number` into the canvas: the texels of the
// triangles of each chart, and one more around them. REQUIRES: the tile is exact and not halved;
// the canvas is RGBA.
void PasteTile(
  std::uint32_t number, const TextureTile& tile, const Picture& picture, Picture& canvas);

// REQUIRES: the place is in the picture.
std::array<std::uint8_t, 4> TexelAt(const Picture& picture, std::int64_t x, std::int64_t y);
// Whether any texel is not opaque. REQUIRES: RGB or RGBA.
bool HasAlpha(const Picture& picture);
// Encodes the picture as a PNG, without alpha if all texels are opaque.
std::vector<std::uint8_t> PngOf(Picture picture);

}
