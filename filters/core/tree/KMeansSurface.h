// The mesh that k-means clusters, moved into the unit cube. For KMeansClustering alone.
#pragma once

#include "filters/core/Result.h"
#include "filters/core/TriangleDistance.h"
#include "filters/core/Types.h"

#include <span>
#include <vector>

namespace kdstream
{

// In the unit cube, so that no cost depends on units or offsets.
struct KMeansSurface
{
  std::vector<Vec3> points;
  std::vector<Triangle> triangles; // corners are the lowest vertices of their places
  std::vector<VertexId> place;     // of each vertex: the lowest in the same place
};

// Errors: those of CheckExtent.
Result<KMeansSurface> MakeKMeansSurface(
  std::span<const Vec3> points, std::span<const Triangle> triangles);

inline double SquaredDistance(const Vec3& a, const Vec3& b)
{
  const Vec3 d = Minus(a, b);
  return Dot(d, d);
}

}
