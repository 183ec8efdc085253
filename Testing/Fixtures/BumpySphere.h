// SPDX-License-Identifier: BSD-3-Clause
// A sphere that the tests of both renderers draw.
#pragma once

#include "filters/core/drawing/Surface.h"

#include <cmath>
#include <cstdint>
#include <numbers>

namespace kdstream::test
{

// Depths of a tree of 8 partitions whose finest level and stitch depth are 7.
inline constexpr TreeDepths depths{ 3, 7, 7 };

// Rounds to a multiple of 2^-20, so that adding an offset of a few millions is exact.
inline double OnGrid(double x)
{
  return std::round(x * 1048576.0) / 1048576.0;
}

// A closed sphere of radius about 1 with bumps, of `rows` rings of 2 × rows quads. Its vertices are
// originals, each in the partition of its octant. If the sphere is mixed, the vertices of the lower
// half belong to two levels. ripples: the height of finer bumps.
inline Surface BumpySphere(
  std::uint32_t rows, const Vec3& offset, double ripples, bool isMixed = false)
{
  Surface surface;
  const std::uint32_t columns = 2 * rows;
  const auto add = [&](double polar, double azimuth)
  {
    const double radius = 1.0 + 0.08 * std::sin(5.0 * polar) * std::sin(6.0 * azimuth) +
                          ripples * std::sin(31.0 * polar) * std::sin(28.0 * azimuth);
    const Vec3 p{ OnGrid(radius * std::sin(polar) * std::cos(azimuth)),
      OnGrid(radius * std::cos(polar)), OnGrid(radius * std::sin(polar) * std::sin(azimuth)) };
    const auto octant = static_cast<std::uint32_t>(
      (p[0] > 0.0 ? 1 : 0) + (p[1] > 0.0 ? 2 : 0) + (p[2] > 0.0 ? 4 : 0));
    const auto index = static_cast<std::uint32_t>(surface.points.size());
    const Resolution resolution =
      !isMixed || p[1] > -0.3 ? Resolution::Original() : Resolution::Level(p[1] > -0.7 ? 7 : 3);
    surface.sources.push_back({ resolution, MakeKey(octant, index) });
    surface.points.push_back({ p[0] + offset[0], p[1] + offset[1], p[2] + offset[2] });
  };
  add(0.0, 0.0);
  for (std::uint32_t r = 1; r < rows; ++r)
  {
    for (std::uint32_t c = 0; c < columns; ++c)
    {
      add(std::numbers::pi * r / rows, 2.0 * std::numbers::pi * c / columns);
    }
  }
  add(std::numbers::pi, 0.0);
  const auto last = static_cast<VertexId>(surface.points.size() - 1);
  const auto at = [&](std::uint32_t r, std::uint32_t c)
  { return 1 + (r - 1) * columns + c % columns; };
  for (std::uint32_t c = 0; c < columns; ++c)
  {
    surface.triangles.push_back({ 0, at(1, c + 1), at(1, c) });
    for (std::uint32_t r = 1; r + 1 < rows; ++r)
    {
      surface.triangles.push_back({ at(r, c), at(r, c + 1), at(r + 1, c + 1) });
      surface.triangles.push_back({ at(r, c), at(r + 1, c + 1), at(r + 1, c) });
    }
    surface.triangles.push_back({ at(rows - 1, c), at(rows - 1, c + 1), last });
  }
  return surface;
}

}
