// SPDX-License-Identifier: BSD-3-Clause
// Plane quadrics: the squared distances to a set of weighted planes, as one quadratic form (Garland
// and Heckbert, "Surface simplification using quadric error metrics", 1997). For representatives
// and geometric errors of levels.
#pragma once

#include "filters/core/Lanes.h"
#include "filters/core/Types.h"

#include <array>
#include <cstddef>

namespace kdstream
{

// Q(x) = x'Ax + 2 b'x + c, the sum of weight × squared distance over planes. With unit normals
// trace A is the sum of the weights, so Q(x) / trace A is the mean squared distance. Coordinates
// are relative to an origin that the caller chooses: it must be near the points, otherwise digits
// are lost. Real: double, or Lanes for two forms at once, with the same bits.
template <class Real>
struct QuadraticForm
{
  // A: xx xy xz yy yz zz.
  Real a[6] = {};
  Real b[3] = {};
  Real c{};

  // The plane of a triangle, weighted with its area; 0 for a triangle without area.
  static QuadraticForm OfTriangle(
    const std::array<Real, 3>& p, const std::array<Real, 3>& q, const std::array<Real, 3>& r);

  Real Trace() const { return this->a[0] + this->a[3] + this->a[5]; }
  // Never below 0.
  [[gnu::always_inline]] Real At(const std::array<Real, 3>& x) const;
  // The point that minimises Q(x) + regularisation × trace A × |x - start|²: it stays near `start`
  // along directions that the planes do not determine. Returns `start` itself if there are no
  // planes, or the system cannot be solved.
  [[gnu::always_inline]] std::array<Real, 3> Minimum(
    const std::array<Real, 3>& start, double regularisation) const;
};

struct Quadric : QuadraticForm<double>
{
  void Add(const QuadraticForm& other);
  // Adds the plane through the edge p q at a right angle to the triangle p q r, weighted with the
  // edge's squared length. It keeps boundary edges in place. Adds nothing for a triangle without
  // area.
  void AddBoundary(const Vec3& p, const Vec3& q, const Vec3& r);
  // Adds the plane through p with the unit normal n.
  void AddPlane(const Vec3& n, const Vec3& p, double weight);
};

// The direction in which a quadric's triangles face, from the sum `normal` of their area vectors; 0
// if they face all ways and have no common direction.
inline Vec3 FacingOf(const Vec3& normal, const Quadric& quadric)
{
  constexpr double leastAgreement = 0.25; // of the area
  const double least = leastAgreement * quadric.Trace();
  const double squared = normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2];
  return squared >= least * least ? normal : Vec3{};
}

// Defined here to be inlined, because edge collapse spends most of its time in these functions.

inline void Quadric::Add(const QuadraticForm& other)
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

template <class Real>
QuadraticForm<Real> QuadraticForm<Real>::OfTriangle(
  const std::array<Real, 3>& p, const std::array<Real, 3>& q, const std::array<Real, 3>& r)
{
  const std::array<Real, 3> u{ q[0] - p[0], q[1] - p[1], q[2] - p[2] };
  const std::array<Real, 3> v{ r[0] - p[0], r[1] - p[1], r[2] - p[2] };
  std::array<Real, 3> n{ u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2],
    u[0] * v[1] - u[1] * v[0] };
  const Real length = SquareRoot(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
  const auto hasArea = And(length > Real(0), length - length == Real(0));
  for (Real& value : n)
  {
    value = value / length;
  }
  const Real d = -(n[0] * p[0] + n[1] * p[1] + n[2] * p[2]);
  const Real weight = length / 2;
  const auto ofArea = [&](Real value) { return Select(hasArea, value, Real(0)); };
  QuadraticForm form;
  form.a[0] = ofArea(weight * n[0] * n[0]);
  form.a[1] = ofArea(weight * n[0] * n[1]);
  form.a[2] = ofArea(weight * n[0] * n[2]);
  form.a[3] = ofArea(weight * n[1] * n[1]);
  form.a[4] = ofArea(weight * n[1] * n[2]);
  form.a[5] = ofArea(weight * n[2] * n[2]);
  for (std::size_t k = 0; k < 3; ++k)
  {
    form.b[k] = ofArea(weight * d * n[k]);
  }
  form.c = ofArea(weight * d * d);
  return form;
}

template <class Real>
inline Real QuadraticForm<Real>::At(const std::array<Real, 3>& x) const
{
  const Real ax = this->a[0] * x[0] + this->a[1] * x[1] + this->a[2] * x[2];
  const Real ay = this->a[1] * x[0] + this->a[3] * x[1] + this->a[4] * x[2];
  const Real az = this->a[2] * x[0] + this->a[4] * x[1] + this->a[5] * x[2];
  const Real value = ax * x[0] + ay * x[1] + az * x[2] +
                     2 * (this->b[0] * x[0] + this->b[1] * x[1] + this->b[2] * x[2]) + this->c;
  return Select(value < Real(0), Real(0), value);
}

template <class Real>
inline std::array<Real, 3> QuadraticForm<Real>::Minimum(
  const std::array<Real, 3>& start, double regularisation) const
{
  // (A + eI) (x - start) = -(b + A start), by Cramer's rule.
  const Real e = regularisation * this->Trace();
  const Real xx = this->a[0] + e, xy = this->a[1], xz = this->a[2];
  const Real yy = this->a[3] + e, yz = this->a[4], zz = this->a[5] + e;
  const std::array<Real, 3> r{ -(this->b[0] + this->a[0] * start[0] + this->a[1] * start[1] +
                                 this->a[2] * start[2]),
    -(this->b[1] + this->a[1] * start[0] + this->a[3] * start[1] + this->a[4] * start[2]),
    -(this->b[2] + this->a[2] * start[0] + this->a[4] * start[1] + this->a[5] * start[2]) };
  const Real c00 = yy * zz - yz * yz, c01 = yz * xz - xy * zz, c02 = xy * yz - yy * xz;
  const Real c11 = xx * zz - xz * xz, c12 = xy * xz - xx * yz, c22 = xx * yy - xy * xy;
  const Real determinant = xx * c00 + xy * c01 + xz * c02;
  const std::array<Real, 3> x{ start[0] + (c00 * r[0] + c01 * r[1] + c02 * r[2]) / determinant,
    start[1] + (c01 * r[0] + c11 * r[1] + c12 * r[2]) / determinant,
    start[2] + (c02 * r[0] + c12 * r[1] + c22 * r[2]) / determinant };
  // x - x is 0 for every finite number, otherwise NaN.
  const auto solved = And(
    And(e > Real(0), x[0] - x[0] == Real(0)), And(x[1] - x[1] == Real(0), x[2] - x[2] == Real(0)));
  return { Select(solved, x[0], start[0]), Select(solved, x[1], start[1]),
    Select(solved, x[2], start[2]) };
}

}
