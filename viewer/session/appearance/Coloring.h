// SPDX-License-Identifier: BSD-3-Clause
// What a surface is coloured by: the user's choice, and the colouring of the shown model that
// follows from it. Step "draw" of the pipeline picture.
#pragma once

#include "filters/core/drawing/Surface.h"
#include "filters/model/ModelDescription.h"
#include "viewer/session/appearance/ColorMaps.h"
#include "viewer/session/appearance/Palette.h"

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace kdstream
{

struct ColorChoice
{
  SurfaceColoring coloring = SurfaceColoring::Own;
  // Only for Attribute: the array's name; the map of its numbers; the numbers at the map's ends,
  // low < high (nothing: the 2nd and the 98th percentile).
  std::string attribute{};
  ColorMap map = ColorMap::Viridis;
  std::optional<std::array<double, 2>> range{};
  bool operator==(const ColorChoice&) const = default;
};

// The colours as session files, links and pages write them: "own", "none", "partition",
// "resolution", or "by:NAME[:MAP[:LOW:HIGH]]". NAME is percent-encoded, except letters, digits,
// '-', '.' and '_'.
std::string FormatColors(const ColorChoice& choice);
// Nothing for any other text.
std::optional<ColorChoice> ParseColors(std::string_view text);
// Parses two finite numbers, the first below the second, separated by `between`.
std::optional<std::array<double, 2>> ParseRange(std::string_view text, char between);

// The colouring for renderers.
struct Coloring
{
  Coloring(SurfaceColoring byWhat = SurfaceColoring::Own)
    : kind(byWhat)
  {
  }

  SurfaceColoring kind;
  // Only for Attribute.
  std::string attribute{};
  ColorMap map = ColorMap::Viridis;
  double low = 0, high = 1; // low <= high
  bool hasClasses = false;  // values are classes, which have colours of their own and no map
  bool isLas = false;       // the classes are those of LAS
  bool operator==(const Coloring&) const = default;

  // The colour of a value of the attribute; stone for NaN.
  Color Of(double value) const;
  // Whether colours belong to points, and are interpolated between them: Own and Attribute.
  bool IsOfPoints() const
  {
    return this->kind == SurfaceColoring::Own || this->kind == SurfaceColoring::Attribute;
  }
};

// scalars: of the model. If the chosen array is not among them, the model's own colours are shown.
Coloring ColoringOf(const ColorChoice& choice, const ScalarDescriptions& scalars);

// The array whose values give the points' colours: the model's own colours, or the attribute; null
// if the surface has none, or is not coloured by points.
const Attribute* ColoredBy(const Surface& surface, const Coloring& coloring);
// REQUIRES: array is ColoredBy of a surface that has the point.
Color PointColor(const Attribute& array, const Coloring& coloring, std::size_t point);

}
