// SPDX-License-Identifier: BSD-3-Clause
// Vectors and quaternions of the viewers: the arithmetic below step "navigate" of the pipeline
// picture.
//
// Uses only + - * / and sqrt, which every platform rounds the same. So the same touches give the
// same camera, bit for bit, natively and in the browser.
#pragma once

#include "filters/core/VectorMath.h"

#include <algorithm>
#include <cmath>

namespace kdstream
{

constexpr Vec3 operator+(const Vec3& a, const Vec3& b)
{
  return Plus(a, b);
}
constexpr Vec3 operator-(const Vec3& a, const Vec3& b)
{
  return Minus(a, b);
}
constexpr Vec3 operator*(const Vec3& a, double s)
{
  return Times(a, s);
}
// The zero vector stays as it is.
inline Vec3 Normalized(const Vec3& a)
{
  const double length = Length(a);
  return length > 0 ? a * (1 / length) : a;
}

// The distance to the nearest point of a box that is not empty; 0 within it.
inline double DistanceTo(const Box& box, const Vec3& point)
{
  Vec3 away{};
  for (std::size_t k = 0; k < 3; ++k)
  {
    away[k] = std::max({ box.lo[k] - point[k], point[k] - box.hi[k], 0.0 });
  }
  return Length(away);
}

// A rotation: w + xi + yj + zk, of length 1.
struct Quaternion
{
  double w = 1, x = 0, y = 0, z = 0;
  bool operator==(const Quaternion&) const = default;

  // The shortest rotation from direction `from` to direction `to`; none if they are opposite.
  // REQUIRES: both of length 1.
  static Quaternion Between(const Vec3& from, const Vec3& to)
  {
    const Vec3 axis = Cross(from, to);
    const double w = 1 + Dot(from, to);
    const double length = std::sqrt(w * w + Dot(axis, axis));
    if (!(length > 1e-12))
    {
      return {};
    }
    return { w / length, axis[0] / length, axis[1] / length, axis[2] / length };
  }

  // The rotation by `o` first, then by this. Normalized, so that rounding errors do not add up.
  Quaternion After(const Quaternion& o) const
  {
    const Quaternion q{ w * o.w - x * o.x - y * o.y - z * o.z,
      w * o.x + x * o.w + y * o.z - z * o.y, w * o.y - x * o.z + y * o.w + z * o.x,
      w * o.z + x * o.y - y * o.x + z * o.w };
    const double length = std::sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
    return { q.w / length, q.x / length, q.y / length, q.z / length };
  }
  Quaternion Inverse() const { return { w, -x, -y, -z }; }

  Vec3 Rotate(const Vec3& v) const
  {
    const Vec3 axis{ x, y, z };
    const Vec3 t = Cross(axis, v) * 2;
    return v + t * w + Cross(axis, t);
  }

  // The rotation that takes the axes x, y and z to these. REQUIRES: of length 1, orthogonal,
  // right-handed.
  static Quaternion OfAxes(const Vec3& x, const Vec3& y, const Vec3& z)
  {
    // Computes the largest of the four components first, because the others are divided by it.
    const double w = 1 + x[0] + y[1] + z[2], i = 1 + x[0] - y[1] - z[2], j = 1 - x[0] + y[1] - z[2],
                 k = 1 - x[0] - y[1] + z[2];
    Quaternion q;
    if (w >= i && w >= j && w >= k)
    {
      q = { w, y[2] - z[1], z[0] - x[2], x[1] - y[0] };
    }
    else if (i >= j && i >= k)
    {
      q = { y[2] - z[1], i, x[1] + y[0], z[0] + x[2] };
    }
    else if (j >= k)
    {
      q = { z[0] - x[2], x[1] + y[0], j, y[2] + z[1] };
    }
    else
    {
      q = { x[1] - y[0], z[0] + x[2], y[2] + z[1], k };
    }
    return q.After({}); // of length 1
  }
};

// A direction of length 1 at right angles to `axis`: as near to x as possible, or to z if `axis` is
// nearly along x.
inline Vec3 Across(const Vec3& axis)
{
  const bool alongX = axis[0] * axis[0] > 0.9;
  const Vec3 other = alongX ? Vec3{ 0, 0, 1 } : Vec3{ 1, 0, 0 };
  return Normalized(other - axis * Dot(other, axis));
}

// The orientation of a camera (x right, y up, view along -z) that looks from direction `view`, with
// `up` pointing upwards on the screen as far as possible. If the camera looks along `up`, x is to
// the right. REQUIRES: both of length 1.
inline Quaternion LookingFrom(const Vec3& view, const Vec3& up)
{
  const Vec3 across = Cross(up, view);
  const Vec3 right = Length(across) > 1e-6 ? Normalized(across) : Across(up);
  const Vec3 back = Normalized(view - right * Dot(view, right));
  return Quaternion::OfAxes(right, Cross(back, right), back);
}

}
