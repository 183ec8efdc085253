// SPDX-License-Identifier: BSD-3-Clause
// A textured model, completely shown as the original: with tiles, as in a store, and with the whole
// picture. From near and from far; for DrawWithVtk and TestGlesTiles.
#pragma once

#include "filters/core/Result.h"
#include "viewer/session/SessionTypes.h"

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace kdstream::test
{

struct TiledScene
{
  std::string name;
  int width, height;
  ViewerScene scene;                     // painted by tiles
  std::shared_ptr<const TileList> whole; // what paints it by the whole picture
};

std::vector<TiledScene> MakeTiledScenes();

// Of a tile's image: red, green and blue bytes, rows from the top down. Errors: of decoding.
Result<std::vector<std::uint8_t>> TexelsOf(const TextureTile& tile);

// What DrawWithVtk writes for each scene, before black: drawn by tiles, and by the whole picture.
inline constexpr const char* tiledSuffix = ".vtk.tiled.png";
inline constexpr const char* wholeSuffix = ".vtk.whole.png";

}
