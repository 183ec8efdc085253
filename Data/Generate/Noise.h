// SPDX-License-Identifier: BSD-3-Clause
// Smooth noise that is the same for the same seed.
#pragma once

#include "Data/Generate/Hash.h"

#include <cmath>
#include <cstdint>

namespace kdstream::generate
{

// Converts a hash to a number from -1 to 1.
constexpr double NoiseOf(std::uint64_t scattered)
{
  return static_cast<double>(scattered >> 11) * 0x1p-52 - 1.0;
}

// The noise at whole coordinates: a random number from -1 to 1.
inline double NoiseAt(std::int64_t x, std::int64_t y, std::uint64_t seed)
{
  return NoiseOf(Hash(seed + 0x9E3779B97F4A7C15u * static_cast<std::uint64_t>(x) +
                      0xC2B2AE3D27D4EB4Fu * static_cast<std::uint64_t>(y)));
}

// The share of the way from one whole coordinate to the next, for t from 0 to 1. It is flat at both
// ends, so that the noise has no corners.
constexpr double Ease(double t)
{
  return t * t * (3.0 - 2.0 * t);
}

// The noise at any coordinates: smooth between whole ones. In x it repeats after `period`, a whole
// number.
inline double SmoothNoise(double x, double y, std::int64_t period, std::uint64_t seed)
{
  const double left = std::floor(x), low = std::floor(y);
  const double right = Ease(x - left), up = Ease(y - low);
  const auto at = [&](std::int64_t dx, std::int64_t dy)
  {
    const std::int64_t column = static_cast<std::int64_t>(left) + dx;
    return NoiseAt((column % period + period) % period, static_cast<std::int64_t>(low) + dy, seed);
  };
  const double below = at(0, 0) + right * (at(1, 0) - at(0, 0));
  const double above = at(0, 1) + right * (at(1, 1) - at(0, 1));
  return below + up * (above - below);
}

// The same in three dimensions, without a period.
inline double SmoothNoise(double x, double y, double z, std::uint64_t seed)
{
  const double near = std::floor(z);
  const auto slice = [&](std::int64_t dz)
  {
    const std::uint64_t layer =
      seed + 0x165667B19E3779F9u * static_cast<std::uint64_t>(static_cast<std::int64_t>(near) + dz);
    const double left = std::floor(x), low = std::floor(y);
    const double right = Ease(x - left), up = Ease(y - low);
    const auto column = static_cast<std::int64_t>(left), row = static_cast<std::int64_t>(low);
    const double a = NoiseAt(column, row, layer), b = NoiseAt(column + 1, row, layer);
    const double c = NoiseAt(column, row + 1, layer), d = NoiseAt(column + 1, row + 1, layer);
    const double below = a + right * (b - a), above = c + right * (d - c);
    return below + up * (above - below);
  };
  const double front = slice(0);
  return front + Ease(z - near) * (slice(1) - front);
}

}
