// Smooth noise, the same for the same seed.
#pragma once

#include <cmath>
#include <cstdint>

namespace kdstream::generate
{

// -1 to 1 at whole coordinates, scattered (the finalizer of MurmurHash3, by A. Appleby).
inline double NoiseAt(std::int64_t x, std::int64_t y, std::uint64_t seed)
{
  std::uint64_t h = seed + 0x9E3779B97F4A7C15u * static_cast<std::uint64_t>(x) +
                    0xC2B2AE3D27D4EB4Fu * static_cast<std::uint64_t>(y);
  h = (h ^ (h >> 33)) * 0xFF51AFD7ED558CCDu;
  h = (h ^ (h >> 33)) * 0xC4CEB9FE1A85EC53u;
  h ^= h >> 33;
  return static_cast<double>(h >> 11) * 0x1p-52 - 1.0;
}

// Between them smooth. It comes back after `period` in x, a whole number.
inline double SmoothNoise(double x, double y, std::int64_t period, std::uint64_t seed)
{
  const double left = std::floor(x), low = std::floor(y);
  const auto ease = [](double t) { return t * t * (3.0 - 2.0 * t); };
  const double right = ease(x - left), up = ease(y - low);
  const auto at = [&](std::int64_t dx, std::int64_t dy)
  {
    const std::int64_t column = static_cast<std::int64_t>(left) + dx;
    return NoiseAt((column % period + period) % period, static_cast<std::int64_t>(low) + dy, seed);
  };
  const double below = at(0, 0) + right * (at(1, 0) - at(0, 0));
  const double above = at(0, 1) + right * (at(1, 1) - at(0, 1));
  return below + up * (above - below);
}

}
