// SPDX-License-Identifier: BSD-3-Clause
// A textured model, with tiles, as in a store, and with the whole picture: shown as the original,
// from near and from far, and in several resolutions. For DrawWithVtk and TestGlesTiles.
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
  // What paints each resolution in one of red, green and blue; null where there is only one.
  std::shared_ptr<const TileList> resolutions;
};

// Scenes of the original.
std::vector<TiledScene> MakeTiledScenes();
// The original and two levels beside each other, whose tiles are made as in a build.
TiledScene MakeSceneOfLevels();

// The texels of a tile: red, green and blue bytes, rows from the top down. Errors: of decoding.
Result<std::vector<std::uint8_t>> TexelsOf(const TextureTile& tile);

// What DrawWithVtk writes for each scene, before black: drawn by tiles, by the whole picture, and
// in the colours of resolutions.
inline constexpr const char* tiledSuffix = ".vtk.tiled.png";
inline constexpr const char* wholeSuffix = ".vtk.whole.png";
inline constexpr const char* resolutionsSuffix = ".vtk.resolutions.png";

}
