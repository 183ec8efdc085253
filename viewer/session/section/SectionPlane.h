// SPDX-License-Identifier: BSD-3-Clause
// A plane that cuts part of the model away. Below the steps "pick" and "render" of the pipeline
// picture.
#pragma once

#include "viewer/session/Camera.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kdstream
{

struct SectionPlane
{
  Vec3 normal{ 0, 0, 1 }; // of length 1, towards what is cut away
  double offset = 0;      // of its points along the normal, model units
  bool operator==(const SectionPlane&) const = default;

  // The distance of a point above the plane; above 0, the point is cut away.
  double Above(const Vec3& point) const { return Dot(point, this->normal) - this->offset; }
  bool CutsAway(const Vec3& point) const { return this->Above(point) > 0; }
  // Whether all of a box is cut away; true for an empty box.
  bool CutsAwayAllOf(const Box& box) const { return this->LeastOf(box) > this->offset; }
  // Whether the plane goes through a box.
  bool Meets(const Box& box) const
  {
    return this->LeastOf(box) <= this->offset && this->MostOf(box) >= this->offset;
  }
  // How far along the normal a box begins and ends.
  double LeastOf(const Box& box) const { return this->CornerOf(box, false); }
  double MostOf(const Box& box) const { return this->CornerOf(box, true); }

  Vec3 NearestTo(const Vec3& point) const { return point - this->normal * this->Above(point); }

  // The part of a ray that is not cut away: from `begin` to `end`, distances of 0 or more along the
  // ray; begin > end if nothing is left.
  struct Part
  {
    double begin = 0, end = std::numeric_limits<double>::infinity();
  };
  Part KeptOf(const Ray& ray) const
  {
    const double above = this->Above(ray.origin), rise = Dot(ray.direction, this->normal);
    const double meets = -above / rise;
    if (above > 0)
    {
      return { rise < 0 ? meets : std::numeric_limits<double>::infinity(),
        rise < 0 ? std::numeric_limits<double>::infinity() : 0.0 };
    }
    return { 0, rise > 0 ? meets : std::numeric_limits<double>::infinity() };
  }

private:
  double CornerOf(const Box& box, bool most) const
  {
    double sum = box.Empty() ? std::numeric_limits<double>::infinity() : 0;
    for (std::size_t k = 0; k < 3 && !box.Empty(); ++k)
    {
      const double lo = this->normal[k] * box.lo[k], hi = this->normal[k] * box.hi[k];
      sum += most ? std::max(lo, hi) : std::min(lo, hi);
    }
    return sum;
  }
};

// The plane's own axes, with their origin at a point near what is drawn. Seen against the normal, x
// is to the right and y up. For a plane across a coordinate axis, they are the other two axes.
struct SectionAxes
{
  Vec3 origin, x, y;

  SectionAxes(const SectionPlane& plane, const Vec3& near)
    : origin(plane.NearestTo(near))
    , x(Across(plane.normal))
    , y(Cross(plane.normal, x))
  {
  }
  std::array<double, 2> To(const Vec3& p) const
  {
    return { Dot(p - this->origin, this->x), Dot(p - this->origin, this->y) };
  }
  Vec3 From(const std::array<double, 2>& p) const
  {
    return this->origin + this->x * p[0] + this->y * p[1];
  }
};

}
