// SPDX-License-Identifier: BSD-3-Clause
#include "filters/core/collapse/Quadric.h"

#include "filters/core/VectorMath.h"

#include <cmath>

namespace kdstream
{

void Quadric::AddPlane(const Vec3& n, const Vec3& p, double weight)
{
  const double d = -Dot(n, p);
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
  const Vec3 e = Minus(q, p), f = Minus(r, p);
  // The part of f that is perpendicular to e.
  const double ee = Dot(e, e);
  const double along = Dot(e, f) / ee;
  Vec3 n{ f[0] - along * e[0], f[1] - along * e[1], f[2] - along * e[2] };
  const double length = Length(n);
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

}
