// SPDX-License-Identifier: BSD-3-Clause
// What lies under a finger: step "pick" of the pipeline picture (paper section 5.3).
#pragma once

#include "filters/core/drawing/DrawnSurface.h"
#include "viewer/session/Camera.h"
#include "viewer/session/section/SectionPlane.h"

#include <cstddef>
#include <optional>

namespace kdstream
{

// A point of a cloud, or an outline, is meant by a finger that is so many points of the screen
// away.
inline constexpr double fingerPoints = 24;

struct SurfaceHit
{
  Vec3 point;
  std::size_t triangle = 0; // in Surface::triangles; of a cloud: in Surface::points
  double distance = 0;      // from the ray's origin, or the point asked for, model units
  std::size_t part = 0;     // of DrawnSurface::Parts
};

// The nearest point of `surface` that `ray` meets, seen from either side; the triangle with the
// lowest index among equals; nothing where the ray misses. Degenerate triangles are never met, and
// where so thin a one is met that rounding puts the point outside its box, it is not met either.
// Möller and Trumbore's test in doubles for every triangle: O(triangles), no memory.
//
// Of a surface without triangles (a cloud, or a mesh whose level is too coarse for any) the nearest
// point before the eye that is no farther from the ray than `slack` times its distance: the tangent
// of the angle that a finger covers. O(points).
std::optional<SurfaceHit> PickSurface(const Surface& surface, const Ray& ray, double slack = 0);
// The same for all parts of a surface, of the first part among equals; `triangle` is one of that
// part. Goes down the trees of the parts that the ray may meet, and makes those that were not
// asked for before (SurfacePart::Tree): in practice O(log triangles). visited: how many triangles,
// or points, were looked at. begin: what is nearer is not met.
std::optional<SurfaceHit> PickSurface(const DrawnSurface& surface, const Ray& ray, double slack = 0,
  std::size_t* visited = nullptr, double begin = 0);

// The point of the surface that is nearest to `point`, and how far away: of its triangles or, of a
// cloud, of its points; nothing where it is empty. Any that is no farther than `enough` may be
// given instead, if that is found sooner. section: triangles that it cuts away wholly do not count.
// As PickSurface.
std::optional<SurfaceHit> NearestOnSurface(const DrawnSurface& surface, const Vec3& point,
  double enough = 0, const SectionPlane* section = nullptr);

// Whether a closed surface is around a point: rays from there cross it an odd number of times. What
// two of three say, since one may go through an edge or a small hole. As PickSurface.
bool IsAround(const DrawnSurface& surface, const Vec3& point);

}
