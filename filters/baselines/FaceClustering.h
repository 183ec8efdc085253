// SPDX-License-Identifier: BSD-3-Clause
// Hierarchical face clustering: spreads the seeds of k-means over a surface.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/Result.h"
#include "filters/core/Types.h"

#include <cstdint>
#include <span>
#include <vector>

namespace kdstream
{

// clusterOf: for each triangle, below `clusters`.
struct FaceClustering
{
  std::vector<std::uint32_t> clusterOf;
  std::uint32_t clusters = 0;
};

// Joins triangles that share an edge, then the clusters, until `wanted` clusters are left, or no
// two clusters share an edge (one cluster for each component; these may be more).
//
// Works in rounds. Each is a matching of the dual graph: pairs in ascending order of their cost, a
// cluster once a round, so that all grow alike. (Where a round would join fewer than an eighth, as
// in a star, the rest joins as well.) The cost of a pair is its compactness p^2 / (4 pi w) plus its
// number of triangles by the wanted mean. Clusters are numbered by their first triangle.
// Complexity: O(t log^2 t); memory about 100 bytes a triangle. Serial. Errors: Cancelled. Source:
// paper 4.1.1, [5], [14]; the dual graph and its contraction after Garland, Willmott and Heckbert,
// Hierarchical Face Clustering on Polygonal Surfaces, 2001, in rounds instead of a heap.
Result<FaceClustering> ClusterFaces(std::span<const Vec3> points,
  std::span<const Triangle> triangles, std::uint32_t wanted, const Execution& execution = {});

}
