// SPDX-License-Identifier: BSD-3-Clause
// Raking light from the direction of a finger: low light shows reliefs and inscriptions that are
// invisible in light from the front. Below step "render" of the pipeline picture.
#pragma once

#include "viewer/session/appearance/SceneAppearance.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

namespace kdstream
{

struct LightSource
{
  // On a disc of radius 1 before the eye, x to the right, y up: in the middle light comes from the
  // eye, at the rim from the side.
  double x = -0.9, y = 0.3;
  double intensity = 1; // 0-2
  bool operator==(const LightSource&) const = default;
};

struct RakingLight
{
  LightSource lightSource{};
  std::optional<LightSource> second{};
  double relief = 0; // how much lighter ridges are, and darker furrows: 0-1
  bool operator==(const RakingLight&) const = default;

  static constexpr double mostIntensity = 2;
  static constexpr double rim = 0.997; // of the disc's radius: no light falls flatter than there
};

// The value clamped to its range; `least` for NaN.
inline double InRange(double value, double least, double most)
{
  return std::isfinite(value) ? std::clamp(value, least, most) : least;
}
inline LightSource Confined(const LightSource& lightSource)
{
  LightSource confined{ InRange(lightSource.x, -1e6, 1e6), InRange(lightSource.y, -1e6, 1e6),
    InRange(lightSource.intensity, 0, RakingLight::mostIntensity) };
  const double from = std::sqrt(confined.x * confined.x + confined.y * confined.y);
  const double shorter = from > RakingLight::rim ? RakingLight::rim / from : 1;
  confined.x *= shorter;
  confined.y *= shorter;
  return confined;
}
inline RakingLight Confined(const RakingLight& light)
{
  return { Confined(light.lightSource),
    light.second ? std::optional(Confined(*light.second)) : std::nullopt,
    InRange(light.relief, 0, 1) };
}

// The lights of a scene with this raking light; without it, the standard lights.
inline SceneLighting LightingOf(const std::optional<RakingLight>& light)
{
  SceneLighting lighting;
  if (light)
  {
    const auto put = [&](std::size_t i, const LightSource& lightSource, const Vec3& color)
    {
      const double square = lightSource.x * lightSource.x + lightSource.y * lightSource.y;
      lighting.lights[i] = { { lightSource.x, lightSource.y, std::sqrt(std::max(1 - square, 0.0)) },
        color, lightSource.intensity };
    };
    put(0, light->lightSource, sceneLights[0].color);
    put(1, light->second.value_or(LightSource{ 0, 0, 0 }), sceneLights[1].color);
    lighting.relief = light->relief;
  }
  return lighting;
}

}
