// SPDX-License-Identifier: BSD-3-Clause
// K-means clustering of vertices on the surface, the paper's second baseline. Step "tree" of the
// pipeline picture, in place of KdTree.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/Result.h"
#include "filters/core/Types.h"
#include "filters/core/tree/Clustering.h"

#include <cstdint>
#include <optional>
#include <span>

namespace kdstream
{

struct KMeansOptions
{
  // The mean number of vertices of a cluster, at least 1: K = ceil(n / N). Ignored if `partitions`
  // is given.
  std::uint32_t verticesPerPartition = 2000;
  // K itself, 1 … n: exactly this number of clusters.
  std::optional<std::uint32_t> partitions;
  std::uint32_t iterations = 5; // at least 1; the paper's five
  // The weights of the terms of the cost, from 0 to 10^6. distanceWeight must be above 0.
  double distanceWeight = 1;
  double compactnessWeight = 4; // gave the straightest boundaries among 0, 1, 4 on four meshes
  double countWeight = 1;
};

// Clusters vertices around K seeds.
//
// Input: n finite points; triangles refer to points. Without triangles this is Lloyd's k-means in
// space.
//
// Seeds: hierarchical face clustering (ClusterFaces) into K clusters spreads them: one seed at the
// vertex nearest to the middle of each cluster. If components make more than K clusters, only the
// fullest get a seed. Vertices in components of less than half a mean cluster, and those that no
// triangle uses, get seeds by their share of all vertices instead, spaced evenly along the order of
// a k-d tree. Nothing is random: the same input gives the same clusters.
//
// An iteration grows all clusters from their seeds at the same time, over the edges of the
// triangles; the cheapest vertex is always next. The cost of a vertex that cluster c reaches is a
// sum of
//
// - distance: the path length from the seed along edges, in radii of a mean cluster (a disc of 1/K
//   of the area), so that clusters become geodesic Voronoi cells;
// - compactness: the share of the vertex's neighbours that are not in c (at most 16 are
//   considered), times the mean length of edges in radii: closing a gap shortens the boundary;
// - count: the number of vertices that c has when it reaches the vertex, divided by n / K: full
//   clusters wait;
//
// each times its weight. Then the vertex nearest to the mean of a cluster's vertices is its next
// seed. Coincident vertices are connected. A vertex that no seed reaches along edges (in a
// component without a seed, or without triangles) joins the cluster of the seed nearest in space;
// if several are as near, the lowest one.
//
// Output: exactly K clusters, none empty, numbered by their first vertices; their sizes differ.
// Complexity: O(t log^2 t) for the seeds and O((n + t) log n) an iteration, instead of the paper's
// n K; memory about 200 bytes a vertex and 200 a triangle. Serial. Errors: InvalidArgument for no
// vertices, K of 0 or above n, N or iterations of 0, or a weight out of its range; InvalidInput
// beyond mostExtent (Extent.h); LimitExceeded beyond 2^32 - 2 vertices; Cancelled. Source: paper
// 4.1.1, after [5] and [14].
Result<Clustering> ClusterByKMeans(std::span<const Vec3> points,
  std::span<const Triangle> triangles, const KMeansOptions& options,
  const Execution& execution = {});

}
