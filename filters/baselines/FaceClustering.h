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

// clusterOf: for each triangle a number below `clusters`.
struct FaceClustering
{
  std::vector<std::uint32_t> clusterOf;
  std::uint32_t clusters = 0;
};

// First joins triangles that share an edge, then clusters, until `wanted` clusters are left, or
// until no two clusters share an edge. Then there is one cluster for each component, which may be
// more than `wanted`.
//
// Works in rounds. Each round is a matching of the dual graph: pairs in ascending order of cost,
// each cluster at most once, so that all grow at a similar rate. (If a round would join fewer than
// an eighth, as in a star, the others join too.) The cost of a pair is its compactness p^2 / (4 pi
// w), plus its number of triangles divided by the mean number that is wanted. Clusters are numbered
// by their first triangle. Complexity: O(t log^2 t); memory about 100 bytes a triangle. Serial.
// Errors: Cancelled. Source: paper 4.1.1, [5], [14]; the dual graph and its contraction after
// Garland, Willmott and Heckbert, Hierarchical Face Clustering on Polygonal Surfaces, 2001, in
// rounds instead of a heap.
Result<FaceClustering> ClusterFaces(std::span<const Vec3> points,
  std::span<const Triangle> triangles, std::uint32_t wanted, const Execution& execution = {});

}
