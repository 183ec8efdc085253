// SPDX-License-Identifier: BSD-3-Clause
// The scenes that both renderers draw: the same for DrawWithVtk and TestGlesAgainstVtk.
#pragma once

#include "viewer/session/SessionTypes.h"
#include "viewer/session/appearance/Coloring.h"

#include <string>
#include <vector>

namespace kdstream::test
{

struct ComparedScene
{
  std::string name;
  int width, height;
  Coloring coloring;
  ViewerScene scene;
};

// A torus with a region, from a session, in three colourings; the same opened, cut by a section, in
// raking light, with a wide angle, with vertex colours, with textures, coloured by an array, and as
// clouds with and without colours and normals; the Stanford dragon if its file exists.
std::vector<ComparedScene> MakeComparedScenes();

// What stands for the picture of a tile: red, green and blue bytes, rows from the top down.
std::vector<std::uint8_t> PatternOf(const TextureTile& tile);

// Whether the dragon is there.
bool HasDragon();

// What DrawWithVtk writes for each scene: with the usual background; with black and with white;
// without the fill light.
inline constexpr const char* usualSuffix = ".vtk.png";
inline constexpr const char* blackSuffix = ".vtk.black.png";
inline constexpr const char* whiteSuffix = ".vtk.white.png";
// With occlusion.
inline constexpr const char* occlusionSuffix = ".vtk.hollow.png";
inline constexpr const char* darkerSuffix = ".vtk.darker.png";

}
