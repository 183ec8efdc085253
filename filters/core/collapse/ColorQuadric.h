// SPDX-License-Identifier: BSD-3-Clause
// What vertex colours cost where vertices merge: a quadric with colours. For EdgeCollapse and the
// makers of levels.
//
// Source: Hoppe, "New quadric metric for simplifying meshes with appearance attributes", 1999,
// without the attributes' rows: for any place the best colours are known at once, so that what is
// left is a quadric of only the place.
#pragma once

#include "filters/core/Types.h"
#include "filters/core/collapse/Quadric.h"

#include <array>

namespace kdstream
{

// Over each triangle a colour is linear, c(x) = g·x + d with g in the triangle's plane. For a
// vertex at x with the colour s this is the sum over triangles of area × |c(x) - s|²: how far the
// vertex is from all that the triangles say about its place. Coordinates as those of Quadric.
struct ColorQuadric
{
  // Of one triangle; nothing where it has no area, or where numbers overflow. colors: of its
  // corners, each channel in model units, so that a difference of 1 costs what a distance of 1
  // does; only for ColorAt in any unit.
  static ColorQuadric OfTriangle(
    const std::array<Vec3, 3>& corners, const std::array<Vec3, 3>& colors);

  void Add(const ColorQuadric& other);
  // What a place costs when the vertex there has the colour of ColorAt.
  Quadric Residual() const;
  // The colour that costs least at a place. Far from the triangles it may be none that there is:
  // clamp it. REQUIRES: area > 0.
  Vec3 ColorAt(const Vec3& x) const;

  Quadric squares;              // sum of area × |c(x)|²
  std::array<Vec3, 3> slopes{}; // of each channel: sum of area × g
  Vec3 constants{};             // of each channel: sum of area × d
  double area = 0;
};

}
