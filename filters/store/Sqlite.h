// SPDX-License-Identifier: BSD-3-Clause
// The part of SQLite that a store needs: a connection and a statement that close themselves, and
// SQLite's errors translated into ours. For filters/store, and the quotas of a server.
#pragma once

#include "filters/core/Result.h"

#include <chrono>
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

// No value and no row is larger than this: the largest blob of a store, and the other columns of
// its row.
inline constexpr int mostRowBytes = (64 << 20) + (64 << 10);

// All of these functions treat the file as hostile. Its views and triggers do not run, and its
// schema cannot call functions with side effects. Cells of pages are checked, and values are at
// most mostRowBytes. No temporary file is written, and the file is not mapped into memory. A schema
// may still contain expressions, so compare it with the expected one first.

// Opens the file of a descriptor, which must stay open as long as the database. Read-only and
// immutable: no journal and no locks; pages that were read stay in memory. The work of a statement
// until Reset is limited; beyond a limit it ends with an error of code Damaged. The limits:
// processor time of 2 s plus a second for each 50 MB of the file; a million steps plus one for each
// byte of the file.
Result<Database> OpenForReading(int descriptor);
// The same, for writing to a file that nobody else has open. There is no journal file.
Result<Database> OpenForWriting(int descriptor);
// Opens an empty file of our own for writing. A write that fails may leave it incomplete.
Result<Database> OpenEmpty(int descriptor);
// Opens a file that several programs may write to; makes the file if it does not exist. There is no
// limit on how long a statement takes.
Result<Database> OpenForWriting(const std::filesystem::path& file);
// Limits the size of all values from now on.
void LimitValues(sqlite3* database, std::size_t bytes);

// The error of the last call on `database`, in our words: SQLite's messages are about databases,
// but for users a store is a file. The error has the code `code`, unless another one fits better.
Error SqliteError(sqlite3* database, ErrorCode code);

Status Execute(sqlite3* database, const std::string& sql);
// Makes a file that several programs write to use a write-ahead log (WAL). Waits at most `patience`
// for the others; SQLite itself does not always wait for them here. Sets the busy timeout to 0; set
// it again afterwards.
Status UseWriteAheadLog(sqlite3* database, std::chrono::milliseconds patience);
Result<std::int64_t> QueryInteger(sqlite3* database, const std::string& sql);

// Whether the schema consists of exactly these tables and indexes, each with its CREATE statement
// to the letter. Errors: those of a statement.
Result<bool> HasSchema(sqlite3* database, std::span<const std::string_view> creations);

// A prepared statement. Bind (parameters count from 1), Step, read columns (from 0), Reset.
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
  // Steps since Reset.
  std::uint64_t Steps = 0;
  std::chrono::nanoseconds Time{ 0 };
};

}
