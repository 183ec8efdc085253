// SPDX-License-Identifier: BSD-3-Clause
// Reads a piece's content from symbols, in the order of the format: doc/formats.md, "A piece".
#pragma once

#include "filters/codec/AncestorTable.h"
#include "filters/codec/CoordinateGrid.h"
#include "filters/codec/PieceShape.h"
#include "filters/codec/RecentRanks.h"
#include "filters/codec/SymbolCoder.h"
#include "filters/codec/WalkReader.h"
#include "filters/core/pieces/Piece.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace kdstream
{

class PieceReader
{
public:
  // piece: has its id and primitive, and its attributes without values. All arguments must live as
  // long as the reader.
  PieceReader(
    SymbolReader& symbols, Piece& piece, const PieceShape& shape, const CoordinateGrid& grid)
    : Symbols(symbols)
    , Content(piece)
    , Shape(shape)
    , Grid(grid)
    , Walk(shape.counts)
  {
  }

  // Call it once. Returns null, or what is wrong with the symbols. Does not find everything that
  // CheckPiece finds.
  const char* Read();

private:
  template <class Predictor>
  bool ReadVertices();
  bool ReadExactVertices();
  template <class Predictor>
  bool ReadPoints(typename Predictor::Point* points);
  void PlaceTriangles();
  bool ReadArray(std::size_t context, std::vector<std::uint64_t>& values, std::uint64_t most);
  bool ReadOwnKeys();
  bool ReadAncestors();
  bool ReadParents(bool ofVertices, const AncestorTable& table, std::vector<std::uint32_t>& parents,
    SiblingGroups& groups);
  bool ReadRank(std::size_t context, RecentRanks& recent, std::uint32_t& parent);
  bool ReadChildNodes();
  void ReadAttribute(std::size_t number);

  SymbolReader& Symbols;
  Piece& Content;
  const PieceShape& Shape;
  const CoordinateGrid& Grid;
  WalkReader Walk;
  std::vector<VertexId> Numbers; // in the piece, of each vertex of the walk
};

}
