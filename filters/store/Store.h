// SPDX-License-Identifier: BSD-3-Clause
// Reads a store: one SQLite file NAME.kds that holds the tree and the pieces of one model. Layout:
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

// Reads one store. Any number of threads may read at the same time. One descriptor stays open: if
// another file takes the store's name, reads continue from the old file. If the file itself is
// written to or truncated (its size, times or digest differ), every read fails from then on.
class Store final : public PieceSource
{
public:
  // Opens a store and checks the metadata; waits if the file was changed in the last 20 ms. The
  // file may be hostile: whatever its content, this takes at most 40 MiB (which metadata of 1 MiB
  // need) and the time to read the metadata. Errors: NotFound; InvalidInput if it is not a store,
  // naming what it contains instead; Damaged, naming the damage; Unsupported for another store
  // version; InputOutput if the file cannot be opened or is being written; LimitExceeded if there
  // is not enough memory.
  static Result<std::shared_ptr<Store>> Open(const std::filesystem::path& file);
  ~Store() override;

  const ModelDescription& Info() const override { return this->Information; }

  // Checks that the file is still the one that was opened; every read does this afterwards. Errors:
  // Changed; InputOutput and LimitExceeded if the check fails.
  Status CheckUnchanged() const;
  // The same without waiting for a disk; nothing if that is not possible.
  std::optional<bool> LooksUnchanged() const;
  // The state of the file (size, times), without reading it.
  FileState State() const;
  // Whether the path `file` leads to the very file that is open, and the file is unchanged.
  bool IsFile(const std::filesystem::path& file) const;

  // Returns an encoded blob; its checksum is verified. Errors: NotFound if the model has no such
  // blob; Damaged, naming the blob, if bytes are wrong; Changed if the file is no longer the one
  // that was opened; InputOutput and LimitExceeded if the same call may succeed later (the disk,
  // memory).
  Result<std::vector<std::uint8_t>> Read(
    const protocol::BlobId& blob, const Execution& execution = {}) const override;
  // The size of a blob in bytes; the blob is neither read nor checked.
  Result<std::uint64_t> Size(const protocol::BlobId& blob) const;

  // A part of the list of vertices that no triangle uses (UnusedList.h): encoded, or decoded as a
  // cloud with the model's point arrays. Errors: also Damaged if the length or the arrays are
  // wrong.
  Result<std::vector<std::uint8_t>> ReadUnusedBlob(std::uint32_t part) const;
  Result<Piece> ReadUnused(std::uint32_t part) const;

  // Returns a decoded piece.
  Result<Piece> ReadPiece(PieceId id) const;
  Result<std::vector<Piece>> ReadPieces(
    std::span<const PieceId> ids, const Execution& execution = {}) const override;
  // The exact boxes of nodes 1 … 2^(P+1) - 1, in heap order.
  Result<std::vector<Box>> ReadBoxes(const Execution& execution = {}) const override;

  // The ids of all pieces of the model: coarse to fine, nodes ascending.
  std::vector<PieceId> PieceIds() const;

  // The name of a part of the list of unused vertices, for messages: "unused/0".
  static std::string UnusedName(std::uint32_t part);

  // Reads and checks everything, including the digest. Returns the names of damaged parts with the
  // reasons; empty if the store is whole. If very much is damaged it stops, with an error that says
  // so. Memory: that of the tree, allocated only after all of its boxes have been read, however
  // large a tree the store claims.
  std::vector<Error> Verify(const Execution& execution = {}) const;

private:
  class Connection;
  Store();
  class Verification;
  Result<Piece> Decode(std::span<const std::uint8_t> blob, PieceId id) const;
  Result<Piece> DecodeUnused(std::span<const std::uint8_t> blob, std::uint32_t part) const;
  // Calls `visit` for each of PieceIds, until a call fails.
  Status VisitPieceIds(const std::function<Status(PieceId)>& visit) const;
  bool AttributesFit(const Piece& piece) const;
  Result<BlobRow> RowOf(const protocol::BlobId& blob) const;
  std::string NameOfRow(std::int64_t row) const;
  std::unique_ptr<Connection> Database;
  ModelDescription Information;
};

}
