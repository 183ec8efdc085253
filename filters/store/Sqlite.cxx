// SPDX-License-Identifier: BSD-3-Clause
#include "filters/store/Sqlite.h"

#include "filters/store/DescriptorVfs.h"

#include <sqlite3.h>

#include <system_error>

namespace kdstream
{
namespace
{

// A file name as an SQLite URI: everything but plain characters is percent-encoded.
// Errors: InputOutput where the name is relative and the current folder is gone.
Result<std::string> UriOf(const std::filesystem::path& file)
{
  std::error_code status;
  const std::filesystem::path absolute = std::filesystem::absolute(file, status);
  if (status)
  {
    return Error{ ErrorCode::InputOutput,
      "the current folder cannot be found: " + status.message() };
  }
  std::string uri = "file:";
  for (const char c : absolute.string())
  {
    const auto byte = static_cast<unsigned char>(c);
    const bool plain = (byte >= 'a' && byte <= 'z') || (byte >= 'A' && byte <= 'Z') ||
                       (byte >= '0' && byte <= '9') || byte == '/' || byte == '.' || byte == '_' ||
                       byte == '-';
    if (plain)
    {
      uri += c;
    }
    else
    {
      uri += '%';
      uri += "0123456789ABCDEF"[byte >> 4];
      uri += "0123456789ABCDEF"[byte & 15];
    }
  }
  return uri;
}

Result<Database> Open(const std::string& name, int flags, ErrorCode code, const char* vfs = nullptr)
{
  sqlite3* raw = nullptr;
  const int status = sqlite3_open_v2(name.c_str(), &raw, flags, vfs);
  Database database(raw);
  if (status != SQLITE_OK)
  {
    return SqliteError(raw, code);
  }
  return database;
}

}

void CloseDatabase::operator()(sqlite3* database) const
{
  sqlite3_close_v2(database);
}

void Statement::Finalize::operator()(sqlite3_stmt* statement) const
{
  sqlite3_finalize(statement);
}

Result<Database> OpenForReading(int descriptor)
{
  const char* const vfs = DescriptorVfs();
  if (!vfs)
  {
    return Error{ ErrorCode::LimitExceeded, "out of memory" };
  }
  return Open("file:/store?immutable=1&descriptor=" + std::to_string(descriptor),
    SQLITE_OPEN_READONLY | SQLITE_OPEN_URI | SQLITE_OPEN_NOMUTEX, ErrorCode::Damaged, vfs);
}

Result<Database> OpenForWriting(const std::filesystem::path& file)
{
  const Result<std::string> uri = UriOf(file);
  KDSTREAM_TRY(uri);
  return Open(*uri,
    SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE | SQLITE_OPEN_URI | SQLITE_OPEN_NOMUTEX,
    ErrorCode::InputOutput);
}

Error SqliteError(sqlite3* database, ErrorCode code)
{
  const auto refused = [database](const std::string& what)
  {
    const int system = sqlite3_system_errno(database);
    return Error{ ErrorCode::InputOutput,
      what + (system == 0 ? "" : ": " + std::generic_category().message(system)) };
  };
  switch (database ? sqlite3_errcode(database) & 0xFF : SQLITE_NOMEM)
  {
    case SQLITE_NOTADB:
      return { ErrorCode::InvalidInput, "not a KdStream store" };
    case SQLITE_CANTOPEN:
      return refused("cannot be opened");
    case SQLITE_IOERR:
      return refused("cannot be read or written");
    case SQLITE_FULL:
      return refused("the disk is full");
    case SQLITE_NOMEM:
      return { ErrorCode::LimitExceeded, "out of memory" };
    case SQLITE_CORRUPT:
      return { code, "its pages are damaged, or cut off" };
    case SQLITE_ERROR: // our own statements, on tables that are not there
      return { code, "its tables are not those of a store" };
    default:
      return { code, std::string("SQLite says: ") + sqlite3_errmsg(database) };
  }
}

Status Execute(sqlite3* database, const std::string& sql)
{
  if (sqlite3_exec(database, sql.c_str(), nullptr, nullptr, nullptr) != SQLITE_OK)
  {
    return SqliteError(database, ErrorCode::InputOutput);
  }
  return {};
}

Result<std::int64_t> QueryInteger(sqlite3* database, const std::string& sql)
{
  Result<Statement> statement = Statement::Prepare(database, sql.c_str());
  KDSTREAM_TRY(statement);
  const Result<bool> row = statement->Step();
  KDSTREAM_TRY(row);
  return *row ? statement->Integer(0) : 0;
}

Result<Statement> Statement::Prepare(sqlite3* database, const char* sql)
{
  Statement statement;
  sqlite3_stmt* raw = nullptr;
  if (sqlite3_prepare_v2(database, sql, -1, &raw, nullptr) != SQLITE_OK)
  {
    return SqliteError(database, ErrorCode::Damaged);
  }
  statement.Handle.reset(raw);
  return statement;
}

void Statement::Bind(int parameter, std::int64_t value)
{
  sqlite3_bind_int64(this->Handle.get(), parameter, value);
}

void Statement::Bind(int parameter, std::string_view value)
{
  sqlite3_bind_text64(
    this->Handle.get(), parameter, value.data(), value.size(), SQLITE_STATIC, SQLITE_UTF8);
}

void Statement::Bind(int parameter, std::span<const std::uint8_t> value)
{
  sqlite3_bind_blob64(this->Handle.get(), parameter, value.data(), value.size(), SQLITE_STATIC);
}

Result<bool> Statement::Step()
{
  const int status = sqlite3_step(this->Handle.get());
  if (status == SQLITE_ROW)
  {
    return true;
  }
  if (status == SQLITE_DONE)
  {
    return false;
  }
  sqlite3* database = sqlite3_db_handle(this->Handle.get());
  return SqliteError(database, (status & 0xFF) == SQLITE_FULL || (status & 0xFF) == SQLITE_IOERR
                                 ? ErrorCode::InputOutput
                                 : ErrorCode::Damaged);
}

void Statement::Reset()
{
  sqlite3_reset(this->Handle.get());
}

std::int64_t Statement::Integer(int column) const
{
  return sqlite3_column_int64(this->Handle.get(), column);
}

std::string Statement::Text(int column) const
{
  const auto bytes = this->Blob(column);
  return { bytes.begin(), bytes.end() };
}

std::span<const std::uint8_t> Statement::Blob(int column) const
{
  const auto* data =
    static_cast<const std::uint8_t*>(sqlite3_column_blob(this->Handle.get(), column));
  const int size = sqlite3_column_bytes(this->Handle.get(), column);
  return { data, data ? static_cast<std::size_t>(size) : 0 };
}

}
