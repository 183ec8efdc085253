// SPDX-License-Identifier: BSD-3-Clause
// Colours, and linear light: sums and means of colours are computed in linear light; otherwise
// edges between dark and bright would become darker.
#pragma once

#include <array>
#include <cstdint>

namespace kdstream
{

using Color = std::array<double, 4>; // red, green, blue, alpha: 0-1

// Converts sRGB, the colour space of pictures and vertex colours, to linear light, in which colours
// are added, and back. 0-1.
double ToLinear(double value);
double FromLinear(double value);

// ToLinear(byte / 255) for every byte. Rounded to multiples of 2^-40, so that the table is the same
// on every machine, however its `pow` rounds.
const std::array<double, 256>& LinearOfBytes();

// The same as integers, in units of 2^-24: sums of integers do not depend on the order.
inline constexpr std::uint32_t wholeLight = std::uint32_t{ 1 } << 24;
const std::array<std::uint32_t, 256>& WholeLightOfBytes();

// 255 × FromLinear(value), rounded to the nearest byte. NaN becomes 0.
std::uint8_t ByteOfLinear(double value);

}
