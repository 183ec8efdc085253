// SPDX-License-Identifier: BSD-3-Clause
// Small arithmetic on points and vectors. Do not reorder operations: every result is rounded as
// written here, and the digests of stores depend on it.
#pragma once

#include "filters/core/Types.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace kdstream
{

// Real: double, or Lanes.
template <class Real>
constexpr std::array<Real, 3> Plus(const std::array<Real, 3>& a, const std::array<Real, 3>& b)
{
  return { a[0] + b[0], a[1] + b[1], a[2] + b[2] };
}

template <class Real>
constexpr std::array<Real, 3> Minus(const std::array<Real, 3>& a, const std::array<Real, 3>& b)
{
  return { a[0] - b[0], a[1] - b[1], a[2] - b[2] };
}

template <class Real>
constexpr Real Dot(const std::array<Real, 3>& a, const std::array<Real, 3>& b)
{
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

template <class Real>
constexpr std::array<Real, 3> Cross(const std::array<Real, 3>& a, const std::array<Real, 3>& b)
{
  return { a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0] };
}

constexpr Vec3 Times(const Vec3& a, double factor)
{
  return { a[0] * factor, a[1] * factor, a[2] * factor };
}

constexpr double SquaredDistance(const Vec3& a, const Vec3& b)
{
  const Vec3 d = Minus(a, b);
  return Dot(d, d);
}

inline double Length(const Vec3& a)
{
  return std::sqrt(Dot(a, a));
}

inline bool IsFinite(const Vec3& p)
{
  return std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]);
}

// Whether a coordinate is -0.0, which equals 0.0 but has other bits.
inline bool HasNegativeZero(const Vec3& p)
{
  return std::any_of(p.begin(), p.end(), [](double x) { return x == 0 && std::signbit(x); });
}

// The same place with -0.0 replaced by 0.0, so that equal places have equal bits.
constexpr Vec3 WithPositiveZeros(const Vec3& p)
{
  return { p[0] + 0.0, p[1] + 0.0, p[2] + 0.0 };
}

// For the next two: 0 if the box is empty.
inline double LargestCoordinate(const Box& box)
{
  double largest = 0;
  for (std::size_t k = 0; k < 3 && !box.Empty(); ++k)
  {
    largest = std::max({ largest, std::abs(box.lo[k]), std::abs(box.hi[k]) });
  }
  return largest;
}

inline double LongestSideOf(const Box& box)
{
  double side = 0;
  for (std::size_t k = 0; k < 3 && !box.Empty(); ++k)
  {
    side = std::max(side, box.hi[k] - box.lo[k]);
  }
  return side;
}

}
