// What lies under a finger: step "pick" of the README's picture (paper section 5.3).
#pragma once

#include "filters/core/Surface.h"
#include "viewer/session/Camera.h"

#include <cstddef>
#include <optional>

namespace kdstream
{

struct SurfaceHit
{
  Vec3 point;
  std::size_t triangle = 0; // in Surface::triangles
  double distance = 0;      // from the ray's origin, model units
};

// The nearest point of `surface` that `ray` meets, seen from either side; the triangle with the
// lowest index among equals; nothing where the ray misses. Degenerate triangles are never met.
// Möller and Trumbore's test in doubles for every triangle: O(triangles), no memory.
std::optional<SurfaceHit> PickSurface(const Surface& surface, const Ray& ray);

}
