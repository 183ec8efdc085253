// SPDX-License-Identifier: BSD-3-Clause
// What lies under a finger: step "pick" of the README's picture.
//
// T. Möller, B. Trumbore: Fast, Minimum Storage Ray/Triangle Intersection, 1997. A point of the
// triangle is a + u (b - a) + v (c - a); setting it equal to o + t d gives three equations for t, u
// and v, solved by Cramer.
#include "viewer/session/Picker.h"

namespace kdstream
{
namespace
{

// The parameter t of the ray where it meets the triangle, in front of the origin.
std::optional<double> Meet(const Ray& ray, const Vec3& a, const Vec3& b, const Vec3& c)
{
  const Vec3 ab = b - a, ac = c - a;
  const Vec3 p = Cross(ray.direction, ac);
  const double determinant = Dot(ab, p);
  if (!(determinant > 0 || determinant < 0))
  {
    return std::nullopt; // parallel to the ray, or degenerate
  }
  const Vec3 toOrigin = ray.origin - a;
  const double u = Dot(toOrigin, p) / determinant;
  if (!(u >= 0 && u <= 1))
  {
    return std::nullopt;
  }
  const Vec3 q = Cross(toOrigin, ab);
  const double v = Dot(ray.direction, q) / determinant;
  const double t = Dot(ac, q) / determinant;
  if (!(v >= 0 && u + v <= 1) || !(t > 0) || !std::isfinite(t))
  {
    return std::nullopt;
  }
  return t;
}

std::optional<SurfaceHit> PickPoint(const Surface& cloud, const Ray& ray, double slack)
{
  std::optional<SurfaceHit> best;
  for (std::size_t i = 0; i < cloud.points.size(); ++i)
  {
    const Vec3 toPoint = cloud.points[i] - ray.origin;
    const double t = Dot(toPoint, ray.direction);
    const Vec3 aside = toPoint - ray.direction * t;
    const bool near = t > 0 && Dot(aside, aside) <= slack * t * (slack * t);
    if (near && (!best || t < best->distance))
    {
      best = SurfaceHit{ cloud.points[i], i, t };
    }
  }
  return best;
}

}

std::optional<SurfaceHit> PickSurface(const Surface& surface, const Ray& ray, double slack)
{
  if (surface.triangles.empty())
  {
    return PickPoint(surface, ray, slack);
  }
  std::optional<SurfaceHit> best;
  for (std::size_t i = 0; i < surface.triangles.size(); ++i)
  {
    const Triangle& triangle = surface.triangles[i];
    const auto t = Meet(
      ray, surface.points[triangle[0]], surface.points[triangle[1]], surface.points[triangle[2]]);
    if (t && (!best || *t < best->distance))
    {
      best = SurfaceHit{ ray.origin + ray.direction * *t, i, *t };
    }
  }
  return best;
}

std::optional<SurfaceHit> PickSurface(const DrawnSurface& surface, const Ray& ray, double slack)
{
  std::optional<SurfaceHit> best;
  for (const DrawnSurface::Part& each : surface.Parts())
  {
    const Surface& part = each.part->surface;
    if (part.triangles.empty() && surface.TriangleCount() > 0)
    {
      continue; // points without triangles are not drawn
    }
    const auto hit = PickSurface(part, ray, slack);
    if (hit && (!best || hit->distance < best->distance))
    {
      best = hit;
    }
  }
  return best;
}

bool IsAround(const DrawnSurface& surface, const Vec3& point)
{
  const auto isOdd = [&](const Vec3& direction)
  {
    bool odd = false;
    for (const DrawnSurface::Part& each : surface.Parts())
    {
      const Surface& part = each.part->surface;
      for (const Triangle& t : part.triangles)
      {
        odd =
          odd != Meet({ point, direction }, part.points[t[0]], part.points[t[1]], part.points[t[2]])
                   .has_value();
      }
    }
    return odd;
  };
  // Of no common direction of edges.
  const bool first = isOdd({ 0.6, 0.64, 0.48 }), second = isOdd({ -0.48, 0.36, 0.8 });
  return first == second ? first : isOdd({ 0.36, -0.8, 0.48 });
}

}
