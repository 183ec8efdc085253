// SPDX-License-Identifier: BSD-3-Clause
// The surface of a cut, piece by piece, so that the next cut costs only what differs from it. Step
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

// What one piece adds to a surface: its own vertices that are in the cut, and every triangle whose
// finest corner is one of them (of equally fine corners, that of the lowest key). So each triangle
// of the surface is in one part, and one part owns each point.
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
  // The own points, in the order of the piece's vertices, then the borrowed ones, ascending.
  // Triangles are sorted and their lowest index comes first. A surface that can be drawn by itself.
  Surface surface;
  std::vector<std::uint32_t> own; // of each own point, the vertex of the piece
  std::vector<Borrowed> borrowed;
  // Of each triangle the corner of the piece's triangles that its first corner was, 3 × the number
  // of that triangle + 0 to 2; the others follow in turn. Where several have become one, the first
  // of them. Empty unless it is asked for (SurfaceParts::KeepCorners).
  std::vector<std::uint32_t> corners;

  // Of `surface`, which does not change any more; made when they are asked for first: O(n),
  // O(n log n). Threads: one at a time.
  const Box& Bounds() const;
  const SurfaceTree& Tree() const;

private:
  mutable std::optional<Box> KeptBounds;
  mutable std::optional<SurfaceTree> KeptTree;
};

// In the order of pieces; those that show nothing are left out.
using SurfacePartList = std::vector<std::shared_ptr<const SurfacePart>>;

// The part of a piece, or the end. O(log parts).
SurfacePartList::const_iterator FindPart(const SurfacePartList& parts, PieceId piece);

// A point of the parts before: the number of the part, and of its point.
struct ParentPoint
{
  std::uint32_t part = 0, point = 0;
  bool operator==(const ParentPoint&) const = default;
};
// Of each point of a part what showed it before: the same vertex, or the node above it that stood
// for it. Nothing where only what is finer was shown, or nothing is known.
using ParentPoints = std::vector<std::optional<ParentPoint>>;

class ShownVertices;

// Draws one cut after the other. A part that is the same in both stays the same object, so whoever
// keeps what was made of a part (a buffer of the graphics memory) need only compare pointers.
class SurfaceParts
{
public:
  SurfaceParts();
  ~SurfaceParts();
  SurfaceParts(SurfaceParts&&) noexcept;
  SurfaceParts& operator=(SurfaceParts&&) noexcept;

  // Goes over to a cut of loaded pieces, by the rule of DrawSurface. The pieces need not be kept.
  // The first time O(T log T) for T triangles of the pieces, in practice nearly O(T); then so much
  // for pieces some of whose vertices are shown by others than before, and O(log) for each other.
  // Errors, which leave the parts as they were: those of DrawSurface. Reports "glue", a piece a
  // step; after Cancelled the parts are of no use any more.
  Status GoTo(const Cut& cut, const PieceLookup& lookup, const Execution& execution = {});

  const SurfacePartList& Parts() const { return this->All; }

  // Whether each GoTo also finds what showed the points before: O(log points) for each point of the
  // parts that it draws anew.
  void Follow(bool follows) { this->Follows = follows; }
  // Whether parts of the original that are drawn from now on tell their triangles' corners, by
  // which they are textured. O(T log T) for T triangles of each.
  void KeepCorners(bool keeps) { this->KeepsCorners = keeps; }
  // Of each part, in their order; empty where it has stayed, or nothing is followed.
  const std::vector<ParentPoints>& Parents() const { return this->ParentsOfParts; }

private:
  void FindParents(const SurfacePartList& before, const TreeDepths& depths,
    const std::vector<std::size_t>& pieces);

  std::unique_ptr<ShownVertices> View;
  SurfacePartList All;
  bool Follows = false, KeepsCorners = false;
  std::vector<ParentPoints> ParentsOfParts;
};

// All parts as one surface, as DrawSurface tells. O(points + triangles).
Surface MergeParts(const SurfacePartList& parts);

}
