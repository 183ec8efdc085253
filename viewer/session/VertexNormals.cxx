// Normals of a drawn surface: see VertexNormals.h.
#include "viewer/session/VertexNormals.h"

#include <algorithm>
#include <cmath>

namespace kdstream
{
namespace
{

Vec3 Difference(const Vec3& a, const Vec3& b)
{
  return { a[0] - b[0], a[1] - b[1], a[2] - b[2] };
}

// Twice the area long, so that summing it weights by area.
Vec3 Cross(const Vec3& a, const Vec3& b)
{
  return { a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0] };
}

}

std::array<float, 3> UnitNormal(const Vec3& v)
{
  // Scaled by the largest component first: areas of tiny or huge models squared leave the range of
  // doubles.
  const double scale = std::max({ std::abs(v[0]), std::abs(v[1]), std::abs(v[2]) });
  if (!(scale > 0.0) || !std::isfinite(scale))
  {
    return { 0.0f, 0.0f, 0.0f };
  }
  const Vec3 u{ v[0] / scale, v[1] / scale, v[2] / scale };
  const double length = std::sqrt(u[0] * u[0] + u[1] * u[1] + u[2] * u[2]);
  return { static_cast<float>(u[0] / length), static_cast<float>(u[1] / length),
    static_cast<float>(u[2] / length) };
}

std::vector<std::array<float, 3>> ComputeVertexNormals(
  std::span<const Vec3> points, std::span<const Triangle> triangles)
{
  std::vector<Vec3> sums(points.size(), Vec3{ 0.0, 0.0, 0.0 });
  for (const Triangle& triangle : triangles)
  {
    const Vec3& origin = points[triangle[0]];
    const Vec3 normal =
      Cross(Difference(points[triangle[1]], origin), Difference(points[triangle[2]], origin));
    for (const VertexId v : triangle)
    {
      for (std::size_t k = 0; k < 3; ++k)
      {
        sums[v][k] += normal[k];
      }
    }
  }
  std::vector<std::array<float, 3>> normals(points.size());
  std::transform(sums.begin(), sums.end(), normals.begin(), UnitNormal);
  return normals;
}

}
