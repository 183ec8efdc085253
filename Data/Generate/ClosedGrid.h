// SPDX-License-Identifier: BSD-3-Clause
// A closed surface of any size, written as a stream: no part of it is kept in memory.
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

// The point of the surface at (along, around), both from 0 to 1. `along` runs from one pole to the
// other; at a pole the point must not depend on `around`. At `around` = 1 the point must be the
// same as at 0. The cross product of two directions, that of growing `along` and that of growing
// `around`, must point outwards; then the triangles face outwards, too.
using ColoredSurface = std::function<ColoredPoint(double along, double around)>;

// A grid of two poles, with `rings` circles of `columns` points between them.
struct ClosedGrid
{
  std::uint64_t rings = 0, columns = 0;

  // A grid of about this number of vertices, with this number of columns in a ring. Errors:
  // InvalidArgument for fewer than 3 rings of 3 columns, or more than 2^32 vertices.
  static Result<ClosedGrid> Of(std::uint64_t vertices, double columnsPerRing);

  std::uint64_t Vertices() const { return this->rings * this->columns + 2; }
  std::uint64_t Triangles() const { return 2 * this->rings * this->columns; }
};

// Writes the surface as a binary little-endian PLY file: float x, y, z, uchar red, green, blue. It
// is closed and consistently oriented. Time: O(vertices); memory: a block of the file. Errors:
// InputOutput.
Status WritePly(
  const ClosedGrid& grid, const ColoredSurface& surface, const std::filesystem::path& file);

}
