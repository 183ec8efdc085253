// SPDX-License-Identifier: BSD-3-Clause
// What a surface is coloured by: see Coloring.h.
#include "viewer/session/appearance/Coloring.h"

#include "filters/core/Texts.h"
#include "filters/model/Json.h"
#include "filters/model/JsonWriter.h"
#include "viewer/session/appearance/SceneRules.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace kdstream
{
namespace
{

constexpr std::array<std::pair<std::string_view, SurfaceColoring>, 4> words{ {
  { "own", SurfaceColoring::Own },
  { "none", SurfaceColoring::Stone },
  { "partition", SurfaceColoring::Partition },
  { "resolution", SurfaceColoring::Resolution },
} };

constexpr std::string_view byAttribute = "by:";

// Removes and returns the text before the first `end`, and removes `end`.
std::string_view TakeUpTo(std::string_view& text, char end)
{
  const std::string_view part = text.substr(0, text.find(end));
  text.remove_prefix(std::min(part.size() + 1, text.size()));
  return part;
}

}

std::string FormatColors(const ColorChoice& choice)
{
  for (const auto& [word, coloring] : words)
  {
    if (coloring == choice.coloring)
    {
      return std::string(word);
    }
  }
  std::string text = std::string(byAttribute) + PercentEncoded(choice.attribute, "-._");
  if (choice.range || choice.map != ColorMap::Viridis)
  {
    text += ":" + std::string(NameOf(choice.map));
  }
  if (choice.range)
  {
    text += ":" + JsonNumber((*choice.range)[0]) + ":" + JsonNumber((*choice.range)[1]);
  }
  return text;
}

std::optional<std::array<double, 2>> ParseRange(std::string_view text, char between)
{
  const std::string low(TakeUpTo(text, between)), high(text);
  const auto json = ParseJson("[" + low + "," + high + "]");
  if (!json || json->Size() != 2 || !(*json)[0].IsNumber() || !(*json)[1].IsNumber())
  {
    return {};
  }
  const std::array<double, 2> range{ (*json)[0].GetDouble(), (*json)[1].GetDouble() };
  return range[0] < range[1] && std::isfinite(range[1] - range[0]) ? std::optional(range)
                                                                   : std::nullopt;
}

std::optional<ColorChoice> ParseColors(std::string_view text)
{
  for (const auto& [word, coloring] : words)
  {
    if (text == word)
    {
      return ColorChoice{ coloring };
    }
  }
  if (!text.starts_with(byAttribute))
  {
    return {};
  }
  text.remove_prefix(byAttribute.size());
  ColorChoice choice{ SurfaceColoring::Attribute };
  const auto name = PercentDecoded(TakeUpTo(text, ':'));
  const std::string_view map = TakeUpTo(text, ':');
  const auto parsed = map.empty() ? std::optional(ColorMap::Viridis) : ParseColorMap(map);
  if (!name || !IsAttributeName(*name) || !parsed)
  {
    return {};
  }
  choice.attribute = *name;
  choice.map = *parsed;
  if (!text.empty())
  {
    choice.range = ParseRange(text, ':');
    if (!choice.range)
    {
      return {};
    }
  }
  return choice;
}

Color Coloring::Of(double value) const
{
  if (std::isnan(value))
  {
    return stoneColor;
  }
  if (this->hasClasses)
  {
    return ClassColor(value, this->isLas);
  }
  const double inRange = std::clamp(value, this->low, this->high);
  return kdstream::ColorOf(
    this->map, inRange == this->low ? 0 : (inRange - this->low) / (this->high - this->low));
}

Coloring ColoringOf(const ColorChoice& choice, const ScalarDescriptions& scalars)
{
  Coloring coloring;
  if (choice.coloring != SurfaceColoring::Attribute)
  {
    coloring.kind = choice.coloring;
  }
  else if (const ScalarDescription* scalar = scalars.Find(choice.attribute))
  {
    coloring.kind = SurfaceColoring::Attribute;
    coloring.attribute = scalar->name;
    coloring.map = choice.map;
    coloring.low = choice.range ? (*choice.range)[0] : scalar->low;
    coloring.high = choice.range ? (*choice.range)[1] : scalar->high;
    coloring.hasClasses = !scalar->classes.empty() && !choice.range;
    coloring.isLas = scalar->name.find("lassification") != std::string::npos;
  }
  return coloring;
}

const Attribute* ColoredBy(const Surface& surface, const Coloring& coloring)
{
  for (const Attribute& array : surface.attributes)
  {
    const bool isIt = coloring.kind == SurfaceColoring::Own
                        ? RoleOf(array) == AttributeRole::Colors
                        : coloring.kind == SurfaceColoring::Attribute && IsScalar(array) &&
                            array.name == coloring.attribute;
    if (isIt)
    {
      return &array;
    }
  }
  return nullptr;
}

Color PointColor(const Attribute& array, const Coloring& coloring, std::size_t point)
{
  return coloring.kind == SurfaceColoring::Own ? OwnColor(array, point)
                                               : coloring.Of(array.Get(point, 0));
}

}
