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

// Scenes of a torus with a region, from a session, in three colourings. The same torus opened, cut
// by a section, in raking light, with a wide angle, with vertex colours, with textures, coloured by
// an array, and as clouds with and without colours and normals. The Stanford dragon, if its file
// exists.
std::vector<ComparedScene> MakeComparedScenes();

// Returns a pattern that stands for a tile's picture: red, green and blue bytes, with the top row
// first.
std::vector<std::uint8_t> PatternOf(const TextureTile& tile);

// Whether the file of the dragon exists.
bool HasDragon();

// The pictures that DrawWithVtk writes of each scene: with the usual background, in front of black,
// and in front of white.
inline constexpr const char* usualSuffix = ".vtk.png";
inline constexpr const char* blackSuffix = ".vtk.black.png";
inline constexpr const char* whiteSuffix = ".vtk.white.png";
// It also writes one with ambient occlusion, and one without the fill light.
inline constexpr const char* occlusionSuffix = ".vtk.hollow.png";
inline constexpr const char* darkerSuffix = ".vtk.darker.png";

}
