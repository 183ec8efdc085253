// SPDX-License-Identifier: BSD-3-Clause
// What a piece's id and the counts in its blob's head say about the arrays that follow, the piece's
// content as symbols (PieceReader.h, PieceWriter.h).
#pragma once

#include "filters/codec/TriangleWalk.h"
#include "filters/core/pieces/Piece.h"

#include <cstddef>
#include <cstdint>

namespace kdstream
{

// Which ancestors a piece stores: the ranks of the ancestors of a number of its vertices, at
// consecutive levels.
struct AncestorShape
{
  std::size_t vertices = 0, levels = 0;
  bool ofAll = false; // of all the piece's vertices: then its triangles tell which have one parent
};

struct PieceShape
{
  PieceId id;
  TreeDepths depths;
  WalkCounts counts = {};
  std::size_t steps = 0;      // of the walk
  std::size_t childNodes = 0; // nodes in the lists of all vertices

  std::size_t Vertices() const { return this->counts.Vertices(); }
  bool IsOriginal() const { return this->id.resolution.IsOriginal(); }
  bool IsBelowStitch() const
  {
    return this->id.resolution < Resolution::Level(this->depths.stitch);
  }
  bool HasChildNodes() const { return kdstream::HasChildNodes(this->id.resolution, this->depths); }
  AncestorShape Ancestors() const
  {
    const AncestorLevels levels = AncestorLevelsOf(this->id.resolution, this->depths);
    if (levels.count == 0)
    {
      return {};
    }
    return { levels.Rows(this->counts.own, this->counts.ghosts), levels.count, levels.own };
  }
};

}
