// SPDX-License-Identifier: BSD-3-Clause
// A textured model: with tiles, as in a store, and with its whole photograph as one texture. It is
// shown as the original, from near and from far, and in several resolutions. For DrawWithVtk and
// TestGlesTiles.
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
  ViewerScene scene;                     // textured by tiles
  std::shared_ptr<const TileList> whole; // the same textured by the whole photograph
  // Textures that are red, green or blue for each resolution; null if the scene has only one.
  std::shared_ptr<const TileList> resolutions;
};

// Makes the scenes that show the original.
std::vector<TiledScene> MakeTiledScenes();
// Makes a scene with two levels and the original side by side; the levels' tiles are made as a
// build makes them.
TiledScene MakeSceneOfLevels();

// The texels of a tile: red, green and blue bytes, with the top row first. Errors: those of
// decoding.
Result<std::vector<std::uint8_t>> TexelsOf(const TextureTile& tile);

// The pictures that DrawWithVtk writes of each scene, in front of black: with tiles, with the whole
// photograph, and in the colours of the resolutions.
inline constexpr const char* tiledSuffix = ".vtk.tiled.png";
inline constexpr const char* wholeSuffix = ".vtk.whole.png";
inline constexpr const char* resolutionsSuffix = ".vtk.resolutions.png";

}
