// SPDX-License-Identifier: BSD-3-Clause
// The mesh that k-means clusters, moved into the unit cube. For KMeansClustering alone.
#pragma once

#include "filters/core/Result.h"
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

}
