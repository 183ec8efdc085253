// SPDX-License-Identifier: BSD-3-Clause
// What the counts in a blob's head, and its id, say about the arrays that follow: a piece's content
// as symbols (PieceReader.h, PieceWriter.h).
#pragma once

#include "filters/codec/TriangleWalk.h"
#include "filters/core/pieces/Piece.h"

#include <cstddef>
#include <cstdint>

namespace kdstream
{

struct PieceShape
{
  PieceId id;
  TreeDepths depths;
  WalkCounts counts = {};
  std::size_t steps = 0; // of the walk
  std::size_t reach = 0; // nodes in the lists of all vertices

  std::size_t Vertices() const { return this->counts.Vertices(); }
  bool IsOriginal() const { return this->id.resolution.IsOriginal(); }
  bool IsBelowStitch() const
  {
    return this->id.resolution < Resolution::Level(this->depths.stitch);
  }
  bool IsStitch() const { return this->id.resolution == Resolution::Level(this->depths.stitch); }
  // Vertices that carry the ranks of their ancestors: at S all, finer only the ghosts.
  std::size_t Carriers() const
  {
    return this->IsBelowStitch() ? 0 : (this->IsStitch() ? this->Vertices() : this->counts.ghosts);
  }
};

// Deviations are told as ordered bits of floats, without the low bits that are 0 in all: at most so
// many of them, and at most those of the greatest float.
inline constexpr unsigned mostDeviationShift = 31;
inline constexpr std::uint64_t mostDeviationBits = 0xFF7FFFFF;

}
