// SPDX-License-Identifier: BSD-3-Clause
// A closed surface of any size, written as a stream: nothing of it is held.
#pragma once

#include "filters/core/Result.h"
#include "filters/core/Types.h"

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>

namespace kdstream::generate
{

struct ColoredPoint
{
  Vec3 position;
  std::array<std::uint8_t, 3> color; // red, green, blue; sRGB
};

// Where the surface is at (along, around), both 0-1. `along` runs from one pole to the other, where
// the point must not depend on `around`; `around` comes back at 1 to where it was at 0.
// Counter-clockwise triangles of growing `along` and `around` face outwards where the one's
// direction times the other's does.
using ColoredSurface = std::function<ColoredPoint(double along, double around)>;

// Two poles and between them `rings` circles of `columns` points.
struct ClosedGrid
{
  std::uint64_t rings = 0, columns = 0;

  // With about so many vertices and so many columns a ring. Errors: InvalidArgument where that is
  // fewer than 3 rings of 3 columns, or more than 2^32 vertices.
  static Result<ClosedGrid> Of(std::uint64_t vertices, double columnsPerRing);

  std::uint64_t Vertices() const { return this->rings * this->columns + 2; }
  std::uint64_t Triangles() const { return 2 * this->rings * this->columns; }
};

// As a binary little-endian PLY file: float x, y, z, uchar red, green, blue. Closed and
// consistently oriented. O(vertices) time, memory of a block of the file. Errors: InputOutput.
Status WritePly(
  const ClosedGrid& grid, const ColoredSurface& surface, const std::filesystem::path& file);

}
