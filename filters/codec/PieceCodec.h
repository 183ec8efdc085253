// SPDX-License-Identifier: BSD-3-Clause
// A piece as bytes and back: steps "encode" and "decode" of the pipeline picture. Layout:
// doc/formats.md.
//
// Triangles are coded by a walk over the surface, positions by parallelograms along it, and
// everything becomes symbols of an entropy coder (PieceReader.h, PieceWriter.h). Compiles to
// WebAssembly. The blob ends with a checksum of itself (Seal.h). The decoder checks it first and
// does not rely on it: a well sealed blob may be hostile.
#pragma once

#include "filters/codec/CoordinateGrid.h"
#include "filters/core/Result.h"
#include "filters/core/pieces/Piece.h"

#include <cstdint>
#include <span>
#include <vector>

namespace kdstream
{

// What a decoder has to know of the model beside the blob.
struct CodecContext
{
  TreeDepths depths;
  CoordinateGrid grid;
  // For each level, the spacing of its coordinates in steps of the grid (SpacingFor). Empty: 1 for
  // all levels.
  std::vector<std::uint32_t> spacings{};
  // The number of clusters of each level: ranks are below it. Empty: not known.
  std::vector<std::uint64_t> clusters{};

  CoordinateGrid GridOf(Resolution resolution) const
  {
    return resolution.IsOriginal() || resolution.Depth() >= this->spacings.size()
             ? this->grid
             : this->grid.Spaced(this->spacings[resolution.Depth()]);
  }
};

// Bytes of the parts of a blob, in this order: the whole blob; triangles, and which of their
// vertices are ghosts; positions; numbers of own vertices; keys of own vertices; keys of ghosts;
// ancestors.
struct EncodedBytes
{
  double all = 0, triangles = 0, positions = 0, numbers = 0, ownKeys = 0, ghostKeys = 0,
         ancestors = 0;
};

// Encodes a piece without its geometric errors; a store has one geometric error for the whole
// piece. REQUIRES: CheckPiece(piece, context.depths); vertices with the same ancestor at a level
// have the same ones at all coarser levels; on a grid, positions anywhere. Deterministic; O(size).
// spent: for benchmarks.
std::vector<std::uint8_t> EncodePiece(
  const Piece& piece, const CodecContext& context, EncodedBytes* spent = nullptr);

// Decodes the blob of piece `expected`. The bytes may be hostile. The size of the blob bounds all
// lengths before memory is taken (at most 2 KiB for each byte of the blob, temporary memory
// included), and so bounds the time. The result passes CheckPiece, and its ranks are of clusters
// that the levels have. Errors: Damaged for a wrong checksum (Seal.h); InvalidInput with the byte
// offset; Unsupported for an unknown codec version.
Result<Piece> DecodePiece(
  std::span<const std::uint8_t> blob, PieceId expected, const CodecContext& context);

}
