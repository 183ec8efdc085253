// SPDX-License-Identifier: BSD-3-Clause
// The picture of a tile of texture, by the libraries that decode pictures.
#pragma once

#include "viewer/rendering/SurfaceScene.h"

namespace kdstream
{

// A TileDecoder. No memory is taken for a picture of another size than the tile tells. Errors:
// those of DecodePicture; InvalidInput where the sizes differ.
Result<TilePicture> DecodeTile(const TextureTile& tile);

}
