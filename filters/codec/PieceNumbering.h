// SPDX-License-Identifier: BSD-3-Clause
// Which number each vertex of the walk has in the piece: the rules that reader (NumberingReader.h)
// and writer (NumberingWriter.cxx) share. Layout: doc/formats.md, "Groups" and "Ghosts".
//
// Own vertices are numbered so that the vertices of a cluster, which are near each other, are
// consecutive; inside a finest cluster they are numbered by place. So the numbers fall into
// *groups*: runs with strictly ascending (x, y, z). For each own vertex its group is stored, which
// is mostly the group of a neighbour; the reader sorts each group again. For each ghost its key is
// stored, which is mostly near the key of a neighbour; ghosts are numbered by ascending key.
#pragma once

#include "filters/codec/PieceContexts.h"
#include "filters/codec/TriangleWalk.h"
#include "filters/core/pieces/Piece.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace kdstream
{

// The groups of the three vertices of a gate; noVertex for a ghost.
struct GateGroups
{
  std::uint32_t first, second, third;

  KDSTREAM_IN_LOOPS GateGroups(const WalkVertex& vertex, const std::uint32_t* groups)
    : first(groups[vertex.gate[0]])
    , second(groups[vertex.gate[1]])
    , third(groups[vertex.gate[2]])
  {
  }

  // The context, which depends on which of them are equal.
  KDSTREAM_IN_LOOPS std::size_t Context() const
  {
    return contexts::groupOf + (this->first == this->second ? 1U : 0U) +
           (this->second == this->third ? 2U : 0U) + (this->first == this->third ? 4U : 0U);
  }
  // The group from which the difference is stored. last: the group that was stored last.
  KDSTREAM_IN_LOOPS std::int64_t Reference(std::uint32_t last) const
  {
    const std::uint32_t firstOwn = this->first != noVertex    ? this->first
                                   : this->second != noVertex ? this->second
                                                              : this->third;
    return firstOwn != noVertex ? firstOwn : last;
  }
};
// The symbol for a group other than the three that 0, 1 and 2 stand for.
inline constexpr unsigned otherGroup = 3;

// The key that predicts the key of ghost v: that of the first vertex of its gate that is an earlier
// ghost, otherwise that of the previous ghost (`last`). keys: of the ghosts before v.
inline VertexKey ReferenceKey(
  std::span<const WalkVertex> vertices, std::size_t v, const VertexKey* keys, VertexKey last)
{
  for (const std::uint32_t near : vertices[v].gate)
  {
    if (near < v && vertices[near].own == 0)
    {
      return keys[near];
    }
  }
  return last;
}

}
