// SPDX-License-Identifier: BSD-3-Clause
// Colours, and the light that they stand for. Part of step "read" of the README's picture.
#pragma once

#include <array>
#include <cstdint>

namespace kdstream
{

using Color = std::array<double, 4>; // red, green, blue, alpha: 0-1

// sRGB, as pictures and our vertex colours are, to linear light, in which colours are added up, and
// back. 0-1.
double ToLinear(double value);
double FromLinear(double value);

// ToLinear of all bytes / 255, rounded to multiples of 2^-40: the same on every machine, whatever
// its pow rounds to.
const std::array<double, 256>& LinearOfBytes();

// The byte whose light is nearest in sRGB: of what FromLinear gives, rounded. NaN becomes 0.
std::uint8_t ByteOfLinear(double value);

}
