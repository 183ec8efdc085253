// SPDX-License-Identifier: BSD-3-Clause
#include "filters/model/Units.h"

#include <algorithm>
#include <cctype>
#include <string_view>
#include <utility>

namespace kdstream
{

std::optional<double> MetresOfUnit(const std::string& unit)
{
  std::string name = unit;
  std::transform(name.begin(), name.end(), name.begin(),
    [](unsigned char letter) { return static_cast<char>(std::tolower(letter)); });
  using Unit = std::pair<std::string_view, double>;
  for (const auto& [known, metres] :
    { Unit{ "m", 1 }, { "metre", 1 }, { "metres", 1 }, { "meter", 1 }, { "meters", 1 },
      { "mm", 1e-3 }, { "millimetre", 1e-3 }, { "millimetres", 1e-3 }, { "millimeter", 1e-3 },
      { "millimeters", 1e-3 }, { "cm", 1e-2 }, { "centimetre", 1e-2 }, { "centimetres", 1e-2 },
      { "centimeter", 1e-2 }, { "centimeters", 1e-2 }, { "dm", 1e-1 }, { "km", 1e3 },
      { "µm", 1e-6 }, { "um", 1e-6 }, { "nm", 1e-9 }, { "in", 0.0254 }, { "inch", 0.0254 },
      { "inches", 0.0254 }, { "ft", 0.3048 }, { "foot", 0.3048 }, { "feet", 0.3048 } })
  {
    if (name == known)
    {
      return metres;
    }
  }
  return {};
}

}
