// SPDX-License-Identifier: BSD-3-Clause
// A piece as bytes and back: steps "encode" and "decode" of the pipeline picture. Layout:
// doc/formats.md.
//
// Triangles are coded by a walk over the surface, positions by parallelograms along it, and
// everything becomes symbols of an entropy coder (PieceReader.h, PieceWriter.h). Compiles to
// WebAssembly. The blob ends with a checksum of itself (Seal.h). The decoder checks it first, but
// does not rely on it: a blob with a correct checksum can be hostile.
#pragma once

#include "filters/codec/CoordinateGrid.h"
#include "filters/core/Result.h"
#include "filters/core/pieces/Piece.h"

#include <cstdint>
#include <span>
#include <vector>

namespace kdstream
{

// What a decoder must know of the model in addition to the blob.
struct CodecContext
{
  TreeDepths depths;
  CoordinateGrid grid;
  // For each level, the spacing of its coordinates in steps of the grid (SpacingFor). Empty: 1 for
  // all levels.
  std::vector<std::uint32_t> spacings{};
  // The number of clusters of each level: ranks must be below it. Empty: not known.
  std::vector<std::uint64_t> clusters{};
  // For encoding: whether levels have coarse colours, of four bits a component. For models whose
  // levels have textures: there colours are shown only until the texture arrives.
  bool coarseColors = false;

  CoordinateGrid GridOf(Resolution resolution) const
  {
    return resolution.IsOriginal() || resolution.Depth() >= this->spacings.size()
             ? this->grid
             : this->grid.Spaced(this->spacings[resolution.Depth()]);
  }
};

// The number of bytes of a blob's parts. all: the whole blob; triangles: includes which of their
// vertices are ghosts; numbers: of own vertices.
struct EncodedBytes
{
  double all = 0, triangles = 0, positions = 0, numbers = 0, ownKeys = 0, ghostKeys = 0,
         ancestors = 0;
};

// Encodes a piece without its geometric errors; the pages of the tree have errors of whole pieces.
// REQUIRES: CheckPiece(piece, context.depths); vertices with the same ancestor at a level have the
// same ancestors at all coarser levels. On a grid, positions can be anywhere: they are moved to the
// nearest grid points; coarse colours are rounded. Deterministic; O(size). spent: for benchmarks.
std::vector<std::uint8_t> EncodePiece(
  const Piece& piece, const CodecContext& context, EncodedBytes* spent = nullptr);

// Decodes the blob of piece `expected`. The bytes may be hostile. All lengths are checked against
// the blob's size before memory is allocated (at most 2 KiB for each byte of the blob, including
// temporary memory); this bounds the time too. The result passes CheckPiece, and its ranks are of
// clusters that exist in their levels. Errors: Damaged if the checksum is wrong (Seal.h);
// InvalidInput, with the byte offset, if the content is malformed; Unsupported if the codec version
// is unknown.
Result<Piece> DecodePiece(
  std::span<const std::uint8_t> blob, PieceId expected, const CodecContext& context);

}
