// SPDX-License-Identifier: BSD-3-Clause
// Blobs that came from servers, kept on the disk: see DiskCache.h.
#include "viewer/client/DiskCache.h"

#include "filters/core/SeededHash.h"
#include "filters/core/SystemReason.h"
#include "filters/files/Folders.h"
#include "filters/store/Sqlite.h"

#include <fcntl.h>
#include <sqlite3.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <span>
#include <string_view>
#include <thread>
#include <utility>

namespace kdstream
{
namespace
{

namespace fs = std::filesystem;

constexpr int cacheVersion = 1; // of the tables' layout
// Limits while another program keeps the file busy: the time of each attempt; the attempts to
// write, for which nobody waits; and for how long the file is then not used.
constexpr std::chrono::milliseconds patienceWithFile{ 200 };
constexpr int mostTries = 5;
constexpr std::chrono::seconds busyPause{ 10 };
constexpr std::size_t mostPut = 4096; // entries waiting to be written; more are not kept
constexpr const char* cacheFile = "blobs.sqlite";

// `used`: the time of the last use, in milliseconds; `sum`: HashOfBytes of the bytes. The only row
// of `total` has the bytes of all entries, so they need not be counted.
constexpr std::array<std::string_view, 4> cacheLayout{
  "CREATE TABLE entries(origin TEXT, digest TEXT, name TEXT, used INTEGER, sum INTEGER, bytes "
  "BLOB)",
  "CREATE UNIQUE INDEX by_name ON entries(origin, digest, name)",
  "CREATE INDEX by_use ON entries(used)", "CREATE TABLE total(bytes INTEGER)"
};

std::int64_t SumOf(std::span<const std::uint8_t> bytes)
{
  return static_cast<std::int64_t>(HashOfBytes(std::as_bytes(bytes), agreedSeed));
}

std::int64_t NowInMilliseconds()
{
  using namespace std::chrono;
  return duration_cast<milliseconds>(system_clock::now().time_since_epoch()).count();
}

// Checks that the tables are exactly ours. In a file made by somebody else, a view in place of a
// table could compute without end when it is read.
Status CheckLayout(sqlite3* database)
{
  const auto same = HasSchema(database, cacheLayout);
  KDSTREAM_TRY(same);
  return *same ? Status{}
               : Status{ Error{ ErrorCode::Unsupported, "is not a cache: it has other tables" } };
}

// The result code of the last call on a database.
int CodeOf(sqlite3* database)
{
  return sqlite3_errcode(database) & 0xFF;
}

bool IsBusy(sqlite3* database)
{
  return CodeOf(database) == SQLITE_BUSY || CodeOf(database) == SQLITE_LOCKED;
}

bool IsDamaged(sqlite3* database)
{
  const int code = CodeOf(database);
  return code == SQLITE_NOTADB || code == SQLITE_CORRUPT || code == SQLITE_ERROR; // other tables
}

Status MakeTables(sqlite3* database)
{
  KDSTREAM_TRY(Execute(database, "PRAGMA auto_vacuum = INCREMENTAL"));
  KDSTREAM_TRY(UseWriteAheadLog(database, patienceWithFile));
  sqlite3_busy_timeout(database, int(patienceWithFile.count()));
  KDSTREAM_TRY(Execute(database, "BEGIN IMMEDIATE"));
  const auto version = QueryInteger(database, "PRAGMA user_version");
  KDSTREAM_TRY(version);
  if (*version != cacheVersion) // otherwise another program was quicker
  {
    KDSTREAM_TRY(Execute(
      database, "DROP TABLE IF EXISTS entries; DROP TABLE IF EXISTS total; PRAGMA user_version = " +
                  std::to_string(cacheVersion)));
    for (const std::string_view creation : cacheLayout)
    {
      KDSTREAM_TRY(Execute(database, std::string(creation)));
    }
    KDSTREAM_TRY(Execute(database, "INSERT INTO total VALUES(0)"));
  }
  KDSTREAM_TRY(CheckLayout(database));
  return Execute(database, "COMMIT");
}

// Makes the tables, and replaces those of another version. If our tables exist, nothing is written,
// so this does not wait for other writers.
Status PrepareCache(sqlite3* database)
{
  sqlite3_busy_timeout(database, int(patienceWithFile.count()));
  const auto version = QueryInteger(database, "PRAGMA user_version");
  KDSTREAM_TRY(version);
  KDSTREAM_TRY(*version == cacheVersion ? CheckLayout(database) : MakeTables(database));
  return Execute(database, "PRAGMA synchronous = NORMAL");
}

// Why the cache cannot be written to.
enum class Refusal
{
  Other,   // for example, the folder is read-only
  Damaged, // the file cannot be used any more
  Busy,    // another program keeps it
  NotOurs  // a file is another user's
};

Error BusyError(std::string file = {})
{
  return { ErrorCode::InputOutput, "another program is writing to it", std::move(file), {},
    Remedy::Retry };
}

Error NotOursError(const fs::path& file)
{
  return { ErrorCode::InputOutput, "does not belong to this user, and is not used", file.string() };
}

// Whether a file belongs to this user or to root. In a folder that others may write to, the name
// may lead to any file: files of other users are neither changed nor trusted.
bool IsOwn(const struct stat& found)
{
  return S_ISREG(found.st_mode) && found.st_nlink == 1 &&
         (found.st_uid == ::geteuid() || found.st_uid == 0);
}

// Makes the file, accessible only to its owner, unless it exists.
Status MakeFile(const fs::path& file)
{
  const int made =
    ::open(file.c_str(), O_RDWR | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, S_IRUSR | S_IWUSR);
  if (made >= 0)
  {
    ::close(made);
    return {};
  }
  const int reason = errno;
  return reason == EEXIST ? Status{} : SystemError("cannot be created", reason, file.string());
}

// The endings of the database and of the files beside it that SQLite makes and trusts while it is
// open.
constexpr std::array<const char*, 4> endings{ "", "-wal", "-shm", "-journal" };

Status CheckOwner(const fs::path& file, Refusal& refusal)
{
  for (const char* const ending : endings)
  {
    const fs::path checked = file.string() + ending;
    struct stat found = {};
    const bool exists = ::lstat(checked.c_str(), &found) == 0;
    if (exists ? !IsOwn(found) : checked == file) // MakeFile left a file there
    {
      refusal = Refusal::NotOurs;
      return NotOursError(checked);
    }
  }
  return {};
}

Result<Database> OpenTables(const fs::path& file, Refusal& refusal)
{
  KDSTREAM_TRY(MakeFile(file));
  KDSTREAM_TRY(CheckOwner(file, refusal));
  auto database = OpenForWriting(file);
  KDSTREAM_TRY(database);
  const Status prepared = PrepareCache(database->get());
  KDSTREAM_TRY(CheckOwner(file, refusal)); // another user may have put one there meanwhile
  if (prepared)
  {
    return database;
  }
  const Error& error = prepared.GetError();
  refusal = IsDamaged(database->get()) || error.code == ErrorCode::Unsupported ? Refusal::Damaged
            : IsBusy(database->get())                                          ? Refusal::Busy
                                                                               : Refusal::Other;
  return refusal == Refusal::Busy ? BusyError(file.string())
                                  : Error{ ErrorCode::InputOutput, error.message, file.string() };
}

Result<Database> OpenToWrite(const fs::path& folder, Refusal& refusal)
{
  KDSTREAM_TRY(MakePrivateFolder(folder));
  const fs::path file = folder / cacheFile;
  auto database = OpenTables(file, refusal);
  if (database || refusal != Refusal::Damaged)
  {
    return database;
  }
  // Errors are ignored, because this is only a cache.
  std::error_code failure;
  for (const char* ending : { "", "-wal", "-shm" })
  {
    fs::remove(file.string() + ending, failure);
  }
  refusal = Refusal::Other;
  return OpenTables(file, refusal);
}

// A database, and the open file that it reads, if it is read by a descriptor.
struct ReadOnlyCache
{
  Database database;
  int descriptor = -1;

  ReadOnlyCache() = default;
  ReadOnlyCache(ReadOnlyCache&& other) noexcept
    : database(std::move(other.database))
    , descriptor(std::exchange(other.descriptor, -1))
  {
  }
  ReadOnlyCache& operator=(ReadOnlyCache&&) = delete;
  ~ReadOnlyCache()
  {
    this->database.reset();
    if (this->descriptor >= 0)
    {
      ::close(this->descriptor);
    }
  }
};

// isWritten: whether this program writes the file; then new entries are found, too. Otherwise the
// file is read as it is now.
Result<ReadOnlyCache> OpenToRead(const fs::path& folder, bool isWritten)
{
  ReadOnlyCache opened;
  const fs::path file = folder / cacheFile;
  if (!isWritten)
  {
    opened.descriptor = ::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK);
    struct stat found = {};
    if (opened.descriptor < 0 || ::fstat(opened.descriptor, &found) != 0)
    {
      return Error{ ErrorCode::NotFound, "cannot be read", file.string() };
    }
    if (!IsOwn(found))
    {
      return NotOursError(file);
    }
  }
  auto database = isWritten ? OpenForWriting(file) : OpenForReading(opened.descriptor);
  KDSTREAM_TRY(database);
  opened.database = std::move(*database);
  sqlite3_busy_timeout(opened.database.get(), int(patienceWithFile.count()));
  const auto version = QueryInteger(opened.database.get(), "PRAGMA user_version");
  KDSTREAM_TRY(version);
  if (*version != cacheVersion)
  {
    return Error{ ErrorCode::Unsupported, "was written by another version", file.string() };
  }
  KDSTREAM_TRY(OfFile(file.string(), CheckLayout(opened.database.get())));
  return opened;
}

void BindKey(Statement& statement, const CacheKey& key)
{
  statement.Bind(1, key.origin);
  statement.Bind(2, key.digest);
  statement.Bind(3, key.name);
}

// Rolls back at its end, unless it was committed.
class Transaction
{
public:
  explicit Transaction(sqlite3* database)
    : Handle(database)
  {
  }
  ~Transaction()
  {
    if (!this->Committed)
    {
      (void)Execute(this->Handle, "ROLLBACK");
    }
  }
  Transaction(const Transaction&) = delete;
  Transaction& operator=(const Transaction&) = delete;

  Status Begin() { return Execute(this->Handle, "BEGIN IMMEDIATE"); }
  Status Commit()
  {
    const Status committed = Execute(this->Handle, "COMMIT");
    this->Committed = committed.HasValue();
    return committed;
  }

private:
  sqlite3* Handle;
  bool Committed = false;
};

}

// Two connections: one for readers, one for the thread that writes.
class DiskCache::File
{
public:
  File(ReadOnlyCache reading, Database writing, std::uint64_t mostBytes,
    std::function<void(const Error& why)> onTrouble)
    : Reading(std::move(reading))
    , Writing(std::move(writing))
    , MostBytes(static_cast<std::int64_t>(std::min<std::uint64_t>(mostBytes, INT64_MAX)))
    , OnTrouble(std::move(onTrouble))
    , Writer([this] { this->Write(); })
  {
  }

  ~File()
  {
    {
      const std::lock_guard lock(this->Mutex);
      this->Ended = true;
    }
    this->Woken.notify_one();
    this->Writer.join();
  }

  std::optional<std::vector<std::uint8_t>> Find(const CacheKey& key)
  {
    Task task{ Task::Kind::Use, key, {} };
    std::optional<std::vector<std::uint8_t>> found;
    {
      const std::lock_guard lock(this->ReadMutex);
      if (Clock::now() < this->NotReadBefore)
      {
        return std::nullopt;
      }
      auto statement = Statement::Prepare(this->Reading.database.get(),
        "SELECT bytes, sum FROM entries WHERE origin = ? AND digest = ? AND name = ?");
      if (!statement)
      {
        this->RestIfBusy();
        return std::nullopt;
      }
      BindKey(*statement, key);
      const auto row = statement->Step();
      if (!row || !*row)
      {
        this->RestIfBusy();
        return std::nullopt;
      }
      const auto bytes = statement->Blob(0);
      if (SumOf(bytes) == statement->Integer(1))
      {
        found.emplace(bytes.begin(), bytes.end());
      }
      else
      {
        task.kind = Task::Kind::Delete;
      }
    }
    this->Add(std::move(task));
    return found;
  }

  void Put(const CacheKey& key, std::vector<std::uint8_t> bytes)
  {
    this->Add({ Task::Kind::Put, key, std::move(bytes) });
  }

private:
  using Clock = std::chrono::steady_clock;

  // Call after a failed read: if the file is busy, nothing is read for a while, because the next
  // read would wait as long.
  void RestIfBusy()
  {
    if (IsBusy(this->Reading.database.get()))
    {
      this->NotReadBefore = Clock::now() + busyPause;
    }
  }

  struct Task
  {
    enum class Kind
    {
      Put,
      Use,
      Delete
    };
    Kind kind = Kind::Use;
    CacheKey key;
    std::vector<std::uint8_t> bytes;
  };

  void Add(Task task)
  {
    const std::lock_guard lock(this->Mutex);
    if (this->Writing && !this->HasFailed && this->Tasks.size() < mostPut &&
        Clock::now() >= this->NotWrittenBefore)
    {
      this->Tasks.push_back(std::move(task));
      this->Woken.notify_one();
    }
  }

  // The writing thread. All tasks that have arrived in the meantime are done in one transaction.
  void Write()
  {
    std::unique_lock lock(this->Mutex);
    for (;;)
    {
      this->Woken.wait(lock, [this] { return this->Ended || !this->Tasks.empty(); });
      if (this->Tasks.empty())
      {
        return;
      }
      const std::vector<Task> tasks = std::exchange(this->Tasks, {});
      lock.unlock();
      const Status done = this->DoPatiently(tasks);
      lock.lock();
      if (!done)
      {
        this->GiveUp(done.GetError());
      }
    }
  }

  // REQUIRES: Mutex is locked. If the reason was that another program kept the file busy, later
  // entries are kept again.
  void GiveUp(const Error& why)
  {
    this->Tasks.clear();
    this->HasFailed = !this->WasBusy;
    this->NotWrittenBefore = Clock::now() + busyPause;
    if (this->OnTrouble && !std::exchange(this->HasReported, true))
    {
      this->OnTrouble(this->WasBusy ? BusyError() : why);
    }
  }

  // Repeats the tasks while the file is busy. At the end of the program, there is only one attempt.
  Status DoPatiently(const std::vector<Task>& tasks)
  {
    for (int tries = 1;; ++tries)
    {
      const Status done = this->Do(tasks);
      if (done || !this->WasBusy || tries == mostTries || this->HasEnded())
      {
        return done;
      }
    }
  }

  bool HasEnded() const
  {
    const std::lock_guard lock(this->Mutex);
    return this->Ended;
  }

  Status Do(const std::vector<Task>& tasks)
  {
    Transaction transaction(this->Writing.get());
    const Status begun = transaction.Begin();
    this->WasBusy = !begun && IsBusy(this->Writing.get());
    KDSTREAM_TRY(begun);
    for (const Task& task : tasks)
    {
      KDSTREAM_TRY(task.kind == Task::Kind::Use ? this->Use(task.key) : this->Replace(task));
    }
    const auto total = QueryInteger(this->Writing.get(), "SELECT bytes FROM total");
    KDSTREAM_TRY(total);
    KDSTREAM_TRY(this->MakeRoom(*total));
    KDSTREAM_TRY(transaction.Commit());
    return *total > this->MostBytes ? Execute(this->Writing.get(), "PRAGMA incremental_vacuum")
                                    : Status{};
  }

  Status Use(const CacheKey& key)
  {
    auto statement = Statement::Prepare(this->Writing.get(),
      "UPDATE entries SET used = ?4 WHERE origin = ?1 AND digest = ?2 AND name = ?3");
    KDSTREAM_TRY(statement);
    BindKey(*statement, key);
    statement->Bind(4, NowInMilliseconds());
    KDSTREAM_TRY(statement->Step());
    return {};
  }

  // Deletes the old entry, if there is one; for a Put, inserts the new one.
  Status Replace(const Task& task)
  {
    auto erase = Statement::Prepare(this->Writing.get(),
      "DELETE FROM entries WHERE origin = ? AND digest = ? AND name = ? RETURNING length(bytes)");
    KDSTREAM_TRY(erase);
    BindKey(*erase, task.key);
    std::int64_t growth = static_cast<std::int64_t>(task.bytes.size());
    const auto row = erase->Step();
    KDSTREAM_TRY(row);
    if (*row)
    {
      growth -= erase->Integer(0);
      KDSTREAM_TRY(erase->Step()); // finishes the statement
    }
    if (task.kind == Task::Kind::Put)
    {
      auto insert =
        Statement::Prepare(this->Writing.get(), "INSERT INTO entries VALUES(?, ?, ?, ?, ?, ?)");
      KDSTREAM_TRY(insert);
      BindKey(*insert, task.key);
      insert->Bind(4, NowInMilliseconds());
      insert->Bind(5, SumOf(task.bytes));
      insert->Bind(6, std::span<const std::uint8_t>(task.bytes));
      KDSTREAM_TRY(insert->Step());
    }
    return this->Grow(growth);
  }

  Status Grow(std::int64_t bytes)
  {
    return Execute(
      this->Writing.get(), "UPDATE total SET bytes = bytes + " + std::to_string(bytes));
  }

  // Removes the least recently used entries.
  Status MakeRoom(std::int64_t total)
  {
    while (total > this->MostBytes)
    {
      auto oldest = Statement::Prepare(this->Writing.get(),
        "DELETE FROM entries WHERE rowid IN (SELECT rowid FROM entries ORDER BY used LIMIT 16) "
        "RETURNING length(bytes)");
      KDSTREAM_TRY(oldest);
      std::int64_t gone = 0;
      bool any = false;
      for (auto row = oldest->Step();; row = oldest->Step())
      {
        KDSTREAM_TRY(row);
        if (!*row)
        {
          break;
        }
        any = true;
        gone += oldest->Integer(0);
      }
      if (!any)
      {
        return Execute(this->Writing.get(), "UPDATE total SET bytes = 0");
      }
      total -= gone;
      KDSTREAM_TRY(this->Grow(-gone));
    }
    return {};
  }

  std::mutex ReadMutex; // guards the next two
  ReadOnlyCache Reading;
  Clock::time_point NotReadBefore;
  Database Writing;     // null if the file cannot be written; used only by the thread
  bool WasBusy = false; // used only by the thread
  const std::int64_t MostBytes;
  const std::function<void(const Error& why)> OnTrouble;
  mutable std::mutex Mutex; // guards all members below
  std::condition_variable Woken;
  std::vector<Task> Tasks;
  bool HasFailed = false, HasReported = false, Ended = false;
  Clock::time_point NotWrittenBefore;
  std::thread Writer;
};

DiskCache::DiskCache(std::unique_ptr<File> file)
  : Kept(std::move(file))
{
}

DiskCache::~DiskCache() = default;

Result<std::shared_ptr<DiskCache>> DiskCache::Open(
  const fs::path& folder, std::uint64_t mostBytes, std::function<void(const Error& why)> onTrouble)
{
  Refusal refusal = Refusal::Other;
  auto writing = OpenToWrite(folder, refusal);
  auto reading = OpenToRead(folder, writing.HasValue());
  if (!reading)
  {
    return writing ? reading.GetError() : writing.GetError();
  }
  // A folder that cannot be written to is not reported: somebody has decided that.
  const bool isReported = refusal == Refusal::Busy || refusal == Refusal::NotOurs;
  if (isReported && onTrouble)
  {
    onTrouble(refusal == Refusal::Busy ? BusyError() : writing.GetError());
  }
  return std::shared_ptr<DiskCache>(new DiskCache(std::make_unique<File>(std::move(*reading),
    writing ? std::move(*writing) : Database(), mostBytes, std::move(onTrouble))));
}

std::optional<std::vector<std::uint8_t>> DiskCache::Find(const CacheKey& key)
{
  return this->Kept->Find(key);
}

void DiskCache::Put(const CacheKey& key, std::vector<std::uint8_t> bytes)
{
  this->Kept->Put(key, std::move(bytes));
}

}
