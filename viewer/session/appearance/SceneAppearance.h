// SPDX-License-Identifier: BSD-3-Clause
// The look of a scene in all renderers: lights, material, background. Step "render" of the pipeline
// picture.
//
// The model is shown like a piece in a museum: stone before a soft gradient, lit by a key light
// from the upper left and a fill light, which both follow the camera.
#pragma once

#include "filters/core/Types.h"

#include <array>

namespace kdstream
{

// A directional light: it shines from `position` towards the origin, everywhere in the same
// direction. In the camera's coordinates: x to the right, y up, z to the viewer.
struct SceneLight
{
  Vec3 position;
  Vec3 color; // red, green, blue: 0-1
  double intensity;
  bool operator==(const SceneLight&) const = default;
};
// The fill light is near the eye. So parts away from the key light become darker towards the
// outline, and their relief is visible. A fill light from the far side would light these parts
// fully, and slopes would make no difference.
inline constexpr std::array<SceneLight, 2> sceneLights{ {
  { { -0.75, 0.95, 0.75 }, { 1.0, 0.97, 0.91 }, 0.8 },
  { { 0.3, 0.2, 1.0 }, { 0.92, 0.95, 1.0 }, 0.36 },
} };

struct SceneLighting
{
  std::array<SceneLight, 2> lights = sceneLights;
  // How much lighter ridges, and how much darker furrows, are drawn than their light makes them:
  // 0-1. The full effect is reached where the surface bends by a radian within reliefShare of the
  // picture's height.
  double relief = 0;
  bool operator==(const SceneLighting&) const = default;
};
inline constexpr double reliefShare = 0.015;

// The cut face of a section: the colour of fired clay, so that it never looks like the surface,
// whatever the light.
inline constexpr std::array<unsigned char, 3> capColor{ 176, 104, 82 };

// Phong's model. Ambient and diffuse light take the surface's colour at that place; highlights take
// the colour of stone.
struct SceneMaterial
{
  double ambient, diffuse, specular;
  double specularPower;
};
inline constexpr SceneMaterial sceneMaterial{ 0.15, 0.85, 0.14, 30.0 };

// Red, green, blue: 0-1. Whole 255ths, because VTK truncates the ends of a gradient to these.
inline constexpr Vec3 backgroundBottom{ 91.0 / 255.0, 94.0 / 255.0, 99.0 / 255.0 };
inline constexpr Vec3 backgroundTop{ 33.0 / 255.0, 35.0 / 255.0, 40.0 / 255.0 };

}
