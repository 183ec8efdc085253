// SPDX-License-Identifier: BSD-3-Clause
// Numbers as colours: see ColorMaps.h.
//
// Viridis: van der Walt, Smith, "A better default colormap for Matplotlib", 2015, dedicated to the
// public (CC0). Cividis: Nunez, Anderton, Renslow, "Optimizing colormaps with consideration for
// color vision deficiency", PLoS ONE 13(7), 2018 (CC BY), as Matplotlib has it. Diverging:
// Moreland, "Diverging color maps for scientific visualization", 2009, "cool to warm", which is
// free to use. Of each 17 of its entries, evenly spread; between them colours are mixed.
#include "viewer/session/look/ColorMaps.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace kdstream
{
namespace
{

constexpr std::size_t stops = 17;

constexpr std::array<std::array<std::uint32_t, stops>, allColorMaps.size()> tables{ {
  { 0x440154, 0x48186a, 0x472c7b, 0x424086, 0x3a528b, 0x33638d, 0x2c728e, 0x26828e, 0x20918c,
    0x1e9f88, 0x27ae81, 0x3dbc74, 0x5cc963, 0x81d44c, 0xabdc32, 0xd5e21a, 0xfee724 },
  { 0x00224e, 0x002e6a, 0x1a386f, 0x32436d, 0x434e6c, 0x535a6d, 0x61656f, 0x6f7073, 0x7d7c78,
    0x8b8778, 0x9a9376, 0xaaa073, 0xbbad6d, 0xccba64, 0xddc858, 0xefd748, 0xfee838 },
  { 0x3b4cc0, 0x4e68d7, 0x6282ea, 0x779af7, 0x8db0fe, 0xa3c2ff, 0xb8d0f9, 0xccd9ee, 0xdddddd,
    0xecd3c6, 0xf5c4ad, 0xf7b194, 0xf49a7b, 0xec7f63, 0xde614c, 0xcb3e38, 0xb40426 },
} };

constexpr std::size_t lasClasses = 19;

constexpr std::array<std::uint32_t, lasClasses> lasColors{ 0x8c8c8c, 0xb4b4b4, 0xa0703c, 0xa8d060,
  0x5cb040, 0x207828, 0xe05038, 0xff40ff, 0xf0f0a0, 0x3c78e0, 0x805890, 0x606068, 0xd0d0e8,
  0xffe040, 0xf0a020, 0xc86400, 0x40c8c8, 0xd0a080, 0xc000c0 };

constexpr std::array<std::string_view, lasClasses> lasNames{ "never classified", "unclassified",
  "ground", "low vegetation", "medium vegetation", "high vegetation", "building", "low noise",
  "key point", "water", "rail", "road", "overlap", "wire guard", "wire conductor", "tower",
  "wire connector", "bridge deck", "high noise" };

Color FromHex(std::uint32_t hex)
{
  return { static_cast<std::uint8_t>(hex >> 16), static_cast<std::uint8_t>(hex >> 8),
    static_cast<std::uint8_t>(hex) };
}

bool IsLasClass(double value)
{
  return value >= 0 && value < static_cast<double>(lasClasses) && value == std::floor(value);
}

}

std::string_view NameOf(ColorMap map)
{
  constexpr std::array<std::string_view, allColorMaps.size()> names{ "viridis", "cividis",
    "diverging" };
  return names[static_cast<std::size_t>(map)];
}

std::optional<ColorMap> ParseColorMap(std::string_view name)
{
  const auto found = std::find_if(
    allColorMaps.begin(), allColorMaps.end(), [name](ColorMap map) { return NameOf(map) == name; });
  return found == allColorMaps.end() ? std::nullopt : std::optional(*found);
}

Color ColorOf(ColorMap map, double share)
{
  const double place = std::clamp(share, 0.0, 1.0) * (stops - 1);
  const auto below = std::min(static_cast<std::size_t>(place), stops - 2);
  const double part = place - static_cast<double>(below);
  const auto& table = tables[static_cast<std::size_t>(map)];
  const Color a = FromHex(table[below]), b = FromHex(table[below + 1]);
  Color color{};
  for (std::size_t k = 0; k < 3; ++k)
  {
    color[k] = static_cast<std::uint8_t>(a[k] + (b[k] - a[k]) * part + 0.5);
  }
  return color;
}

Color ClassColor(double value, bool isLas)
{
  if (isLas && IsLasClass(value))
  {
    return FromHex(lasColors[static_cast<std::size_t>(value)]);
  }
  constexpr double kinds = 65536; // so many hues are more than anybody tells apart
  const double turned = value - kinds * std::floor(value / kinds);
  return PartitionColor(static_cast<std::uint32_t>(std::clamp(turned, 0.0, kinds)));
}

std::string_view LasClassName(double value)
{
  return IsLasClass(value) ? lasNames[static_cast<std::size_t>(value)] : std::string_view();
}

}
