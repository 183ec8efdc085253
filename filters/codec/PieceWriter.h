// SPDX-License-Identifier: BSD-3-Clause
// Writes a piece's content as symbols, in the order of the format: doc/formats.md, "A piece".
#pragma once

#include "filters/codec/AncestorTable.h"
#include "filters/codec/CoordinateGrid.h"
#include "filters/codec/PieceShape.h"
#include "filters/codec/SymbolCoder.h"
#include "filters/codec/WalkWriter.h"
#include "filters/core/pieces/Piece.h"

#include <cstddef>
#include <cstdint>
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

  // Once.
  void Write();

  // After Write: steps of the walk, which the head tells a reader.
  std::size_t StepCount() const { return this->Walk.StepCount(); }

private:
  template <class Predictor>
  void WriteVertices();
  void WriteArray(std::size_t context, const std::vector<std::uint64_t>& values);
  void WriteOwnKeys();
  void WriteAncestors();
  void WriteParents(bool ofVertices, const AncestorTable& table,
    const std::vector<std::uint32_t>& parents, SiblingGroups& groups);
  void WriteReach();
  void WriteAttribute(std::size_t number);

  SymbolWriter& Symbols;
  const Piece& Content;
  const PieceShape& Shape;
  const CoordinateGrid& Grid;
  WalkWriter Walk;
};

}
