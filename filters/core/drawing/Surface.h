// SPDX-License-Identifier: BSD-3-Clause
// One surface from many resolutions: the drawing rule (doc/design.md#the-cut-rule). Step "draw" of
// the pipeline picture.
//
// What is shown is a cut of the vertex tree: every original vertex has exactly one node of the cut
// above it. The drawn surface is the image of the mesh under that map, so it has neither cracks nor
// overlaps, whatever mix of resolutions is shown.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/Result.h"
#include "filters/core/drawing/Cut.h"

#include <cstdint>
#include <vector>

namespace kdstream
{

// The surface of a cut.
struct Surface
{
  struct Source // where a vertex comes from
  {
    Resolution resolution;
    VertexKey key = 0;
    auto operator<=>(const Source&) const = default;
  };
  std::vector<Vec3> points;        // every vertex of the cut, piece by piece
  std::vector<Source> sources;     // one a point
  std::vector<Triangle> triangles; // sorted, lowest index first; of equal ones, one per orientation
  // The point arrays that all pieces with a point here have; one tuple for each point.
  std::vector<Attribute> attributes{};
};

// Draws the cut from loaded pieces, by the rule (doc/design.md#the-cut-rule):
// 1. A piece's triangle is drawn if at least one of its vertices is itself in the cut and none lies
//    above the cut.
// 2. Each of its other vertices is moved up to its node in the cut.
// 3. Degenerate triangles are dropped. Of triangles that coincide, one is kept for each
//    orientation.
//
// Complexity O(T log T) for T triangles in the pieces used, in practice nearly O(T). Errors: those
// of CheckCut; NotFound if MissingPieces is not empty. If pieces contradict each other (CheckPiece
// accepts each by itself), the result has holes. Reports "glue"; Cancelled.
Result<Surface> DrawSurface(
  const Cut& cut, const PieceLookup& lookup, const Execution& execution = {});

}
