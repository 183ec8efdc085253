// SPDX-License-Identifier: BSD-3-Clause
// Pieces on their way from the cutter into a store: steps "cut" and "encode" of the pipeline
// picture.
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

// Most pieces in memory at one time, encoded or waiting to be written. Large pieces are limited by
// their vertices together (one piece is always allowed).
inline constexpr std::size_t encodeBatch = 64;
inline constexpr std::size_t encodeBatchVertices = std::size_t{ 1 } << 17;

// How pieces become bytes. textures: of the original's; null: there are none.
struct PieceEncoding
{
  const CodecContext& codec;
  const PieceTextures* textures = nullptr;
};

struct EncodedPiece
{
  Piece piece; // without paint, where there are textures
  std::vector<std::uint8_t> blob;
  std::optional<EncodedTexture> texture{};
};

// Adds it, and its texture. Errors: those of the writer.
Status AddToStore(StoreWriter& writer, const EncodedPiece& encoded);

// Takes a piece and its bytes. Errors end the work.
using PieceSink = std::function<Status(const EncodedPiece&)>;

// Cuts and encodes the first `count` pieces of a cutter, a batch at a time on all threads, and
// gives them to `add` in order; `done`: as `written` of WritePieces.
Status EncodePieces(const PieceCutter& cutter, std::size_t count, const PieceEncoding& encoding,
  const PieceSink& add, StepClock& clock, const Execution& execution,
  const std::function<Status(std::size_t)>& done);

// Cuts, encodes and writes the first `count` pieces of a cutter, a batch at a time on all threads:
// while one batch is written, by any thread, the next is encoded. written(i): called when pieces up
// to the i-th are written; it may stop the work. Errors: those of the writer, of textures and of
// `written`.
Status WritePieces(const PieceCutter& cutter, std::size_t count, const PieceEncoding& encoding,
  StoreWriter& writer, StepClock& clock, const Execution& execution,
  const std::function<Status(std::size_t)>& written);

// The progress of step "encode" when the part `done` (0-1) of a resolution is written. Levels come
// first. Each has about twice the clusters of the level before; together they have about a third of
// the original's vertices.
double EncodedPart(Resolution resolution, const TreeDepths& depths, double done);

// The exact boxes of the partitions, and all pages of the tree. boxes: heap order. REQUIRES: all
// pieces are written.
Status WriteTreePages(const std::vector<Box>& boxes, const TreeDepths& depths, StoreWriter& writer);

}
