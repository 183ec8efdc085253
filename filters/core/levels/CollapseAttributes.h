// SPDX-License-Identifier: BSD-3-Clause
// What colours and normals cost when clusters merge. For the makers of levels alone.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/Types.h"
#include "filters/core/levels/ClusterSum.h"

#include <span>
#include <vector>

namespace kdstream
{

// A value for each component of each cluster, in model units: see CollapsePart::attributes.
struct CollapseAttributes
{
  std::size_t components = 0;
  std::vector<float> values;
};

// The share of the model's diagonal that a full change of one colour component (from 0 to 1), or a
// normal's turn by 60° (a difference of length 1), costs as a distance.
// Measured on a sphere painted as a checkerboard, at 1,024 clusters: 1/256 takes 18 % off the
// colours' error and adds 16 % to the surface's (1/128: 22 and 30, 1/512: 13 and 6); smooth colours
// cost nothing at any of these, and a flat board keeps every field whole.
inline constexpr double colorScale = 1.0 / 256;
inline constexpr double normalScale = 1.0 / 4096;

// Of a box.
double DiagonalOf(const Box& box);

// The means of the mesh's colours and normals over the original vertices of each finest cluster;
// other arrays are left out. clusterOf: noVertex for vertices that are left out too. NaN counts as
// 0, a normal's component beyond 1 as 1. O(n).
CollapseAttributes MeanAttributes(const Mesh& mesh, std::span<const VertexId> clusterOf,
  std::span<const ClusterSum> clusters, double diagonal);

// Those of the next coarser level: means weighted with the traces of the clusters' quadrics.
// parents: of each cluster, `count` in all.
CollapseAttributes MeanOverChildren(const CollapseAttributes& children,
  std::span<const ClusterSum> clusters, std::span<const VertexId> parents, std::size_t count);

}
