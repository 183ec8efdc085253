// SPDX-License-Identifier: BSD-3-Clause
// A store: one SQLite file NAME.kds that holds tree and pieces of one model. Reading. Layout:
// doc/formats.md.
#pragma once

#include "filters/codec/TreePage.h"
#include "filters/core/Result.h"
#include "filters/core/pieces/Piece.h"
#include "filters/model/ModelDescription.h"
#include "filters/store/PieceSource.h"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace kdstream
{

struct BlobRow;   // StoreConnection.h
struct FileState; // StoreFile.h

// Reads one store. Any number of threads may read at once. The store is the file that was opened,
// by one descriptor: if another file takes its name, reads continue from the old one. If the file
// itself is written to or truncated (its size, times or digest differ), every read fails from then
// on.
class Store final : public PieceSource
{
public:
  // Opens and checks the metadata; waits if the file was changed in the last 20 ms. The file may be
  // hostile: whatever its content, this takes at most 40 MiB, which metadata of 1 MiB need, and the
  // time to read these. Errors: NotFound; InvalidInput if it is not a store, naming what it has;
  // Damaged, naming the damage; Unsupported for another store version; InputOutput if the file
  // cannot be opened or is being written; LimitExceeded if there is not enough memory.
  static Result<std::shared_ptr<Store>> Open(const std::filesystem::path& file);
  ~Store() override;

  const ModelDescription& Info() const override { return this->Information; }

  // Checks that the file is still the one that was opened, as every read does afterwards. Errors:
  // Changed; InputOutput and LimitExceeded if this cannot be found out.
  Status CheckUnchanged() const;
  // The same without waiting for a disk; nothing if that is not possible.
  std::optional<bool> LooksUnchanged() const;
  // What the file says of its content without being read.
  FileState State() const;
  // Whether the path `file` leads to the very file that is open, unchanged.
  bool IsFile(const std::filesystem::path& file) const;

  // An encoded blob; its checksum is verified. Errors: NotFound if the model has no such blob;
  // Damaged (naming the blob) if bytes are wrong; Changed if the file is no longer the one that was
  // opened; InputOutput and LimitExceeded if the same may succeed later (the disk, memory).
  Result<std::vector<std::uint8_t>> Read(
    const protocol::BlobId& blob, const Execution& execution = {}) const override;
  // How many bytes it has; they are neither read nor checked.
  Result<std::uint64_t> Size(const protocol::BlobId& blob) const;

  // A part of the list of vertices that no triangle uses (UnusedList.h), encoded, and decoded: a
  // cloud with the model's point arrays. Errors: also Damaged if it has another length than it must
  // have, or other arrays.
  Result<std::vector<std::uint8_t>> ReadUnusedBlob(std::uint32_t part) const;
  Result<Piece> ReadUnused(std::uint32_t part) const;

  // Decoded.
  Result<Piece> ReadPiece(PieceId id) const;
  Result<std::vector<Piece>> ReadPieces(
    std::span<const PieceId> ids, const Execution& execution = {}) const override;
  // The exact boxes of nodes 1 … 2^(P+1) - 1, heap order.
  Result<std::vector<Box>> ReadBoxes(const Execution& execution = {}) const override;

  // Ids of every piece the model has, coarse to fine, nodes ascending.
  std::vector<PieceId> PieceIds() const;

  // What a damaged part of that list is called: "unused/0".
  static std::string UnusedName(std::uint32_t part);

  // Reads and checks everything, the digest too. Returns the names of damaged parts with the
  // reasons; empty if the store is whole. Stops if very much is damaged, with an error that says
  // so. Memory: that of the tree, and only after all of its boxes have been read, however large a
  // tree the store claims.
  std::vector<Error> Verify(const Execution& execution = {}) const;

private:
  class Connection;
  Store();
  class Verification;
  Result<Piece> Decode(std::span<const std::uint8_t> blob, PieceId id) const;
  Result<Piece> DecodeUnused(std::span<const std::uint8_t> blob, std::uint32_t part) const;
  // Calls `visit` for each of PieceIds, until it fails.
  Status VisitPieceIds(const std::function<Status(PieceId)>& visit) const;
  bool AttributesFit(const Piece& piece) const;
  Result<BlobRow> RowOf(const protocol::BlobId& blob) const;
  std::string NameOfRow(std::int64_t row) const;
  std::unique_ptr<Connection> Database;
  ModelDescription Information;
};

}
