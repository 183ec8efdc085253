// SPDX-License-Identifier: BSD-3-Clause
// Finds which point of an earlier surface stood for a vertex of a later one. Only for
// SurfaceParts.cxx.
#pragma once

#include "filters/core/drawing/SurfaceParts.h"

#include <cstdint>
#include <optional>
#include <span>

namespace kdstream
{

// What is known of a vertex's ancestors.
struct Lineage
{
  // The key of the vertex's cluster of level S, or its own key.
  std::optional<VertexKey> stitch;
  std::span<const std::uint32_t> ranks; // at the levels R … S - 1, R first
};

// If pieces contradict each other, any point may be found.
class ParentSurface
{
public:
  // Both arguments must outlive the object.
  ParentSurface(const SurfacePartList& parts, const TreeDepths& depths)
    : Parts(parts)
    , Depths(depths)
  {
  }

  // The point of an own vertex of a piece, if the vertex itself was shown. O(log points).
  std::optional<ParentPoint> Find(PieceId piece, std::uint32_t vertex) const;
  // The point of the vertex itself if it was shown, otherwise of the finest ancestor that was
  // shown. O(log points) for each level.
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
