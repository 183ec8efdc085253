// SPDX-License-Identifier: BSD-3-Clause
// Vectors and quaternions of the viewers: the arithmetic under step "look" of the README's picture.
//
// Only + - * / and sqrt, which every platform rounds alike: the same touches give the same camera,
// bit for bit, natively and in the browser.
#pragma once

#include "filters/core/VectorMath.h"

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

// A rotation: w + xi + yj + zk, of length 1.
struct Quaternion
{
  double w = 1, x = 0, y = 0, z = 0;
  bool operator==(const Quaternion&) const = default;

  // The shortest rotation that takes direction `from` to direction `to`; none where they are
  // opposite. REQUIRES: both of length 1.
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

  // First `other`, then this; of length 1 again whatever rounding did.
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
};

}
