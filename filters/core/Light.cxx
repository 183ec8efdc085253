// SPDX-License-Identifier: BSD-3-Clause
#include "filters/core/Light.h"

#include <algorithm>
#include <cmath>

namespace kdstream
{
namespace
{

double Rounded(double value)
{
  return std::nearbyint(value * 0x1p40) * 0x1p-40;
}

std::array<double, 256> LinearAt(double offset)
{
  std::array<double, 256> table{};
  for (std::size_t byte = 0; byte < table.size(); ++byte)
  {
    table[byte] = Rounded(ToLinear((double(byte) + offset) / 255));
  }
  return table;
}

}

double ToLinear(double value)
{
  return value <= 0.04045 ? value / 12.92 : std::pow((value + 0.055) / 1.055, 2.4);
}

double FromLinear(double value)
{
  return value <= 0.0031308 ? value * 12.92 : 1.055 * std::pow(value, 1 / 2.4) - 0.055;
}

const std::array<double, 256>& LinearOfBytes()
{
  static const std::array<double, 256> table = LinearAt(0);
  return table;
}

const std::array<std::uint32_t, 256>& WholeLightOfBytes()
{
  static const std::array<std::uint32_t, 256> table = []
  {
    std::array<std::uint32_t, 256> whole{};
    std::transform(LinearOfBytes().begin(), LinearOfBytes().end(), whole.begin(),
      [](double light) { return static_cast<std::uint32_t>(light * wholeLight + 0.5); });
    return whole;
  }();
  return table;
}

std::uint8_t ByteOfLinear(double value)
{
  static const std::array<double, 256> ends = LinearAt(0.5); // where the next byte begins
  const auto* const end = std::upper_bound(ends.begin(), ends.end() - 1, value);
  return std::isnan(value) ? 0 : static_cast<std::uint8_t>(end - ends.begin());
}

}
