// Plane quadrics: the squared distances to a set of weighted planes, as one quadratic form (Garland
// and Heckbert, "Surface simplification using quadric error metrics", 1997). For representatives
// and deviations of levels.
#pragma once

#include "filters/core/Types.h"

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

}
