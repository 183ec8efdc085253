#include "filters/core/Quadric.h"

#include <algorithm>
#include <cmath>

namespace kdstream
{

void Quadric::Add(const Quadric& other)
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

void Quadric::AddTriangle(const Vec3& p, const Vec3& q, const Vec3& r)
{
  const Vec3 u{ q[0] - p[0], q[1] - p[1], q[2] - p[2] };
  const Vec3 v{ r[0] - p[0], r[1] - p[1], r[2] - p[2] };
  Vec3 n{ u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0] };
  const double length = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
  if (!(length > 0) || !std::isfinite(length))
  {
    return;
  }
  for (double& value : n)
  {
    value /= length;
  }
  this->AddPlane(n, p, length / 2);
}

void Quadric::AddPlane(const Vec3& n, const Vec3& p, double weight)
{
  const double d = -(n[0] * p[0] + n[1] * p[1] + n[2] * p[2]);
  this->a[0] += weight * n[0] * n[0];
  this->a[1] += weight * n[0] * n[1];
  this->a[2] += weight * n[0] * n[2];
  this->a[3] += weight * n[1] * n[1];
  this->a[4] += weight * n[1] * n[2];
  this->a[5] += weight * n[2] * n[2];
  for (std::size_t k = 0; k < 3; ++k)
  {
    this->b[k] += weight * d * n[k];
  }
  this->c += weight * d * d;
}

void Quadric::AddBoundary(const Vec3& p, const Vec3& q, const Vec3& r)
{
  const Vec3 e{ q[0] - p[0], q[1] - p[1], q[2] - p[2] };
  const Vec3 f{ r[0] - p[0], r[1] - p[1], r[2] - p[2] };
  // The part of f that is perpendicular to e.
  const double ee = e[0] * e[0] + e[1] * e[1] + e[2] * e[2];
  const double along = (e[0] * f[0] + e[1] * f[1] + e[2] * f[2]) / ee;
  Vec3 n{ f[0] - along * e[0], f[1] - along * e[1], f[2] - along * e[2] };
  const double length = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
  if (!(length > 0) || !std::isfinite(length) || !std::isfinite(ee))
  {
    return;
  }
  for (double& value : n)
  {
    value /= length;
  }
  this->AddPlane(n, p, ee);
}

double Quadric::At(const Vec3& x) const
{
  const double ax = this->a[0] * x[0] + this->a[1] * x[1] + this->a[2] * x[2];
  const double ay = this->a[1] * x[0] + this->a[3] * x[1] + this->a[4] * x[2];
  const double az = this->a[2] * x[0] + this->a[4] * x[1] + this->a[5] * x[2];
  const double value = ax * x[0] + ay * x[1] + az * x[2] +
                       2 * (this->b[0] * x[0] + this->b[1] * x[1] + this->b[2] * x[2]) + this->c;
  return std::max(value, 0.0);
}

Vec3 Quadric::Minimum(const Vec3& start, double regularisation) const
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
