// SPDX-License-Identifier: BSD-3-Clause
// The little of SQLite that a store needs: a connection and a statement that close themselves, and
// its errors as ours. For filters/store, and the quotas of a server.
#pragma once

#include "filters/core/Result.h"

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>

struct sqlite3;
struct sqlite3_stmt;

namespace kdstream
{

struct CloseDatabase
{
  void operator()(sqlite3* database) const;
};
using Database = std::unique_ptr<sqlite3, CloseDatabase>;

// The file of an open descriptor, which must stay open as long as the database. Read-only and
// immutable: no journal is looked for, no lock is taken, pages that were read are kept.
Result<Database> OpenForReading(int descriptor);
Result<Database> OpenForWriting(const std::filesystem::path& file);

// What went wrong in the last call on `database`, in our words: SQLite's are about databases, and
// to people a store is a file. Of code `code` unless another one says it better.
Error SqliteError(sqlite3* database, ErrorCode code);

Status Execute(sqlite3* database, const std::string& sql);
Result<std::int64_t> QueryInteger(sqlite3* database, const std::string& sql);

// A prepared statement. Bind from parameter 1, Step, read columns from 0, Reset.
class Statement
{
public:
  static Result<Statement> Prepare(sqlite3* database, const char* sql);

  void Bind(int parameter, std::int64_t value);
  void Bind(int parameter, std::string_view value);
  void Bind(int parameter, std::span<const std::uint8_t> value);
  // True for a row, false at the end. Errors: Damaged.
  Result<bool> Step();
  void Reset();

  std::int64_t Integer(int column) const;
  std::string Text(int column) const;
  std::span<const std::uint8_t> Blob(int column) const; // valid until Step or Reset

private:
  struct Finalize
  {
    void operator()(sqlite3_stmt* statement) const;
  };
  std::unique_ptr<sqlite3_stmt, Finalize> Handle;
};

}
