// SPDX-License-Identifier: BSD-3-Clause
// The sizes of the arrays of a piece's content. They follow from the piece's id and the counts in
// its blob's head. For PieceReader.h and PieceWriter.h.
#pragma once

#include "filters/codec/TriangleWalk.h"
#include "filters/core/pieces/Piece.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace kdstream
{

// The ancestors that a piece stores: their ranks at `levels` consecutive levels, for `vertices` of
// its vertices.
struct AncestorShape
{
  std::size_t vertices = 0, levels = 0;
  bool ofAll = false; // of all vertices: then triangles show which share a parent
};

struct PieceShape
{
  PieceId id;
  TreeDepths depths;
  WalkCounts counts = {};
  std::size_t steps = 0;              // of the walk
  std::size_t childNodes = 0;         // total length of the lists of all vertices
  std::vector<std::uint8_t> coarse{}; // for each attribute: 1 if it is of coarse colours, else 0

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
