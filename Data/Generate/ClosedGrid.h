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
// the point must not depend on `around`; `around` comes back at 1 to where it was at 0. The cross
// product of the direction of growing `along` and that of growing `around` must point outwards; so
// do the triangles then.
using ColoredSurface = std::function<ColoredPoint(double along, double around)>;

// Two poles and between them `rings` circles of `columns` points.
struct ClosedGrid
{
  std::uint64_t rings = 0, columns = 0;

  // A grid of about this number of vertices, with this number of columns in a ring. Errors:
  // InvalidArgument for fewer than 3 rings of 3 columns, or more than 2^32 vertices.
  static Result<ClosedGrid> Of(std::uint64_t vertices, double columnsPerRing);

  std::uint64_t Vertices() const { return this->rings * this->columns + 2; }
  std::uint64_t Triangles() const { return 2 * this->rings * this->columns; }
};

// As a binary little-endian PLY file: float x, y, z, uchar red, green, blue. Closed and
// consistently oriented. O(vertices) time, memory of a block of the file. Errors: InputOutput.
Status WritePly(
  const ClosedGrid& grid, const ColoredSurface& surface, const std::filesystem::path& file);

}
