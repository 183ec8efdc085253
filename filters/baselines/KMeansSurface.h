// SPDX-License-Identifier: BSD-3-Clause
// The mesh that k-means clusters, moved into the unit cube, and the seeds of its clusters. Only for
// KMeansClustering.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/Result.h"
#include "filters/core/Types.h"

#include <cstdint>
#include <span>
#include <vector>

namespace kdstream
{

// In the unit cube, so that costs do not depend on units or offsets.
struct KMeansSurface
{
  std::vector<Vec3> points;
  std::vector<Triangle> triangles; // corners are the lowest vertices in their places
  std::vector<VertexId> place;     // for each vertex, the lowest one in the same place
};

// Errors: those of CheckExtent.
Result<KMeansSurface> MakeKMeansSurface(
  std::span<const Vec3> points, std::span<const Triangle> triangles);

// Step b (KMeansSeeds.cxx): a seed for each of `clusters` clusters, all different, as described in
// KMeansClustering.h. Errors: Cancelled.
Result<std::vector<VertexId>> SpreadSeeds(
  const KMeansSurface& surface, std::uint32_t clusters, const Execution& execution);

}
