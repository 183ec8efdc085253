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

// A finger picks a point of a cloud, or of an outline, up to this number of points of the screen
// away.
inline constexpr double fingerPoints = 24;

struct SurfaceHit
{
  Vec3 point;
  std::size_t triangle = 0; // index into Surface::triangles; for a cloud: into Surface::points
  double distance = 0;      // from the ray's origin, or from the given point; model units
  std::size_t part = 0;     // index into DrawnSurface::Parts
};

// The nearest point of `surface` that `ray` meets, seen from either side; the triangle with the
// lowest index among equals; nothing if the ray misses. Degenerate triangles are never hit; neither
// are triangles so thin that rounding puts the point outside their box. Möller and Trumbore's test
// in doubles for every triangle: O(triangles), no memory.
//
// For a surface without triangles (a cloud, or a level too coarse for any): the nearest point
// before the eye whose distance from the ray is at most `slack` times its distance from the eye.
// `slack` is the tangent of the angle that a finger covers. O(points).
std::optional<SurfaceHit> PickSurface(const Surface& surface, const Ray& ray, double slack = 0);
// The same for all parts of a surface; among equals the hit in the first part; `triangle` is an
// index in that part. Searches the trees of the parts that the ray may hit, and builds missing
// trees (SurfacePart::Tree): in practice O(log triangles). visited: is increased by the number of
// triangles, or points, that were tested. begin: nearer points are ignored.
std::optional<SurfaceHit> PickSurface(const DrawnSurface& surface, const Ray& ray, double slack = 0,
  std::size_t* visited = nullptr, double begin = 0);

// The point of the surface that is nearest to `point`, and its distance. The surface is its
// triangles, or, for a cloud, its points. Nothing if the surface is empty. May return another point
// whose distance is at most `enough`, if it is found sooner. section: triangles that it cuts away
// completely are ignored. Complexity: as PickSurface.
std::optional<SurfaceHit> NearestOnSurface(const DrawnSurface& surface, const Vec3& point,
  double enough = 0, const SectionPlane* section = nullptr);

// Whether a closed surface surrounds a point: then a ray from the point crosses the surface an odd
// number of times. Uses the majority of three rays, because one may hit an edge or a small hole.
// Complexity: as PickSurface.
bool IsAround(const DrawnSurface& surface, const Vec3& point);

}
