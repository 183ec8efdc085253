// SPDX-License-Identifier: BSD-3-Clause
// How blobs are stored in tables: cut into rows that fill SQLite's pages, with a directory of where
// each begins. Before version 13 each blob has a row of its own. Only for Store::Connection.
#pragma once

#include "filters/model/ModelDescription.h"
#include "filters/store/Sqlite.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace kdstream
{

enum class BlobTable : std::size_t
{
  Pieces,
  Tree,
  Boxes,
  Textures,      // if the model has textures
  Unused,        // if the model has unused vertices
  LevelTextures, // if pieces of levels have textures; from version 14 on
};

// Where a blob is, and its name in errors.
struct BlobRow
{
  BlobTable table = BlobTable::Pieces;
  // For pieces and textures of levels the PieceRow of the piece; for others a node, partition or
  // part.
  std::int64_t key = 0;
  std::string name;
};

// The error for a blob of a store, or its metadata, that differs from what was written.
Error DamagedBlob(const std::string& blob, const std::string& what);

// The blobs of one open database, for one thread at a time. Errors of all functions: Damaged;
// InputOutput and LimitExceeded if the same may succeed later.
class StoreBlobs
{
public:
  // Opens the blobs of a store of this version. Errors: those of a statement.
  static Result<std::unique_ptr<StoreBlobs>> Open(
    Database database, int version, const ModelDescription& model);
  virtual ~StoreBlobs() = default;

  // Returns the blob; its checksum is verified. bytesRead: increased by the size of the blob, even
  // if the checksum is wrong.
  virtual Result<std::vector<std::uint8_t>> Read(const BlobRow& blob, std::uint64_t& bytesRead) = 0;
  // The size of a blob in bytes; the blob is neither read nor checked.
  virtual Result<std::uint64_t> Size(const BlobRow& blob) = 0;
  // Calls note(row, error) for each row whose columns contradict each other. Stops when note
  // returns false.
  virtual Status VisitMislabelled(
    const std::function<bool(std::int64_t row, const Error& error)>& note) = 0;
  // Whether SQLite has reported a damaged page. It reports one only once and then continues with
  // it, so nothing more may be read afterwards.
  bool Failed() const { return this->HasFailed; }

protected:
  // Turns SQLite's error about a row into an error of the blob.
  Error Fail(const BlobRow& blob, const Error& error);

private:
  bool HasFailed = false;
};

}
