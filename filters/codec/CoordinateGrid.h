// SPDX-License-Identifier: BSD-3-Clause
// How coordinates are stored: on a cubic grid, the same for the whole model, or exactly.
#pragma once

#include "filters/core/Types.h"

#include <array>
#include <cstdint>

namespace kdstream
{

struct CoordinateGrid
{
  // Bits of the grid along each axis (8-24); or 0: lossless, raw values of `scalarType`.
  std::uint8_t bits = 20;
  ScalarType scalarType = ScalarType::Float32;
  Vec3 origin{}; // place of grid point (0, 0, 0), model units; (0, 0, 0) if lossless
  double step = 1;
  // Coordinates are whole multiples of this number of steps, at least 1. More than 1 for a level
  // that does not need finer ones (SpacingFor). 1 if lossless.
  std::uint32_t spacing = 1;

  bool operator==(const CoordinateGrid&) const = default;
  bool Lossless() const { return this->bits == 0; }
  // The grid over `box`: origin at its lower corner, step = longest side / (2^bits - 1), or 1 if
  // the box is a point.
  static CoordinateGrid Over(const Box& box, std::uint8_t bits, ScalarType scalarType);
  static CoordinateGrid Exact(ScalarType scalarType);

  // The same grid, where only every `steps`-th point along each axis is used. A lossless grid does
  // not change.
  CoordinateGrid Spaced(std::uint32_t steps) const;
  // The largest spacing, in steps, for vertices whose geometric error is `geometricError` (model
  // units): it moves no coordinate by more than a quarter of the error, and leaves 256 points along
  // an axis. At least 1; always 1 if lossless. REQUIRES: spacing == 1.
  std::uint32_t SpacingFor(double geometricError) const;
  // The greatest coordinate of a grid point.
  std::uint32_t Most() const
  {
    return (((1U << this->bits) - 1) + this->spacing / 2) / this->spacing;
  }

  // The nearest grid point, clamped to the grid, in multiples of `spacing`. REQUIRES: !Lossless().
  std::array<std::uint32_t, 3> Quantize(const Vec3& point) const;
  Vec3 At(const std::array<std::uint32_t, 3>& gridPoint) const
  {
    // Multiply the integers first: that is exact.
    return { this->origin[0] + gridPoint[0] * this->spacing * this->step,
      this->origin[1] + gridPoint[1] * this->spacing * this->step,
      this->origin[2] + gridPoint[2] * this->spacing * this->step };
  }
  // `point` after encoding and decoding.
  Vec3 Snap(const Vec3& point) const;
};

}
