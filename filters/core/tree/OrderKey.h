// SPDX-License-Identifier: BSD-3-Clause
// The total order (coordinate, id) as two integers, so that algorithms can bisect it, or count keys
// in bins, without handling doubles.
#pragma once

#include "filters/core/BitCast.h"
#include "filters/core/Types.h"

#include <cstdint>

namespace kdstream
{

// Maps doubles to integers in the same order; 0.0 and -0.0 give the same integer. REQUIRES: not
// NaN.
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
  std::uint64_t id = 0;         // below 2^32; 64 bits, so that records in files have no padding

  bool operator==(const OrderKey&) const = default;

  // Bit operations instead of && and ||, because a branch here could not be predicted.
  friend bool operator<(const OrderKey& a, const OrderKey& b)
  {
    return (unsigned(a.coordinate < b.coordinate) |
             (unsigned(a.coordinate == b.coordinate) & unsigned(a.id < b.id))) != 0;
  }
  friend bool operator<=(const OrderKey& a, const OrderKey& b) { return !(b < a); }
};

inline constexpr std::uint64_t greatestId = noVertex;

}
