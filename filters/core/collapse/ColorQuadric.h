// SPDX-License-Identifier: BSD-3-Clause
// The price of merging vertices of different colours: a quadric with colours. For EdgeCollapse and
// the makers of levels.
//
// Source: Hoppe, "New quadric metric for simplifying meshes with appearance attributes", 1999,
// without the matrix rows for attributes: the best colours follow from the position, so a quadric
// of the position remains.
#pragma once

#include "filters/core/Types.h"
#include "filters/core/collapse/Quadric.h"

#include <array>

namespace kdstream
{

// Over each triangle the colour is linear: c(x) = g·x + d, with g in the triangle's plane. For a
// vertex at x with the colour s, the cost is the sum over triangles of area × |c(x) - s|². It says
// how much the vertex's colour differs from the triangles' colours, extended to x. Coordinates are
// relative, as in Quadric.
struct ColorQuadric
{
  // The quadric of one triangle; zero if it has no area, or if numbers overflow. colors: of the
  // corners. Channels are in model units, so that a difference of 1 costs as much as a distance of
  // 1; if only ColorAt is used, in any unit.
  static ColorQuadric OfTriangle(
    const std::array<Vec3, 3>& corners, const std::array<Vec3, 3>& colors);

  void Add(const ColorQuadric& other);
  // The cost of a place, if the vertex there has the colour of ColorAt.
  Quadric Residual() const;
  // The colour with the least cost at a place. Far from the triangles it can be out of range: clamp
  // it. REQUIRES: area > 0.
  Vec3 ColorAt(const Vec3& x) const;

  Quadric squares;              // sum of area × |c(x)|²
  std::array<Vec3, 3> slopes{}; // of each channel: sum of area × g
  Vec3 constants{};             // of each channel: sum of area × d
  double area = 0;
};

}
