// SPDX-License-Identifier: BSD-3-Clause
// How a scene looks, whoever draws it: lights, material, background. Step "render" of the README's
// picture.
//
// The model stands like a piece in a museum: stone before a soft gradient, lit by a key light, a
// fill light and a headlight that all follow the camera.
#pragma once

#include "filters/core/Types.h"

#include <array>

namespace kdstream
{

// Shines from `position` towards the origin, in the camera's coordinates: x to the right, y up, z
// to the viewer; everywhere in the same direction.
struct SceneLight
{
  Vec3 position;
  Vec3 color; // red, green, blue: 0-1
  double intensity;
};
inline constexpr std::array<SceneLight, 3> sceneLights{ {
  { { -0.7, 0.9, 0.8 }, { 1.0, 0.98, 0.94 }, 0.95 },
  { { 1.0, 0.1, 0.6 }, { 0.84, 0.91, 1.0 }, 0.3 },
  { { 0.0, 0.0, 1.0 }, { 1.0, 1.0, 1.0 }, 0.12 },
} };

// Phong's model. Ambient and diffuse light take the colour of the place, highlights that of stone.
struct SceneMaterial
{
  double ambient, diffuse, specular;
  double specularPower;
};
inline constexpr SceneMaterial sceneMaterial{ 0.06, 0.88, 0.14, 30.0 };

// Red, green, blue: 0-1. Whole 255ths, since VTK cuts a gradient's ends to these.
inline constexpr Vec3 backgroundBottom{ 91.0 / 255.0, 94.0 / 255.0, 99.0 / 255.0 };
inline constexpr Vec3 backgroundTop{ 33.0 / 255.0, 35.0 / 255.0, 40.0 / 255.0 };

}
