// SPDX-License-Identifier: BSD-3-Clause
// Distances of a point to a segment and to a triangle, and the nearest points on them.
#pragma once

#include "filters/core/Types.h"
#include "filters/core/VectorMath.h"

#include <algorithm>
#include <utility>

namespace kdstream
{

inline double SquaredToSegment(const Vec3& p, const Vec3& a, const Vec3& b)
{
  const Vec3 edge = Minus(b, a), from = Minus(p, a);
  const double squares = Dot(edge, edge);
  const double t = squares > 0 ? std::clamp(Dot(from, edge) / squares, 0.0, 1.0) : 0;
  const Vec3 d{ from[0] - t * edge[0], from[1] - t * edge[1], from[2] - t * edge[2] };
  return Dot(d, d);
}

// If p's projection is inside the triangle, the squared distance from the triangle's plane,
// otherwise from the nearest edge. For a triangle without area only the edges count.
inline double SquaredToTriangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c)
{
  const Vec3 u = Minus(b, a), v = Minus(c, a), w = Minus(p, a);
  const double uu = Dot(u, u), uv = Dot(u, v), vv = Dot(v, v);
  const double determinant = uu * vv - uv * uv;
  if (determinant > 0)
  {
    const double wu = Dot(w, u), wv = Dot(w, v);
    const double s = (vv * wu - uv * wv) / determinant, t = (uu * wv - uv * wu) / determinant;
    if (s >= 0 && t >= 0 && s + t <= 1)
    {
      const Vec3 d{ w[0] - s * u[0] - t * v[0], w[1] - s * u[1] - t * v[1],
        w[2] - s * u[2] - t * v[2] };
      return Dot(d, d);
    }
  }
  return std::min(
    { SquaredToSegment(p, a, b), SquaredToSegment(p, b, c), SquaredToSegment(p, c, a) });
}

inline Vec3 NearestOnSegment(const Vec3& p, const Vec3& a, const Vec3& b)
{
  const Vec3 edge = Minus(b, a);
  const double squares = Dot(edge, edge);
  const double t = squares > 0 ? std::clamp(Dot(Minus(p, a), edge) / squares, 0.0, 1.0) : 0;
  return { a[0] + t * edge[0], a[1] + t * edge[1], a[2] + t * edge[2] };
}

// The projection of p on the triangle's plane if it is inside the triangle. Otherwise, and for a
// triangle without area, the nearest point on an edge.
inline Vec3 NearestOnTriangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c)
{
  const Vec3 normal = Cross(Minus(b, a), Minus(c, a));
  const double squares = Dot(normal, normal);
  if (squares > 0 && Dot(Cross(Minus(b, a), Minus(p, a)), normal) >= 0 &&
      Dot(Cross(Minus(c, b), Minus(p, b)), normal) >= 0 &&
      Dot(Cross(Minus(a, c), Minus(p, c)), normal) >= 0)
  {
    const double t = Dot(Minus(p, a), normal) / squares;
    return { p[0] - t * normal[0], p[1] - t * normal[1], p[2] - t * normal[2] };
  }
  Vec3 nearest = NearestOnSegment(p, a, b);
  double distance = SquaredToSegment(p, a, b);
  for (const auto& [from, to] : { std::pair(b, c), std::pair(c, a) })
  {
    const double squared = SquaredToSegment(p, from, to);
    if (squared < distance)
    {
      nearest = NearestOnSegment(p, from, to);
      distance = squared;
    }
  }
  return nearest;
}

}
