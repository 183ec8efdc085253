// SPDX-License-Identifier: BSD-3-Clause
// Two doubles side by side, to compute the same thing for both at once. Each lane holds what a
// double would, bit for bit: nothing is fused (-ffp-contract=off) or reordered. Uses the vector
// types of GCC and Clang; on machines without vector units they are two doubles. For inner loops.
#pragma once

#include "filters/core/BitCast.h"

#include <cmath>
#include <cstddef>

namespace kdstream
{

// The result of comparing lanes: in each lane all bits are set, or none.
struct LaneMask
{
  typedef long long Vector __attribute__((vector_size(16)));
  Vector bits;

  bool Any() const { return (this->bits[0] | this->bits[1]) != 0; }
  friend LaneMask operator&(LaneMask a, LaneMask b) { return { a.bits & b.bits }; }
  friend LaneMask AndNot(LaneMask a, LaneMask b) { return { a.bits & ~b.bits }; }
};

struct Lanes
{
  static constexpr std::size_t count = 2;
  typedef double Vector __attribute__((vector_size(16)));
  Vector values;

  Lanes() = default;
  Lanes(double both)
    : values{ both, both }
  {
  }
  Lanes(double first, double second)
    : values{ first, second }
  {
  }

  double operator[](std::size_t lane) const { return this->values[lane]; }

  friend Lanes operator+(Lanes a, Lanes b) { return Lanes(a.values + b.values); }
  friend Lanes operator-(Lanes a, Lanes b) { return Lanes(a.values - b.values); }
  friend Lanes operator*(Lanes a, Lanes b) { return Lanes(a.values * b.values); }
  friend Lanes operator/(Lanes a, Lanes b) { return Lanes(a.values / b.values); }
  friend Lanes operator-(Lanes a) { return Lanes(-a.values); }
  friend LaneMask operator<(Lanes a, Lanes b) { return Mask(a.values < b.values); }
  friend LaneMask operator<=(Lanes a, Lanes b) { return Mask(a.values <= b.values); }
  friend LaneMask operator>(Lanes a, Lanes b) { return Mask(a.values > b.values); }
  friend LaneMask operator>=(Lanes a, Lanes b) { return Mask(a.values >= b.values); }
  friend LaneMask operator==(Lanes a, Lanes b) { return Mask(a.values == b.values); }

private:
  explicit Lanes(Vector vector)
    : values(vector)
  {
  }
  template <class Comparison>
  static LaneMask Mask(Comparison comparison)
  {
    return { BitCast<LaneMask::Vector>(comparison) };
  }
  friend Lanes Select(LaneMask, Lanes, Lanes);
};

// Takes each lane from `yes` where the mask is set, otherwise from `no`.
inline Lanes Select(LaneMask mask, Lanes yes, Lanes no)
{
  const auto bitsOfYes = BitCast<LaneMask::Vector>(yes.values);
  const auto bitsOfNo = BitCast<LaneMask::Vector>(no.values);
  return Lanes(BitCast<Lanes::Vector>((mask.bits & bitsOfYes) | (~mask.bits & bitsOfNo)));
}

inline LaneMask And(LaneMask a, LaneMask b)
{
  return a & b;
}

inline Lanes SquareRoot(Lanes a)
{
  return Lanes(std::sqrt(a[0]), std::sqrt(a[1]));
}

// The same for one double.
inline double Select(bool mask, double yes, double no)
{
  return mask ? yes : no;
}

inline double SquareRoot(double a)
{
  return std::sqrt(a);
}

inline bool And(bool a, bool b)
{
  return a && b;
}

}
