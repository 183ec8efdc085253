// SPDX-License-Identifier: BSD-3-Clause
// Moves pieces from the cutter into a store: steps "cut" and "encode" of the pipeline picture.
#pragma once

#include "filters/build/PieceTextures.h"
#include "filters/build/StepClock.h"
#include "filters/core/Execution.h"
#include "filters/core/pieces/VertexTree.h"
#include "filters/store/StoreWriter.h"

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

namespace kdstream
{

// The most pieces in memory at one time, encoded or waiting to be written. For large pieces, their
// total number of vertices is the limit (one piece is always allowed).
inline constexpr std::size_t encodeBatch = 64;
inline constexpr std::size_t encodeBatchVertices = std::size_t{ 1 } << 17;

// How pieces become bytes. textures: for the original; null: there are none.
struct PieceEncoding
{
  const CodecContext& codec;
  const PieceTextures* textures = nullptr;
};

struct EncodedPiece
{
  Piece piece; // without texture coordinates, if there are textures
  std::vector<std::uint8_t> blob;
  std::optional<EncodedTexture> texture{};
};

// Adds a piece, and its texture if there is one. Errors: those of the writer.
Status AddToStore(StoreWriter& writer, const EncodedPiece& encoded);

// Receives a piece and its bytes. An error ends the work.
using PieceSink = std::function<Status(const EncodedPiece&)>;

// Cuts and encodes the first `count` pieces of a cutter, a batch at a time on all threads, and
// passes them to `add` in order. done: as `written` of WritePieces.
Status EncodePieces(const PieceCutter& cutter, std::size_t count, const PieceEncoding& encoding,
  const PieceSink& add, StepClock& clock, const Execution& execution,
  const std::function<Status(std::size_t)>& done);

// Cuts, encodes and writes the first `count` pieces of a cutter, a batch at a time on all threads.
// While any thread writes one batch, the next is encoded. written(i): called when the first i
// pieces are written; it may stop the work. Errors: those of the writer, of textures and of
// `written`.
Status WritePieces(const PieceCutter& cutter, std::size_t count, const PieceEncoding& encoding,
  StoreWriter& writer, StepClock& clock, const Execution& execution,
  const std::function<Status(std::size_t)>& written);

// The progress of step "encode" when the share `done` (0-1) of a resolution is written. Levels come
// first. Each has about twice the clusters of the level before; all levels together have about a
// third of the original's vertices.
double EncodedPart(Resolution resolution, const TreeDepths& depths, double done);

// Writes the exact boxes of the partitions, and all pages of the tree. boxes: in heap order.
// REQUIRES: all pieces are written.
Status WriteTreePages(const std::vector<Box>& boxes, const TreeDepths& depths, StoreWriter& writer);

}
