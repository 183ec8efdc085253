// SPDX-License-Identifier: BSD-3-Clause
// Writes a piece's content as symbols, in the order of the format: doc/formats.md, "A piece".
#pragma once

#include "filters/codec/AncestorTable.h"
#include "filters/codec/CoordinateGrid.h"
#include "filters/codec/PieceNumbering.h"
#include "filters/codec/PieceShape.h"
#include "filters/codec/PositionPredictor.h"
#include "filters/codec/SymbolCoder.h"
#include "filters/codec/TriangleWalk.h"
#include "filters/codec/WalkWriter.h"
#include "filters/core/pieces/Piece.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace kdstream
{

class PieceWriter
{
public:
  // All arguments must live as long as the writer.
  PieceWriter(
    SymbolWriter& symbols, const Piece& piece, const PieceShape& shape, const CoordinateGrid& grid)
    : Symbols(symbols)
    , Content(piece)
    , Shape(shape)
    , Grid(grid)
    , Walk(piece.triangles, shape.counts)
  {
  }

  // Call it once.
  void Write();

  // After Write: the number of steps of the walk, which is in the blob's head.
  std::size_t StepCount() const { return this->Walk.StepCount(); }

private:
  template <class Predictor>
  void WriteVertices();
  void WriteArray(std::size_t context, const std::vector<std::uint64_t>& values);
  void WriteOwnKeys();
  void WriteAncestors();
  void WriteParents(bool ofVertices, const AncestorTable& table,
    const std::vector<std::uint32_t>& parents, SiblingGroups& groups);
  void WriteChildNodes();
  void WriteAttribute(std::size_t number);

  SymbolWriter& Symbols;
  const Piece& Content;
  const PieceShape& Shape;
  const CoordinateGrid& Grid;
  WalkWriter Walk;
};

// ---- The numbers of vertices (NumberingWriter.cxx)

// Writes the groups of own vertices. For each vertex of the walk: `points` has its coordinates as
// they are coded, `numbers` its number in the piece. own: the number of own vertices.
void WriteGroups(SymbolWriter& symbols, std::span<const WalkVertex> vertices,
  std::span<const Vec3> points, std::span<const VertexId> numbers, std::size_t own);

// Writes the keys of ghosts. keys: of all vertices of the piece.
void WriteGhosts(SymbolWriter& symbols, std::span<const WalkVertex> vertices,
  std::span<const VertexKey> keys, std::span<const VertexId> numbers);

// Writes the positions, as differences from a predictor's values (PositionWriter.cxx). points: of
// each vertex. Chooses the mode that takes the fewest bits; one mode is prediction by planes, if
// allowed. Deterministic.
template <class Predictor>
void WritePositions(SymbolWriter& symbols, const CoordinateGrid& grid,
  std::span<const WalkVertex> vertices, const typename Predictor::Point* points, bool mayUsePlanes);

}
