// SPDX-License-Identifier: BSD-3-Clause
#include "filters/store/Sqlite.h"

#include "filters/core/SystemReason.h"
#include "filters/core/Texts.h"
#include "filters/store/DescriptorVfs.h"

#include <sqlite3.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <ctime>
#include <system_error>
#include <thread>
#include <utility>

namespace kdstream
{
namespace
{

// A file name as an SQLite URI: everything except plain characters is percent-encoded. Errors:
// InputOutput if the name is relative and the current folder has been removed.
Result<std::string> UriOf(const std::filesystem::path& file)
{
  std::error_code status;
  const std::filesystem::path absolute = std::filesystem::absolute(file, status);
  if (status)
  {
    return Error{ ErrorCode::InputOutput,
      "the current folder cannot be found: " + status.message() };
  }
  return "file:" + PercentEncoded(absolute.string(), "/._-");
}

// This thread's processor time. So a slow disk or other programs do not count against the file.
std::chrono::nanoseconds ThreadTime()
{
  timespec time = {};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return std::chrono::seconds(time.tv_sec) + std::chrono::nanoseconds(time.tv_nsec);
}

// The work that the current statement of this thread has done. `current` is null if it is not
// limited.
struct Work
{
  std::uint64_t steps = 0;
  std::chrono::nanoseconds begin{ 0 }; // in ThreadTime; pauses are subtracted
};
thread_local Work* current = nullptr;

constexpr int stepsBetweenLooks = 100;

// SQLite calls this now and then while a statement runs. A result other than 0 ends the statement.
// The argument is the size of the file.
int HasTakenTooMuch(void* fileBytes)
{
  if (!current)
  {
    return 0;
  }
  const auto bytes = static_cast<std::uint64_t>(reinterpret_cast<std::uintptr_t>(fileBytes));
  current->steps += stepsBetweenLooks;
  const std::chrono::nanoseconds most =
    std::chrono::seconds(2) + std::chrono::microseconds(bytes / 50);
  return current->steps > 1'000'000 + bytes || ThreadTime() - current->begin > most ? 1 : 0;
}

// While this exists, the work of this thread is counted.
class Counted
{
public:
  Counted(std::uint64_t& steps, std::chrono::nanoseconds& time)
    : Steps(steps)
    , Time(time)
    , Own{ steps, ThreadTime() - time }
    , Before(std::exchange(current, &Own))
  {
  }
  Counted(const Counted&) = delete;
  Counted& operator=(const Counted&) = delete;
  ~Counted()
  {
    this->Steps = this->Own.steps;
    this->Time = ThreadTime() - this->Own.begin;
    current = this->Before;
  }

private:
  std::uint64_t& Steps;
  std::chrono::nanoseconds& Time;
  Work Own;
  Work* Before;
};

// Sets the limits that hold for every file: see Sqlite.h.
Status Distrust(sqlite3* database)
{
  for (const auto& [option, value] :
    { std::pair{ SQLITE_DBCONFIG_DEFENSIVE, 1 }, { SQLITE_DBCONFIG_ENABLE_VIEW, 0 },
      { SQLITE_DBCONFIG_ENABLE_TRIGGER, 0 }, { SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0 },
      { SQLITE_DBCONFIG_ENABLE_LOAD_EXTENSION, 0 }, { SQLITE_DBCONFIG_WRITABLE_SCHEMA, 0 } })
  {
    // An older SQLite does not know all options.
    sqlite3_db_config(database, option, value, nullptr);
  }
  for (const auto& [limit, value] :
    { std::pair{ SQLITE_LIMIT_LENGTH, mostRowBytes }, { SQLITE_LIMIT_SQL_LENGTH, 64 << 10 },
      { SQLITE_LIMIT_COLUMN, 32 }, { SQLITE_LIMIT_EXPR_DEPTH, 32 },
      { SQLITE_LIMIT_COMPOUND_SELECT, 4 }, { SQLITE_LIMIT_VDBE_OP, 10000 },
      { SQLITE_LIMIT_FUNCTION_ARG, 8 }, { SQLITE_LIMIT_ATTACHED, 0 },
      { SQLITE_LIMIT_LIKE_PATTERN_LENGTH, 100 }, { SQLITE_LIMIT_VARIABLE_NUMBER, 32 },
      { SQLITE_LIMIT_TRIGGER_DEPTH, 1 }, { SQLITE_LIMIT_WORKER_THREADS, 0 } })
  {
    sqlite3_limit(database, limit, value);
  }
  return Execute(
    database, "PRAGMA cell_size_check = ON; PRAGMA temp_store = MEMORY; PRAGMA mmap_size = 0");
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
  KDSTREAM_TRY(Distrust(raw));
  return database;
}

// How our own file system opens the file; it never opens another one.
enum class OpenMode
{
  Read,
  Write,
  Create
};
Result<Database> OpenDescriptor(int descriptor, OpenMode mode, ErrorCode code)
{
  const bool toWrite = mode != OpenMode::Read;
  const char* const vfs = DescriptorVfs();
  if (!vfs)
  {
    return Error{ ErrorCode::LimitExceeded, "out of memory" };
  }
  struct stat status = {};
  if (::fstat(descriptor, &status) != 0)
  {
    return SystemError("cannot be read or written", errno);
  }
  Result<Database> database =
    Open((toWrite ? "file:/store?descriptor=" : "file:/store?immutable=1&descriptor=") +
           std::to_string(descriptor),
      (toWrite ? SQLITE_OPEN_READWRITE : SQLITE_OPEN_READONLY) | SQLITE_OPEN_URI |
        SQLITE_OPEN_NOMUTEX,
      code, vfs);
  KDSTREAM_TRY(database);
  sqlite3_progress_handler(database->get(), stepsBetweenLooks, HasTakenTooMuch,
    reinterpret_cast<void*>(static_cast<std::uintptr_t>(status.st_size)));
  if (mode == OpenMode::Create) // a journal is left out only if the file is trusted
  {
    sqlite3_db_config(database->get(), SQLITE_DBCONFIG_DEFENSIVE, 0, nullptr);
  }
  if (toWrite)
  {
    KDSTREAM_TRY(
      Execute(database->get(), std::string("PRAGMA synchronous = OFF; PRAGMA journal_mode = ") +
                                 (mode == OpenMode::Create ? "OFF" : "MEMORY")));
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
  return OpenDescriptor(descriptor, OpenMode::Read, ErrorCode::Damaged);
}

Result<Database> OpenForWriting(int descriptor)
{
  return OpenDescriptor(descriptor, OpenMode::Write, ErrorCode::InputOutput);
}

Result<Database> OpenEmpty(int descriptor)
{
  return OpenDescriptor(descriptor, OpenMode::Create, ErrorCode::InputOutput);
}

Result<Database> OpenForWriting(const std::filesystem::path& file)
{
  const Result<std::string> uri = UriOf(file);
  KDSTREAM_TRY(uri);
  return Open(*uri,
    SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE | SQLITE_OPEN_URI | SQLITE_OPEN_NOMUTEX,
    ErrorCode::InputOutput);
}

void LimitValues(sqlite3* database, std::size_t bytes)
{
  sqlite3_limit(database, SQLITE_LIMIT_LENGTH,
    static_cast<int>(std::min(bytes, static_cast<std::size_t>(mostRowBytes))));
}

Error SqliteError(sqlite3* database, ErrorCode code)
{
  const auto refused = [database](const std::string& what, ErrorCode as = ErrorCode::InputOutput)
  {
    const int system = sqlite3_system_errno(database);
    return Error{ as, what + (system == 0 ? "" : ": " + std::generic_category().message(system)) };
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
      return refused("the disk is full", ErrorCode::DiskFull);
    case SQLITE_NOMEM:
      return { ErrorCode::LimitExceeded, "out of memory" };
    case SQLITE_CORRUPT:
      return { code, "its pages are damaged or incomplete" };
    case SQLITE_INTERRUPT:
      return { code, "takes too long to read for a store" };
    case SQLITE_TOOBIG:
      return { code, "it contains a value that is too large" };
    case SQLITE_ERROR: // our own statements fail if their tables are missing
      return { code, "its tables are not those of a store" };
    default:
      return { code, std::string("SQLite error: ") + sqlite3_errmsg(database) };
  }
}

Status Execute(sqlite3* database, const std::string& sql)
{
  std::uint64_t steps = 0;
  std::chrono::nanoseconds time{ 0 };
  const Counted counted(steps, time);
  if (sqlite3_exec(database, sql.c_str(), nullptr, nullptr, nullptr) != SQLITE_OK)
  {
    return SqliteError(database, ErrorCode::InputOutput);
  }
  return {};
}

Status UseWriteAheadLog(sqlite3* database, std::chrono::milliseconds patience)
{
  using Clock = std::chrono::steady_clock;
  constexpr std::chrono::milliseconds pause{ 5 };
  const auto until = Clock::now() + patience;
  sqlite3_busy_timeout(database, 0);
  for (;;)
  {
    // The statement reads and then writes. SQLite does not call a busy handler in this case.
    Status done = Execute(database, "PRAGMA journal_mode = WAL");
    const bool isBusy = !done && (sqlite3_errcode(database) & 0xFF) == SQLITE_BUSY;
    if (!isBusy || Clock::now() >= until)
    {
      return done;
    }
    std::this_thread::sleep_for(pause);
  }
}

Result<std::int64_t> QueryInteger(sqlite3* database, const std::string& sql)
{
  Result<Statement> statement = Statement::Prepare(database, sql.c_str());
  KDSTREAM_TRY(statement);
  const Result<bool> row = statement->Step();
  KDSTREAM_TRY(row);
  return *row ? statement->Integer(0) : 0;
}

Result<bool> HasSchema(sqlite3* database, std::span<const std::string_view> creations)
{
  Result<Statement> rows =
    Statement::Prepare(database, "SELECT sql FROM sqlite_schema ORDER BY rowid");
  KDSTREAM_TRY(rows);
  std::size_t same = 0;
  Result<bool> row = rows->Step();
  for (; row && *row; row = rows->Step(), ++same)
  {
    const auto sql = rows->Blob(0);
    if (same == creations.size() ||
        !std::equal(sql.begin(), sql.end(), creations[same].begin(), creations[same].end(),
          [](std::uint8_t a, char b) { return a == static_cast<std::uint8_t>(b); }))
    {
      return false;
    }
  }
  KDSTREAM_TRY(row);
  return same == creations.size();
}

Result<Statement> Statement::Prepare(sqlite3* database, const char* sql)
{
  Statement statement;
  const Counted counted(statement.Steps, statement.Time);
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
  const Counted counted(this->Steps, this->Time);
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
  this->Steps = 0;
  this->Time = {};
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
