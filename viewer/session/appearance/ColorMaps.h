// SPDX-License-Identifier: BSD-3-Clause
// Maps numbers to colours: maps for measures, a palette for classes. Step "draw" of the pipeline
// picture.
#pragma once

#include "viewer/session/appearance/Palette.h"

#include <array>
#include <optional>
#include <string_view>

namespace kdstream
{

enum class ColorMap
{
  Viridis,  // dark to light, perceptually even, readable in grey
  Cividis,  // the same, also for people who cannot tell red from green
  Diverging // blue, grey in the middle, red: for values on both sides of a middle
};
inline constexpr std::array<ColorMap, 3> allColorMaps{ ColorMap::Viridis, ColorMap::Cividis,
  ColorMap::Diverging };

// "viridis", "cividis", "diverging".
std::string_view NameOf(ColorMap map);
std::optional<ColorMap> ParseColorMap(std::string_view name);

// REQUIRES: share is 0, the low end of the range, to 1.
Color ColorOf(ColorMap map, double share);

// The colour of a class. isLas: classes 0 to 18 are those of LAS 1.4 (ASPRS, table 17), with their
// usual colours (ground brown, vegetation green, water blue, buildings red, noise magenta); the
// standard names no colours. Otherwise each class has a hue, as partitions have.
Color ClassColor(double value, bool isLas);

}
