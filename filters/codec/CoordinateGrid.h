// SPDX-License-Identifier: BSD-3-Clause
// How coordinates are kept: on the one cubic grid of a model, or exactly.
#pragma once

#include "filters/core/Types.h"

#include <array>
#include <cstdint>

namespace kdstream
{

struct CoordinateGrid
{
  // Bits an axis of the grid (8-24), or 0: lossless, the raw values of `scalarType`.
  std::uint8_t bits = 20;
  ScalarType scalarType = ScalarType::Float32;
  Vec3 origin{}; // of grid point (0, 0, 0), model units; (0, 0, 0) in lossless
  double step = 1;

  bool operator==(const CoordinateGrid&) const = default;
  bool Lossless() const { return this->bits == 0; }
  // The grid over `box`: origin at its lower corner, step = longest side / (2^bits - 1), 1 for zero
  // extent.
  static CoordinateGrid Over(const Box& box, std::uint8_t bits, ScalarType scalarType);
  static CoordinateGrid Exact(ScalarType scalarType);

  // Nearest grid point, clamped to the grid. REQUIRES: !Lossless().
  std::array<std::uint32_t, 3> Quantize(const Vec3& point) const;
  Vec3 At(const std::array<std::uint32_t, 3>& gridPoint) const;
  // What a piece holds of `point` after encoding and decoding.
  Vec3 Snap(const Vec3& point) const;
};

}
