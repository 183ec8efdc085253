// SPDX-License-Identifier: BSD-3-Clause
// The colours of partitions and resolutions: see Palette.h.
#include "viewer/session/appearance/Palette.h"

#include <algorithm>
#include <cmath>

namespace kdstream
{
namespace
{

// The multiples of this spread evenly over the circle of hues, however many there are.
constexpr double goldenStep = 0.61803398874989485;

// hue: turns; its whole part is ignored. saturation, value: 0-1.
Color FromHue(double hue, double saturation, double value)
{
  const double turn = hue - std::floor(hue);
  Color color{};
  for (std::size_t k = 0; k < 3; ++k)
  {
    // How far the hue is from this primary, in sixths of the circle, 0 … 3.
    const double away = std::abs(turn * 6.0 - 2.0 * static_cast<double>(k));
    const double distance = std::min(away, 6.0 - away);
    const double purity = std::clamp(2.0 - distance, 0.0, 1.0);
    color[k] =
      static_cast<std::uint8_t>(std::lround(255.0 * value * (1.0 - saturation * (1.0 - purity))));
  }
  return color;
}

}

Color PartitionColor(std::uint32_t partition)
{
  return FromHue(0.08 + goldenStep * partition, partition % 2 == 0 ? 0.45 : 0.6, 0.88);
}

Color ResolutionColor(Resolution resolution)
{
  if (resolution.IsOriginal())
  {
    return FromHue(0.11, 0.6, 0.93);
  }
  return FromHue(0.58 + goldenStep * resolution.Depth(), 0.4, 0.82);
}

}
