// SPDX-License-Identifier: BSD-3-Clause
// The state of a level while coarser ones are made from it: the whole level, or a block of it. Only
// for the makers of levels.
#pragma once

#include "filters/core/Types.h"
#include "filters/core/collapse/EdgeCollapse.h"
#include "filters/core/levels/ClusterSum.h"
#include "filters/core/levels/CollapseAttributes.h"

#include <algorithm>
#include <cstdint>
#include <vector>

namespace kdstream
{

// The clusters of a block of a level: those at home in one cell of the tree. Before and after them,
// in ascending order, `level` has the clusters of other blocks that share a triangle with them
// (ghosts). The triangles are all that touch an own cluster, sorted. Sums and other data exist only
// for own clusters: ghosts do not move, and a triangle soup has more ghosts than own clusters. A
// whole level is a block without ghosts.
struct CollapseState
{
  ClusterLevel level;
  VertexId ownBegin = 0, ownEnd = 0; // the own clusters
  // For each own cluster, from the first one on:
  std::vector<ClusterSum> clusters;
  std::vector<std::uint32_t> cellOf; // finest cell of its lowest original vertex
  CollapseAttributes attributes;

  VertexId Count() const { return static_cast<VertexId>(this->level.positions.size()); }
  VertexId OwnCount() const { return this->ownEnd - this->ownBegin; }
  bool IsOwn(VertexId cluster) const { return cluster >= this->ownBegin && cluster < this->ownEnd; }
};

// The origin to which positions are relative while edges collapse, and the box in which vertices
// must stay. Both in absolute coordinates.
struct CollapseSpace
{
  Vec3 origin{}; // of the clusters' sums
  Box box;       // the model's

  Vec3 Relative(const Vec3& p) const
  {
    return { p[0] - this->origin[0], p[1] - this->origin[1], p[2] - this->origin[2] };
  }
  // The absolute position, clamped to the box, without -0.0.
  Vec3 Absolute(const Vec3& relative) const
  {
    Vec3 p;
    for (std::size_t k = 0; k < 3; ++k)
    {
      p[k] = std::clamp(relative[k] + this->origin[k], this->box.lo[k], this->box.hi[k]) + 0.0;
    }
    return p;
  }
  Box RelativeBox() const
  {
    Box relative;
    relative.Add(this->Relative(this->box.lo));
    relative.Add(this->Relative(this->box.hi));
    return relative;
  }
};

// Appends an own cluster of a state to a part that will be collapsed.
inline void AppendCluster(
  const CollapseState& state, const CollapseSpace& space, VertexId cluster, CollapsePart& part)
{
  const std::size_t own = cluster - state.ownBegin;
  part.positions.push_back(space.Relative(state.level.positions[cluster]));
  part.quadrics.push_back(state.clusters[own].quadric);
  part.normals.push_back(state.clusters[own].normal);
  const auto values = state.attributes.values.begin() +
                      static_cast<std::ptrdiff_t>(own * state.attributes.components);
  part.attributes.insert(part.attributes.end(), values,
    values + static_cast<std::ptrdiff_t>(state.attributes.components));
}

// Adds the area of each cluster's triangles to `sum`, in the order of the clusters.
inline double AddAreas(double sum, std::span<const ClusterSum> clusters)
{
  for (const ClusterSum& cluster : clusters)
  {
    sum += cluster.quadric.Trace();
  }
  return sum;
}

}
