// Plane quadrics: the squared distances to a set of weighted planes, as one quadratic form (Garland
// and Heckbert, "Surface simplification using quadric error metrics", 1997). For representatives
// and deviations of levels.
#pragma once

#include "filters/core/Types.h"

#include <algorithm>
#include <cmath>

namespace kdstream
{

// Q(x) = x'Ax + 2 b'x + c, the sum of weight × squared distance over planes. With unit normals
// trace A is the sum of the weights, so Q(x) / trace A is the mean squared distance. Coordinates
// are relative to an origin that the user fixes: near the points, or digits are lost.
struct Quadric
{
  // A: xx xy xz yy yz zz.
  double a[6] = {};
  double b[3] = {};
  double c = 0;

  void Add(const Quadric& other);
  // The plane of a triangle, weighted with its area. Nothing for a triangle without area.
  void AddTriangle(const Vec3& p, const Vec3& q, const Vec3& r);
  // The plane through the edge p q at a right angle to the triangle p q r, weighted with the edge's
  // squared length: it keeps boundary edges in place. Nothing for a triangle without area.
  void AddBoundary(const Vec3& p, const Vec3& q, const Vec3& r);
  // The plane through p with the unit normal n.
  void AddPlane(const Vec3& n, const Vec3& p, double weight);

  double Trace() const { return this->a[0] + this->a[3] + this->a[5]; }
  // Never below 0.
  double At(const Vec3& x) const;
  // The point that minimises Q(x) + regularisation × trace A × |x - start|²: near `start` where the
  // planes leave a direction open. `start` itself where there are no planes or the system cannot be
  // solved.
  Vec3 Minimum(const Vec3& start, double regularisation) const;
};

// Here to be inlined: edge collapse spends its time in them.

inline void Quadric::Add(const Quadric& other)
{
  for (std::size_t k = 0; k < 6; ++k)
  {
    this->a[k] += other.a[k];
  }
  for (std::size_t k = 0; k < 3; ++k)
  {
    this->b[k] += other.b[k];
  }
  this->c += other.c;
}

inline double Quadric::At(const Vec3& x) const
{
  const double ax = this->a[0] * x[0] + this->a[1] * x[1] + this->a[2] * x[2];
  const double ay = this->a[1] * x[0] + this->a[3] * x[1] + this->a[4] * x[2];
  const double az = this->a[2] * x[0] + this->a[4] * x[1] + this->a[5] * x[2];
  const double value = ax * x[0] + ay * x[1] + az * x[2] +
                       2 * (this->b[0] * x[0] + this->b[1] * x[1] + this->b[2] * x[2]) + this->c;
  return std::max(value, 0.0);
}

inline Vec3 Quadric::Minimum(const Vec3& start, double regularisation) const
{
  // (A + eI) (x - start) = -(b + A start), by Cramer's rule.
  const double e = regularisation * this->Trace();
  if (!(e > 0))
  {
    return start;
  }
  const double xx = this->a[0] + e, xy = this->a[1], xz = this->a[2];
  const double yy = this->a[3] + e, yz = this->a[4], zz = this->a[5] + e;
  const Vec3 r{ -(this->b[0] + this->a[0] * start[0] + this->a[1] * start[1] +
                  this->a[2] * start[2]),
    -(this->b[1] + this->a[1] * start[0] + this->a[3] * start[1] + this->a[4] * start[2]),
    -(this->b[2] + this->a[2] * start[0] + this->a[4] * start[1] + this->a[5] * start[2]) };
  const double c00 = yy * zz - yz * yz, c01 = yz * xz - xy * zz, c02 = xy * yz - yy * xz;
  const double c11 = xx * zz - xz * xz, c12 = xy * xz - xx * yz, c22 = xx * yy - xy * xy;
  const double determinant = xx * c00 + xy * c01 + xz * c02;
  const Vec3 x{ start[0] + (c00 * r[0] + c01 * r[1] + c02 * r[2]) / determinant,
    start[1] + (c01 * r[0] + c11 * r[1] + c12 * r[2]) / determinant,
    start[2] + (c02 * r[0] + c12 * r[1] + c22 * r[2]) / determinant };
  const bool finite = std::isfinite(x[0]) && std::isfinite(x[1]) && std::isfinite(x[2]);
  return finite ? x : start;
}

}
