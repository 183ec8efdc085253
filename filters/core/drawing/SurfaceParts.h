// SPDX-License-Identifier: BSD-3-Clause
// Makes the surface of a cut piece by piece, so that the next cut costs only the differences. Step
// "draw" of the pipeline picture.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/Result.h"
#include "filters/core/drawing/Surface.h"
#include "filters/core/drawing/SurfaceTree.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace kdstream
{

// The part of a surface that comes from one piece: its own vertices that are in the cut, and every
// triangle whose finest corner is one of them (among equally fine corners, the one of the lowest
// key). So each triangle of the surface is in exactly one part, and each point is owned by exactly
// one part.
struct SurfacePart
{
  // A corner that another part owns.
  struct Borrowed
  {
    PieceId piece;
    std::uint32_t vertex = 0; // own vertex of that piece
    auto operator<=>(const Borrowed&) const = default;
  };

  PieceId piece;
  // The own points, in the order of the piece's vertices, then borrowed ones, ascending. Triangles
  // are sorted and have their lowest index first. The surface can be drawn by itself.
  Surface surface;
  std::vector<std::uint32_t> own; // for each own point its vertex of the piece
  std::vector<Borrowed> borrowed;
  // For each triangle, from which corner of the piece's triangles its first corner comes: 3 × the
  // number of that triangle + 0 to 2. The other corners follow in turn. If several triangles have
  // become one, this refers to the first of them. Empty unless SurfaceParts::KeepCorners is set.
  std::vector<std::uint32_t> corners;

  // The box of `surface`, in O(n), and its tree, in O(n log n). Made at the first call; after that
  // `surface` must not change. One thread at a time.
  const Box& Bounds() const;
  const SurfaceTree& Tree() const;

private:
  mutable std::optional<Box> KeptBounds;
  mutable std::optional<SurfaceTree> KeptTree;
};

// In the order of the pieces; pieces that show nothing are left out.
using SurfacePartList = std::vector<std::shared_ptr<const SurfacePart>>;

// The part of a piece, or the end. O(log parts).
SurfacePartList::const_iterator FindPart(const SurfacePartList& parts, PieceId piece);

// A point of the previous parts: the number of the part, and of the point in it.
struct ParentPoint
{
  std::uint32_t part = 0, point = 0;
  bool operator==(const ParentPoint&) const = default;
};
// For each point of a part, which vertex showed it before: the same vertex, or an ancestor. No
// value if only finer vertices were shown, or if it is unknown.
using ParentPoints = std::vector<std::optional<ParentPoint>>;

class ShownVertices;

// Makes the parts of one cut after the other. A part that does not change stays the same object: so
// compare pointers to find out whether data made from a part (a buffer in graphics memory) are
// still valid.
class SurfaceParts
{
public:
  SurfaceParts();
  ~SurfaceParts();
  SurfaceParts(SurfaceParts&&) noexcept;
  SurfaceParts& operator=(SurfaceParts&&) noexcept;

  // Changes to a cut of loaded pieces, by the rule of DrawSurface. The pieces need not stay loaded
  // afterwards. The first call takes O(T log T) for T triangles of the pieces, in practice nearly
  // O(T). Later calls take this for the pieces where other vertices are shown than before, and
  // O(log) for each other piece. Errors: those of DrawSurface; the parts do not change then.
  // Reports "glue" after each piece. After Cancelled the parts must not be used any more.
  Status GoTo(const Cut& cut, const PieceLookup& lookup, const Execution& execution = {});

  const SurfacePartList& Parts() const { return this->All; }

  // Whether each GoTo also finds the parents of points: O(log points) for each point of the parts
  // that are rebuilt.
  void Follow(bool follows) { this->Follows = follows; }
  // Whether parts of the original, and parts of levels, get `corners` from now on, which texturing
  // needs. O(T log T) for T triangles of each.
  void KeepCorners(bool ofOriginal, bool ofLevels)
  {
    this->KeepsCorners = ofOriginal;
    this->KeepsCornersOfLevels = ofLevels;
  }
  // The parent points of each part, in order; empty if the part has not changed, or if Follow is
  // off.
  const std::vector<ParentPoints>& Parents() const { return this->ParentsOfParts; }

private:
  void FindParents(const SurfacePartList& before, const TreeDepths& depths,
    const std::vector<std::size_t>& pieces);

  std::unique_ptr<ShownVertices> View;
  SurfacePartList All;
  bool Follows = false, KeepsCorners = false, KeepsCornersOfLevels = false;
  std::vector<ParentPoints> ParentsOfParts;
};

// All parts as one surface, the same as DrawSurface gives. O(points + triangles).
Surface MergeParts(const SurfacePartList& parts);

}
