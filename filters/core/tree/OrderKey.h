// SPDX-License-Identifier: BSD-3-Clause
// The total order (coordinate, id) as two whole numbers, so that methods can bisect it and count it
// in bins without knowing what a double is.
#pragma once

#include "filters/core/BitCast.h"
#include "filters/core/Types.h"

#include <cstdint>

namespace kdstream
{

// Numbers in the order of the doubles; 0.0 and -0.0 are the same. REQUIRES: not NaN.
inline std::uint64_t OrderedBits(double value)
{
  const auto bits = BitCast<std::uint64_t>(value + 0.0);
  constexpr std::uint64_t sign = std::uint64_t{ 1 } << 63;
  return (bits & sign) != 0 ? ~bits : bits | sign;
}

inline double ValueOfOrderedBits(std::uint64_t ordered)
{
  constexpr std::uint64_t sign = std::uint64_t{ 1 } << 63;
  return BitCast<double>((ordered & sign) != 0 ? ordered & ~sign : ~ordered);
}

// The place of a vertex in the order along one axis.
struct OrderKey
{
  std::uint64_t coordinate = 0; // OrderedBits
  std::uint64_t id = 0;         // below 2^32; as wide as the other, so that files have no gaps

  bool operator==(const OrderKey&) const = default;

  // Bits, not && and ||: a branch here is taken as often as not.
  friend bool operator<(const OrderKey& a, const OrderKey& b)
  {
    return (unsigned(a.coordinate < b.coordinate) |
             (unsigned(a.coordinate == b.coordinate) & unsigned(a.id < b.id))) != 0;
  }
  friend bool operator<=(const OrderKey& a, const OrderKey& b) { return !(b < a); }
};

inline constexpr std::uint64_t greatestId = noVertex;

}
