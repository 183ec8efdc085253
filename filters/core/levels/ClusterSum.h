// SPDX-License-Identifier: BSD-3-Clause
// The sums over a cluster of original vertices. Only for the makers of levels.
#pragma once

#include "filters/core/Types.h"
#include "filters/core/collapse/Quadric.h"
#include "filters/core/levels/ClusterLevels.h"

#include <cstdint>

namespace kdstream
{

// Two clusters that are linked, the lower first.
using Link = std::pair<VertexId, VertexId>;

// All data of a cluster, except its place in the level. For a finest cluster they are summed over
// vertices, for a coarser one over clusters. Sums are relative to the centre of the model's box.
struct ClusterSum
{
  std::uint64_t count = 0; // original vertices
  Vec3 sum{};              // of their positions
  double squares = 0;      // of their positions' squared lengths
  Vec3 boundarySum{};      // sum of the positions of vertices on the surface's boundary
  std::uint64_t boundaryCount = 0;
  Box box;         // of the vertices, absolute
  Quadric quadric; // of their triangles and boundary edges
  Vec3 normal{};   // area vectors of their triangles, each once; only if clusters collapse
  double geometricError = 0;
  VertexId lowest = noVertex;
  bool surface = false; // whether a triangle touches one of its vertices

  void AddVertex(VertexId v, const Vec3& absolute, const Vec3& relative);
  void Add(const ClusterSum& child);

  // The representative, in absolute coordinates. It is clamped to the box, so that points in an
  // axis-aligned plane, or in one place, stay there exactly. Has no -0.0, whose sign would depend
  // on the order of the vertices.
  Vec3 Represent(Representative representative, const Vec3& origin) const;
  // The direction in which the cluster's triangles face, as the sum of their area vectors. 0 if
  // they face all ways, like the two sides of a thin wall, or a whole limb.
  Vec3 Facing() const;
  // sqrt(Q(x) / trace A); if the quadric is empty, the RMS distance of the vertices. x is relative.
  double GeometricErrorAt(const Vec3& x) const;
};

}
