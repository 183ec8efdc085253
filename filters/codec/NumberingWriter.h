// SPDX-License-Identifier: BSD-3-Clause
// Writes which of a piece's numbers each vertex of the walk has (PieceNumbering.h).
#pragma once

#include "filters/codec/PieceNumbering.h"
#include "filters/codec/SymbolCoder.h"

#include <cstddef>
#include <span>

namespace kdstream
{

// Writes the groups of own vertices. points: of each vertex of the walk, its coordinates as they
// are coded. numbers: the piece's number of each. own: how many own vertices there are.
void WriteGroups(SymbolWriter& symbols, std::span<const WalkVertex> vertices,
  std::span<const Vec3> points, std::span<const VertexId> numbers, std::size_t own);

// Writes the keys of ghosts. keys: of the piece's vertices.
void WriteGhosts(SymbolWriter& symbols, std::span<const WalkVertex> vertices,
  std::span<const VertexKey> keys, std::span<const VertexId> numbers);

}
