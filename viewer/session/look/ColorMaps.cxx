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

constexpr std::array<std::array<Color, stops>, allColorMaps.size()> tables{ {
  { Color{ 0x44, 0x01, 0x54 }, Color{ 0x48, 0x18, 0x6a }, Color{ 0x47, 0x2c, 0x7b },
    Color{ 0x42, 0x40, 0x86 }, Color{ 0x3a, 0x52, 0x8b }, Color{ 0x33, 0x63, 0x8d },
    Color{ 0x2c, 0x72, 0x8e }, Color{ 0x26, 0x82, 0x8e }, Color{ 0x20, 0x91, 0x8c },
    Color{ 0x1e, 0x9f, 0x88 }, Color{ 0x27, 0xae, 0x81 }, Color{ 0x3d, 0xbc, 0x74 },
    Color{ 0x5c, 0xc9, 0x63 }, Color{ 0x81, 0xd4, 0x4c }, Color{ 0xab, 0xdc, 0x32 },
    Color{ 0xd5, 0xe2, 0x1a }, Color{ 0xfe, 0xe7, 0x24 } },
  { Color{ 0x00, 0x22, 0x4e }, Color{ 0x00, 0x2e, 0x6a }, Color{ 0x1a, 0x38, 0x6f },
    Color{ 0x32, 0x43, 0x6d }, Color{ 0x43, 0x4e, 0x6c }, Color{ 0x53, 0x5a, 0x6d },
    Color{ 0x61, 0x65, 0x6f }, Color{ 0x6f, 0x70, 0x73 }, Color{ 0x7d, 0x7c, 0x78 },
    Color{ 0x8b, 0x87, 0x78 }, Color{ 0x9a, 0x93, 0x76 }, Color{ 0xaa, 0xa0, 0x73 },
    Color{ 0xbb, 0xad, 0x6d }, Color{ 0xcc, 0xba, 0x64 }, Color{ 0xdd, 0xc8, 0x58 },
    Color{ 0xef, 0xd7, 0x48 }, Color{ 0xfe, 0xe8, 0x38 } },
  { Color{ 0x3b, 0x4c, 0xc0 }, Color{ 0x4e, 0x68, 0xd7 }, Color{ 0x62, 0x82, 0xea },
    Color{ 0x77, 0x9a, 0xf7 }, Color{ 0x8d, 0xb0, 0xfe }, Color{ 0xa3, 0xc2, 0xff },
    Color{ 0xb8, 0xd0, 0xf9 }, Color{ 0xcc, 0xd9, 0xee }, Color{ 0xdd, 0xdd, 0xdd },
    Color{ 0xec, 0xd3, 0xc6 }, Color{ 0xf5, 0xc4, 0xad }, Color{ 0xf7, 0xb1, 0x94 },
    Color{ 0xf4, 0x9a, 0x7b }, Color{ 0xec, 0x7f, 0x63 }, Color{ 0xde, 0x61, 0x4c },
    Color{ 0xcb, 0x3e, 0x38 }, Color{ 0xb4, 0x04, 0x26 } },
} };

constexpr std::array<Color, 19> lasColors{ Color{ 0x8c, 0x8c, 0x8c }, Color{ 0xb4, 0xb4, 0xb4 },
  Color{ 0xa0, 0x70, 0x3c }, Color{ 0xa8, 0xd0, 0x60 }, Color{ 0x5c, 0xb0, 0x40 },
  Color{ 0x20, 0x78, 0x28 }, Color{ 0xe0, 0x50, 0x38 }, Color{ 0xff, 0x40, 0xff },
  Color{ 0xf0, 0xf0, 0xa0 }, Color{ 0x3c, 0x78, 0xe0 }, Color{ 0x80, 0x58, 0x90 },
  Color{ 0x60, 0x60, 0x68 }, Color{ 0xd0, 0xd0, 0xe8 }, Color{ 0xff, 0xe0, 0x40 },
  Color{ 0xf0, 0xa0, 0x20 }, Color{ 0xc8, 0x64, 0x00 }, Color{ 0x40, 0xc8, 0xc8 },
  Color{ 0xd0, 0xa0, 0x80 }, Color{ 0xc0, 0x00, 0xc0 } };

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
  const Color &a = table[below], &b = table[below + 1];
  Color color{};
  for (std::size_t k = 0; k < 3; ++k)
  {
    color[k] = static_cast<std::uint8_t>(a[k] + (b[k] - a[k]) * part + 0.5);
  }
  return color;
}

Color ClassColor(double value, bool isLas)
{
  constexpr double kinds = 65536; // so many hues are more than anybody tells apart
  const auto kind =
    static_cast<std::uint32_t>(std::clamp(value - kinds * std::floor(value / kinds), 0.0, kinds));
  return isLas && value < static_cast<double>(lasColors.size()) && value >= 0
           ? lasColors[kind]
           : PartitionColor(kind);
}

}
