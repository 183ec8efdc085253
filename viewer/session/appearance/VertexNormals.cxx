// SPDX-License-Identifier: BSD-3-Clause
// Normals of a drawn surface: see VertexNormals.h.
#include "viewer/session/appearance/VertexNormals.h"

#include "filters/core/VectorMath.h"
#include "filters/core/drawing/PartNormals.h"

#include <algorithm>
#include <cmath>

namespace kdstream
{

std::array<float, 3> UnitNormal(const Vec3& v)
{
  // Scaled by the largest component first: squares of areas of tiny or huge models would leave the
  // range of doubles.
  const double scale = std::max({ std::abs(v[0]), std::abs(v[1]), std::abs(v[2]) });
  if (!(scale > 0.0) || !std::isfinite(scale))
  {
    return { 0.0f, 0.0f, 0.0f };
  }
  const Vec3 u{ v[0] / scale, v[1] / scale, v[2] / scale };
  const double length = Length(u);
  return { static_cast<float>(u[0] / length), static_cast<float>(u[1] / length),
    static_cast<float>(u[2] / length) };
}

UnitNormals UnitNormalsOf(std::span<const Vec3> vectors)
{
  UnitNormals normals(vectors.size());
  std::transform(vectors.begin(), vectors.end(), normals.begin(), UnitNormal);
  return normals;
}

UnitNormals ComputeVertexNormals(std::span<const Vec3> points, std::span<const Triangle> triangles)
{
  return UnitNormalsOf(SumOfNormals(points, triangles));
}

}
