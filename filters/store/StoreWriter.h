// SPDX-License-Identifier: BSD-3-Clause
// Writing a store: step "store" of the pipeline picture. The file appears whole or not at all.
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

// Writes to a temporary file beside the store; Finish makes it durable (fsync) and renames it. A
// writer that is destroyed before that removes its file. Permissions: see NewFile.h. The error of a
// full disk says how much the store needs.
class StoreWriter
{
public:
  // info: everything except the digest, the counts of bytes and pieces, and the scalars, which the
  // writer adds.
  static Result<std::unique_ptr<StoreWriter>> Create(
    const std::filesystem::path& store, ModelDescription info);
  ~StoreWriter();

  // First add the pieces, coarse to fine, nodes ascending; then the textures of levels, fine to
  // coarse; then all boxes of partitions, then all tree pages, ascending: the order of the digest.
  // REQUIRES: pieces of the original have the arrays whose ranges are gathered
  // (ScalarStatistics.h); other arrays are not used. Errors: LimitExceeded for a blob that servers
  // would not send; InputOutput.
  Status AddPiece(const Piece& piece, std::span<const std::uint8_t> data);
  // For textured models (info.textures): add the texture directly after the piece of the partition.
  // texels: of its picture. Errors: as AddPiece.
  Status AddTexture(
    std::uint32_t partition, std::span<const std::uint8_t> data, std::uint64_t texels);

  // Only for models whose levels have textures (info.textures->levels).
  Status AddLevelTexture(PieceId piece, std::span<const std::uint8_t> data, std::uint64_t texels);

  // The blob of a piece that was added, or its texture. Any number of threads, while nothing is
  // added. Errors: InputOutput.
  Result<std::vector<std::uint8_t>> ReadPiece(PieceId piece) const;
  Result<std::vector<std::uint8_t>> ReadTexture(PieceId piece) const;

  Status AddBoxes(NodeId node, std::span<const std::uint8_t> data);
  Status AddTreePage(NodeId page, std::span<const std::uint8_t> data);

  // For models with unused vertices (info.unused): add the parts of the list (UnusedList.h) after
  // all tree pages, from the first on. Finds the farthest vertex. Errors: as AddPiece.
  Status AddUnused(const Piece& part, std::span<const std::uint8_t> data);

  // What tree pages store about the pieces that were added.
  const PieceTable& Pieces() const;

  // The blob of the piece that viewers show first; empty before that was added.
  const std::vector<std::uint8_t>& Preview() const;
  // How the model stands; called before Finish, or not at all.
  void SetHomeView(const HomeView& homeView);

  // Call this when all pieces of a resolution are written; `triangles`: of the resolution, each
  // counted once. The original comes last: then finds upper bounds of its distance from each level
  // (LevelBounds.h). Errors: InputOutput; Cancelled.
  Status FinishResolution(
    Resolution resolution, std::uint64_t triangles, const Execution& execution = {});

  // Returns the metadata as stored.
  Result<ModelDescription> Finish();

private:
  struct State;
  explicit StoreWriter(std::unique_ptr<State> state);
  std::unique_ptr<State> S;
};

}
