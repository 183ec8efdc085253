// SPDX-License-Identifier: BSD-3-Clause
// One surface from many resolutions: the drawing rule (doc/design.md#the-cut-rule). Step "draw" of
// the README's picture.
//
// What is shown is a cut of the vertex tree: every original vertex has exactly one node of the cut
// above it. The drawn surface is the image of the mesh under that map, so it has neither cracks nor
// overlaps, whatever mix of resolutions is shown.
#pragma once

#include "filters/core/Result.h"
#include "filters/core/pieces/Piece.h"

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

namespace kdstream
{

// A cut: a base resolution for everything, and finer ones for single partitions.
// Where the base is coarser than S and a partition is refined, the rest of every base cluster that
// has an original in a refined partition is shown at level S (the "split" clusters).
struct Cut
{
  TreeDepths depths;
  Resolution base;
  // One entry a partition: its resolution, >= S, or nothing = the base. May be empty: nothing is
  // refined.
  std::vector<std::optional<Resolution>> refined;

  std::optional<Resolution> RefinedTo(std::uint32_t partition) const
  {
    return this->refined.empty() ? std::nullopt : this->refined[partition];
  }
};

// Errors: InvalidArgument where a partition is refined to a level below S, where the list
// has neither 0 nor 2^P entries, or the base is finer than L and not the original.
Status CheckCut(const Cut& cut);

// Finds a loaded piece, or null.
using PieceLookup = std::function<const Piece*(PieceId)>;

// The pieces that drawing `cut` needs and `lookup` does not find, ascending. Which level-S pieces a
// split needs is known only once the pieces that split are loaded: call again when these have come,
// until the answer is empty.
std::vector<PieceId> MissingPieces(const Cut& cut, const PieceLookup& lookup);

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
  std::vector<Triangle> triangles; // sorted, lowest index first; one kept of each orientation
  // The point arrays that every piece with a point here has, a tuple a point.
  std::vector<Attribute> attributes{};
};

// Draws the cut from loaded pieces, by the rule: a piece's triangle is drawn if at least one of its
// vertices is itself in the cut and none lies above the cut; each of the others is moved up to its
// node in the cut; what becomes degenerate is dropped; where triangles fall together one is kept of
// each orientation. Complexity O(T log T) for T triangles in the pieces used, in practice nearly
// O(T). Errors: NotFound where MissingPieces is not empty.
Result<Surface> DrawSurface(const Cut& cut, const PieceLookup& lookup);

}
