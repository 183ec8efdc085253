// SPDX-License-Identifier: BSD-3-Clause
// Directions: vectors of length 1. Do not reorder operations: as in VectorMath.h, results are
// rounded as written here.
#pragma once

#include "filters/core/VectorMath.h"

#include <optional>

namespace kdstream
{

// The vector of length 1 in the same direction. Zero for a zero vector, and for one so long or so
// short that its squared length is infinite or 0.
inline Vec3 UnitVector(const Vec3& v)
{
  const double length = Length(v);
  return length > 0 && std::isfinite(length) ? Vec3{ v[0] / length, v[1] / length, v[2] / length }
                                             : Vec3{};
}

// The same for any finite vector except zero. Divides by the largest component first, which may
// change the last bits.
inline std::optional<Vec3> ScaledUnitVector(const Vec3& v)
{
  const double largest = std::max({ std::abs(v[0]), std::abs(v[1]), std::abs(v[2]) });
  if (!IsFinite(v) || largest == 0)
  {
    return std::nullopt;
  }
  return UnitVector({ v[0] / largest, v[1] / largest, v[2] / largest });
}

}
