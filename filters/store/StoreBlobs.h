// SPDX-License-Identifier: BSD-3-Clause
// How blobs are stored in the tables: cut into rows that fill SQLite's pages, with a directory of
// their beginnings; before version 13 each blob in a row of its own. Only for Store::Connection.
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
  Textures,      // where a model has them
  Unused,        // where it has unused vertices
  LevelTextures, // where pieces of levels have some; from version 14 on
};

// Where a blob is, and what errors call it.
struct BlobRow
{
  BlobTable table = BlobTable::Pieces;
  std::int64_t key = 0; // PieceRow of a piece, also of its texture of a level; a node, partition or
                        // part of the others
  std::string name;
};

// A blob of a store, or its metadata, that is not what was written.
Error DamagedBlob(const std::string& blob, const std::string& what);

// The blobs of one open database, for one thread at a time. Errors of all functions: Damaged;
// InputOutput and LimitExceeded if the same may succeed later.
class StoreBlobs
{
public:
  // Opens the blobs of a store of that version. Errors: those of a statement.
  static Result<std::unique_ptr<StoreBlobs>> Open(
    Database database, int version, const ModelDescription& model);
  virtual ~StoreBlobs() = default;

  // The blob, whose checksum holds. bytesRead: has as many added as the blob has, whole or not.
  virtual Result<std::vector<std::uint8_t>> Read(const BlobRow& blob, std::uint64_t& bytesRead) = 0;
  // How many bytes it has; they are neither read nor checked.
  virtual Result<std::uint64_t> Size(const BlobRow& blob) = 0;
  // Calls note(row, error) for each row whose columns contradict each other, as long as it returns
  // true.
  virtual Status VisitMislabelled(
    const std::function<bool(std::int64_t row, const Error& error)>& note) = 0;
  // SQLite reports a damaged page once, and then goes on with it: no more may be read after that.
  bool Failed() const { return this->HasFailed; }

protected:
  // SQLite's error about a row, as an error of the blob.
  Error Fail(const BlobRow& blob, const Error& error);

private:
  bool HasFailed = false;
};

}
