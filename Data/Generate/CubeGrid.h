// SPDX-License-Identifier: BSD-3-Clause
// The surface of a cube, cut into squares and these into triangles. Everything is computed from
// indices: nothing is kept in memory.
#pragma once

#include "filters/core/Result.h"

#include <array>
#include <cstdint>

namespace kdstream::generate
{

// The six sides have `side` × `side` squares each, and share the points on the cube's edges. No
// point has more than eight triangles. Points are numbered layer by layer along z. Triangles are
// numbered side of the cube by side, and row by row: neighbours in number are mostly neighbours in
// space.
struct CubeGrid
{
  std::uint64_t side = 0;

  // A grid of about this number of points (6 side² + 2). Errors: InvalidArgument for fewer than 8
  // or more than 2^32.
  static Result<CubeGrid> Of(std::uint64_t points);

  std::uint64_t Points() const { return 6 * this->side * this->side + 2; }
  std::uint64_t Triangles() const { return 12 * this->side * this->side; }

  using Place = std::array<std::uint64_t, 3>; // 0 … side, at least one of them 0 or side
  // REQUIRES: point < Points(). O(1).
  Place PlaceOf(std::uint64_t point) const;
  // The inverse of PlaceOf. O(1).
  std::uint64_t PointAt(const Place& place) const;
  // The triangle's three points, counter-clockwise as seen from outside. REQUIRES: triangle <
  // Triangles(). O(1).
  std::array<std::uint64_t, 3> CornersOf(std::uint64_t triangle) const;
};

}
