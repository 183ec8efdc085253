// SPDX-License-Identifier: BSD-3-Clause
// Which points of a surface stood for vertices that came after it: only for SurfaceParts.cxx.
#pragma once

#include "filters/core/drawing/SurfaceParts.h"

#include <cstdint>
#include <optional>
#include <span>

namespace kdstream
{

// What is known of the nodes above a vertex.
struct Lineage
{
  // The key of the vertex's cluster of level S, or its own key.
  std::optional<VertexKey> stitch;
  std::span<const std::uint32_t> ranks; // at the levels R … S - 1, R first
};

// If pieces contradict each other, it may find any point.
class ParentSurface
{
public:
  // Both arguments must outlive the object.
  ParentSurface(const SurfacePartList& parts, const TreeDepths& depths)
    : Parts(parts)
    , Depths(depths)
  {
  }

  // An own vertex of a piece, where it was shown itself. O(log points).
  std::optional<ParentPoint> Find(PieceId piece, std::uint32_t vertex) const;
  // The vertex itself if it was shown, else the finest node above it that was shown. O(log points)
  // for each level.
  std::optional<ParentPoint> FindAbove(const Surface::Source& vertex, const Lineage& lineage) const;

private:
  VertexKey LeastOf(VertexKey key) const;
  std::optional<ParentPoint> FindInterval(
    Resolution resolution, VertexKey key, VertexKey least) const;
  std::optional<ParentPoint> FindRank(unsigned level, VertexKey rank) const;
  std::optional<ParentPoint> LastUpTo(SurfacePartList::const_iterator part, VertexKey key) const;

  const SurfacePartList& Parts;
  const TreeDepths& Depths;
};

}
