// SPDX-License-Identifier: BSD-3-Clause
// Writes a store: step "store" of the pipeline picture. The file appears whole or not at all.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/Result.h"
#include "filters/store/Store.h"

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <vector>

namespace kdstream
{

// Writes to a temporary file beside the store; Finish makes the file durable (fsync) and renames
// it. If a writer is destroyed before that, it removes its file. Permissions: see NewFile.h. The
// error for a full disk tells how much space the store needs.
class StoreWriter
{
public:
  // info: everything except the digest, the counts of bytes and pieces, and the scalars; the writer
  // fills these in.
  static Result<std::unique_ptr<StoreWriter>> Create(
    const std::filesystem::path& store, ModelDescription info);
  ~StoreWriter();

  // Call the functions in the order of the digest. First add the pieces, coarse to fine, nodes
  // ascending; then the textures of levels, fine to coarse; then all boxes of partitions; then all
  // tree pages, ascending. REQUIRES: pieces of the original have the arrays whose ranges are
  // gathered (ScalarStatistics.h); other arrays are not used. Errors: LimitExceeded for a blob that
  // is too large for servers to send; InputOutput.
  Status AddPiece(const Piece& piece, std::span<const std::uint8_t> data);
  // For textured models (info.textures): add the texture of a partition directly after its piece.
  // texels: of the texture's picture. Errors: as AddPiece.
  Status AddTexture(
    std::uint32_t partition, std::span<const std::uint8_t> data, std::uint64_t texels);

  // Only for models whose levels have textures (info.textures->levels).
  Status AddLevelTexture(PieceId piece, std::span<const std::uint8_t> data, std::uint64_t texels);

  // Returns the blob of a piece that was added, or its texture. Any number of threads may call them
  // while nothing is added. Errors: InputOutput.
  Result<std::vector<std::uint8_t>> ReadPiece(PieceId piece) const;
  Result<std::vector<std::uint8_t>> ReadTexture(PieceId piece) const;

  Status AddBoxes(NodeId node, std::span<const std::uint8_t> data);
  Status AddTreePage(NodeId page, std::span<const std::uint8_t> data);

  // For models with unused vertices (info.unused): add the parts of the list (UnusedList.h) in
  // order, after all tree pages. Finds the farthest vertex. Errors: as AddPiece.
  Status AddUnused(const Piece& part, std::span<const std::uint8_t> data);

  // The facts about the added pieces that tree pages store.
  const PieceTable& Pieces() const;

  // The blob of the piece that viewers show first; empty until it is added.
  const std::vector<std::uint8_t>& Preview() const;
  // Sets the up direction and the first view. Call it before Finish, or not at all.
  void SetHomeView(const HomeView& homeView);

  // Call this when all pieces of a resolution are written; `triangles`: of the resolution, each
  // counted once. The original comes last; its call also finds upper bounds of its distance from
  // each level (LevelBounds.h). Errors: InputOutput; Cancelled.
  Status FinishResolution(
    Resolution resolution, std::uint64_t triangles, const Execution& execution = {});

  // Finishes the store, and returns the metadata as stored.
  Result<ModelDescription> Finish();

private:
  struct State;
  explicit StoreWriter(std::unique_ptr<State> state);
  std::unique_ptr<State> S;
};

}
