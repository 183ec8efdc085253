// SPDX-License-Identifier: BSD-3-Clause
// Four tables:
// - had: which partitions of a model (its digest) a subject has had, and when;
// - counts: how many partitions these are, so that they need not be counted again;
// - paces: the generic cell rate algorithm. A pace is the time at which the allowed rate would have
//   delivered everything that was taken. A request is allowed while that time is not too far ahead;
// - originals: which models have the same original.
//
// Rows of a model stay under its digest, and all models of one original are looked up together. So
// entries also count if they were made before it was known which models have the same original.
//
// A connection that has failed is closed, and the next call opens the file again. So the file is
// used again as soon as the cause (a full disk, an absent folder, a read-only file system) is gone.
//
// Servers share the file, its log and its index. Each server keeps open the files that had these
// names when it opened them. So each transaction checks whether the open files still have these
// names. A server that abandons such a file writes the log into it, and removes the log while no
// other server may write. So no server writes to a log that nobody reads.
#include "server/access/QuotaBook.h"

#include "filters/core/Texts.h"
#include "filters/core/UtcText.h"
#include "filters/protocol/BlobId.h"
#include "filters/store/Sqlite.h"
#include "filters/store/Store.h"

#include <fcntl.h>
#include <sqlite3.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <mutex>
#include <set>
#include <utility>
#include <vector>

namespace kdstream
{

namespace
{

constexpr const char* lockedFile = "the file is locked";

constexpr std::int64_t second = 1'000'000; // in microseconds
// How long to wait while others have the file locked.
constexpr std::chrono::milliseconds patienceWithOthers{ 2000 };
constexpr std::int64_t byteBurst = 10 * second, regionBurst = 60 * second;
constexpr std::uint64_t largestBlob = protocol::maximumBlobBytes;
// How much a server's clock may be wrong, or differ from another server's clock.
constexpr std::int64_t clocksDiffer = 600 * second;

constexpr const char* schema =
  "PRAGMA synchronous = NORMAL;"
  "BEGIN IMMEDIATE;"
  "CREATE TABLE IF NOT EXISTS had (subject TEXT, model TEXT, partition INTEGER, time INTEGER,"
  " PRIMARY KEY (subject, model, partition)) WITHOUT ROWID;"
  "CREATE INDEX IF NOT EXISTS had_by_time ON had (subject, model, time);"
  "CREATE TABLE IF NOT EXISTS counts (subject TEXT, model TEXT, count INTEGER,"
  " PRIMARY KEY (subject, model)) WITHOUT ROWID;"
  "CREATE TABLE IF NOT EXISTS paces (subject TEXT, model TEXT, what TEXT, due INTEGER,"
  " PRIMARY KEY (subject, model, what)) WITHOUT ROWID;"
  // The originals of models, and of inputs. Models are named by digest; names of inputs begin with
  // "input ". Names with the same `original` (which is the name of one of them) have the same
  // original. partitions: 0 for inputs.
  "CREATE TABLE IF NOT EXISTS originals (name TEXT PRIMARY KEY, original TEXT, division TEXT,"
  " partitions INTEGER) WITHOUT ROWID;"
  "CREATE INDEX IF NOT EXISTS originals_by_original ON originals (original);"
  "COMMIT;";

// Two models may have had entries before it was known that they have the same original. If they
// have the same division, a partition that was entered for both counts only once, from its first
// delivery.
constexpr const char* merge[] = {
  "DELETE FROM had WHERE EXISTS (SELECT 1 FROM originals AS here, originals AS there, had AS other"
  " WHERE here.name = had.model AND here.original = ?1 AND there.original = ?1"
  " AND there.division = here.division AND there.name <> here.name"
  " AND other.subject = had.subject AND other.model = there.name"
  " AND other.partition = had.partition"
  " AND (other.time, there.name) < (had.time, here.name))",
  "UPDATE counts SET count = (SELECT count(*) FROM had WHERE had.subject = counts.subject"
  " AND had.model = counts.model)"
  " WHERE model IN (SELECT name FROM originals WHERE original = ?1)"
};

// Removes expired entries of subjects that send no more requests.
constexpr const char* tidy =
  "BEGIN IMMEDIATE;"
  "DELETE FROM had WHERE time <= @;"
  "UPDATE counts SET count = (SELECT count(*) FROM had WHERE had.subject ="
  " counts.subject AND had.model = counts.model);"
  "DELETE FROM counts WHERE count = 0;"
  "COMMIT;";

std::int64_t SystemMicroseconds()
{
  return std::chrono::duration_cast<std::chrono::microseconds>(
    std::chrono::system_clock::now().time_since_epoch())
    .count();
}

// The time from which a rate limit continues: the stored `due`, or now if that is later. A `due`
// after `latest` means that a clock was ahead: this server's, or that of another server with the
// same file. If the difference is small, `due` still counts: otherwise each time the clock is set
// back, clients would get a new quota. If the difference is large, the limit starts again from now:
// otherwise nobody would be served until the clock has caught up.
std::int64_t DueFrom(std::optional<std::int64_t> due, std::int64_t now, std::int64_t latest)
{
  return due && *due <= latest + clocksDiffer ? std::max(now, *due) : now;
}

QuotaRefusal Refusal(const std::string& what, std::int64_t now, std::int64_t ends)
{
  const auto seconds = std::max<std::int64_t>(1, (ends - now + second - 1) / second);
  return { what + ": try again at " + UtcText(now / second + seconds),
    std::chrono::seconds(seconds) };
}

using FileIdentity = std::pair<dev_t, ino_t>;

// Nothing if the file does not exist or cannot be examined.
std::optional<FileIdentity> IdentityOf(const std::filesystem::path& file)
{
  struct stat status = {};
  return ::stat(file.c_str(), &status) == 0
           ? std::optional(FileIdentity(status.st_dev, status.st_ino))
           : std::nullopt;
}

std::filesystem::path FolderOf(const std::filesystem::path& file)
{
  return file.has_parent_path() ? file.parent_path() : ".";
}

// The devices that hold the folders above this folder, without the device of the folder itself. If
// the folder's file system is not mounted, the folder is on one of them.
std::set<dev_t> DevicesAbove(const std::filesystem::path& folder)
{
  std::error_code failed;
  std::filesystem::path each = std::filesystem::canonical(folder, failed);
  std::set<dev_t> devices;
  const auto own = IdentityOf(folder);
  while (!failed && each.has_relative_path())
  {
    each = each.parent_path();
    if (const auto above = IdentityOf(each))
    {
      devices.insert(above->first);
    }
  }
  if (own)
  {
    devices.erase(own->first);
  }
  return devices;
}

// Creates the file, if it does not exist, readable only by its owner, because it says who viewed
// what.
void MakePrivate(const std::filesystem::path& file)
{
  const int made = ::open(file.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
  if (made >= 0)
  {
    ::close(made);
  }
}

Error QuotaError(const std::string& why, const std::filesystem::path& file)
{
  return { ErrorCode::InputOutput, "the quotas cannot be recorded: " + why, file.string() };
}

// Resets a statement at the end of a scope, so that it can be used again however this use ends.
class ResetAtEnd
{
public:
  explicit ResetAtEnd(Statement& statement)
    : Of(statement)
  {
  }
  ResetAtEnd(const ResetAtEnd&) = delete;
  ResetAtEnd& operator=(const ResetAtEnd&) = delete;
  ~ResetAtEnd() { this->Of.Reset(); }

private:
  Statement& Of;
};

// A row of the table of originals.
struct CountedName
{
  std::string name, division;
  std::int64_t partitions = 1;
};

}

// The open file and its prepared statements.
struct QuotaBook::Connection
{
  explicit Connection(std::filesystem::path file)
    : path(std::move(file))
    , log(this->path.string() + "-wal")
    , index(this->path.string() + "-shm")
  {
  }
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;
  ~Connection();

  const std::filesystem::path path, log, index;
  // Of the open file, of its log, and of the log's index.
  std::optional<FileIdentity> identity, logIdentity, indexIdentity;
  std::set<dev_t> devicesAbove; // devices of the folders above it
  Database database;
  Statement begin, commit, date, expire, lower, has, count, oldest, add, raise, due, pace,
    originalOf, named, enter, join, removeTwice, countAnew;

  bool IsFileThere() const { return IdentityOf(this->path) == this->identity; }
  bool IsLogThere() const
  {
    return this->logIdentity && IdentityOf(this->log) == this->logIdentity;
  }
  // Whether the paths still lead to the open file, its log and its index; entries made in other
  // files would be invisible to other servers.
  bool IsThere() const
  {
    return this->IsFileThere() && IdentityOf(this->log) == this->logIdentity &&
           IdentityOf(this->index) == this->indexIdentity;
  }
  Status Open();
  Status MakeTables();
  Status Prepare();
  // Removes entries older than `before`.
  Status Tidy(std::int64_t before);
  // Rolls back an uncommitted transaction. Returns whether no transaction is open any more.
  bool RollBack();
  // Abandons a file that was removed or replaced, or whose log was. Errors: the file is locked;
  // then it stays open.
  Status Leave();

  bool IsLocked() const { return (sqlite3_errcode(this->database.get()) & 0xff) == SQLITE_BUSY; }
  Error Failure() const; // the database's last error
  // Calls onRow for each row that a statement returns.
  template <class OnRow, class... Values>
  Status ForEach(Statement& statement, const OnRow& onRow, const Values&... values);
  // The number that a statement returns; nothing if it has no row.
  template <class... Values>
  Result<std::optional<std::int64_t>> Ask(Statement& statement, const Values&... values);
  template <class... Values>
  Result<std::optional<std::string>> AskText(Statement& statement, const Values&... values);

  // All models that have the same original as this one, including itself. This model is entered
  // first, if it is missing; then hasEntered is set.
  Result<std::vector<CountedName>> ModelsLike(const CountedModel& model);
  Result<std::string> OriginalOf(const CountedModel& model);
  bool hasEntered = false;
};

struct QuotaBook::File
{
  std::filesystem::path path;
  std::chrono::seconds window{};
  std::mutex mutex;                         // for the members below
  std::atomic<std::uint64_t> failures{ 0 }; // failed attempts to begin, because of a lock
  std::chrono::steady_clock::time_point lastFailure;
  std::unique_ptr<Connection> open;     // null: opening failed, or was never tried
  std::optional<FileIdentity> lastOpen; // the file of the last connection
  std::set<dev_t> devicesAbove;         // above the folder at that time

  Status Open(std::int64_t now);
  // If the open file was removed or replaced, opens the file that has its name now. If that is a
  // different file, this is an error.
  Status Follow(std::int64_t now);
  Status Begin();
  Error WasReplaced() const
  {
    return { ErrorCode::InputOutput,
      "the quota file was removed or replaced: counting starts again with the file of this name",
      this->path.string() };
  }
  void NoteLock()
  {
    ++this->failures;
    this->lastFailure = std::chrono::steady_clock::now();
  }
};

// The subject that takes a partition or a region, the model, and all models that count together
// with it.
struct QuotaBook::Holder
{
  std::string_view subject;
  const CountedModel& model;
  Connection& file;
  std::vector<CountedName> models;
};

Error QuotaBook::Connection::Failure() const
{
  return QuotaError(
    this->IsLocked() ? lockedFile : sqlite3_errmsg(this->database.get()), this->path);
}

Status QuotaBook::Connection::Prepare()
{
  const std::pair<Statement*, const char*> all[] = {
    { &this->begin, "BEGIN IMMEDIATE" },
    { &this->commit, "COMMIT" },
    { &this->date, "UPDATE had SET time = ? WHERE subject = ? AND model = ? AND time > ?" },
    { &this->expire, "DELETE FROM had WHERE subject = ? AND model = ? AND time <= ?" },
    { &this->lower, "UPDATE counts SET count = count - ? WHERE subject = ? AND model = ?" },
    { &this->has, "SELECT 1 FROM had WHERE subject = ? AND model = ? AND partition = ?" },
    { &this->count, "SELECT count FROM counts WHERE subject = ? AND model = ?" },
    { &this->oldest, "SELECT min(time) FROM had WHERE subject = ? AND model = ?" },
    { &this->add, "INSERT INTO had VALUES (?, ?, ?, ?)" },
    { &this->raise,
      "INSERT INTO counts VALUES (?, ?, 1) ON CONFLICT DO UPDATE SET count = count + 1" },
    { &this->due, "SELECT due FROM paces WHERE subject = ? AND model = ? AND what = ?" },
    { &this->pace, "INSERT OR REPLACE INTO paces VALUES (?, ?, ?, ?)" },
    { &this->originalOf, "SELECT original FROM originals WHERE name = ?" },
    { &this->named,
      "SELECT name, division, partitions FROM originals WHERE original = ? AND partitions > 0" },
    { &this->enter, "INSERT INTO originals VALUES (?, ?, ?, ?)" },
    { &this->join, "UPDATE originals SET original = ? WHERE original = ?" },
    { &this->removeTwice, merge[0] },
    { &this->countAnew, merge[1] },
  };
  for (const auto& [statement, sql] : all)
  {
    auto prepared = Statement::Prepare(this->database.get(), sql);
    if (!prepared)
    {
      return this->Failure();
    }
    *statement = std::move(*prepared);
  }
  return {};
}

template <class OnRow, class... Values>
Status QuotaBook::Connection::ForEach(
  Statement& statement, const OnRow& onRow, const Values&... values)
{
  const ResetAtEnd reset(statement);
  int parameter = 0;
  (statement.Bind(++parameter, values), ...);
  while (true)
  {
    const auto row = statement.Step();
    if (!row)
    {
      return this->Failure();
    }
    if (!*row)
    {
      return {};
    }
    onRow(statement);
  }
}

template <class... Values>
Result<std::optional<std::int64_t>> QuotaBook::Connection::Ask(
  Statement& statement, const Values&... values)
{
  std::optional<std::int64_t> answer;
  KDSTREAM_TRY(this->ForEach(
    statement, [&answer](const Statement& row) { answer = row.Integer(0); }, values...));
  return answer;
}

template <class... Values>
Result<std::optional<std::string>> QuotaBook::Connection::AskText(
  Statement& statement, const Values&... values)
{
  std::optional<std::string> answer;
  KDSTREAM_TRY(this->ForEach(
    statement, [&answer](const Statement& row) { answer = row.Text(0); }, values...));
  return answer;
}

// Waits for other servers once, not again in each step.
Status QuotaBook::Connection::MakeTables()
{
  using Steady = std::chrono::steady_clock;
  using std::chrono::milliseconds;
  const auto until = Steady::now() + patienceWithOthers;
  KDSTREAM_TRY(UseWriteAheadLog(this->database.get(), patienceWithOthers));
  const auto left = std::chrono::duration_cast<milliseconds>(until - Steady::now());
  sqlite3_busy_timeout(
    this->database.get(), static_cast<int>(std::max(left, milliseconds(0)).count()));
  KDSTREAM_TRY(Execute(this->database.get(), schema));
  sqlite3_busy_timeout(this->database.get(), static_cast<int>(patienceWithOthers.count()));
  return {};
}

Status QuotaBook::Connection::Open()
{
  MakePrivate(this->path);
  auto opened = OpenForWriting(this->path);
  if (!opened)
  {
    return QuotaError(opened.GetError().message, this->path);
  }
  this->database = std::move(*opened);
  // Check this before SQLite creates a log and an index with the same permissions, because these
  // would remain.
  if (sqlite3_db_readonly(this->database.get(), "main") == 1)
  {
    return QuotaError("the file is read-only", this->path);
  }
  // Somebody may have replaced the file, so triggers and views in it must not run.
  for (const int off :
    { SQLITE_DBCONFIG_ENABLE_TRIGGER, SQLITE_DBCONFIG_ENABLE_VIEW, SQLITE_DBCONFIG_TRUSTED_SCHEMA })
  {
    sqlite3_db_config(this->database.get(), off, 0, nullptr);
  }
  sqlite3_db_config(this->database.get(), SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE, 1, nullptr);
  if (!this->MakeTables())
  {
    return this->Failure();
  }
  KDSTREAM_TRY(this->Prepare());
  const auto is = IdentityOf(this->path);
  int hasMoved = 0; // whether the file was moved since it was opened
  sqlite3_file_control(this->database.get(), nullptr, SQLITE_FCNTL_HAS_MOVED, &hasMoved);
  if (!is || hasMoved != 0)
  {
    return QuotaError("the file was removed", this->path);
  }
  this->logIdentity = IdentityOf(this->log);
  this->indexIdentity = IdentityOf(this->index);
  if (this->logIdentity.has_value() != this->indexIdentity.has_value())
  {
    return QuotaError("its log (-wal) was removed", this->path);
  }
  this->identity = is;
  this->devicesAbove = DevicesAbove(FolderOf(this->path));
  return {};
}

Status QuotaBook::Connection::Tidy(std::int64_t before)
{
  std::string old = tidy;
  old.replace(old.find('@'), 1, std::to_string(before));
  return Execute(this->database.get(), old) ? Status() : this->Failure();
}

bool QuotaBook::Connection::RollBack()
{
  if (!sqlite3_get_autocommit(this->database.get()))
  {
    sqlite3_exec(this->database.get(), "ROLLBACK", nullptr, nullptr, nullptr);
  }
  return sqlite3_get_autocommit(this->database.get()) != 0;
}

// Writes the entries of the log into the file, wherever the file is now. The log may be beside
// another file, which has replaced the open one: SQLite would take it for that file's log. Another
// server may have the same log open and add entries. So the log is removed only after it has been
// emptied, and only while nobody can write.
Status QuotaBook::Connection::Leave()
{
  const auto isLogEmpty = [this]
  {
    std::error_code failed;
    return std::filesystem::file_size(this->log, failed) == 0 || failed;
  };
  constexpr int mostTries = 10;
  for (int tried = 1; tried <= mostTries; ++tried)
  {
    this->RollBack();
    const int status = sqlite3_wal_checkpoint_v2(
      this->database.get(), nullptr, SQLITE_CHECKPOINT_TRUNCATE, nullptr, nullptr);
    if ((status & 0xff) == SQLITE_BUSY)
    {
      return QuotaError(lockedFile, this->path);
    }
    if (const auto begun = this->Ask(this->begin); !begun && this->IsLocked())
    {
      return begun.GetError();
    }
    // A full disk keeps the log's content out of the file, but must not keep the server from
    // closing it.
    if (!this->IsLogThere() || isLogEmpty() || status != SQLITE_OK || tried == mostTries)
    {
      break;
    }
  }
  for (const auto& [file, was] :
    { std::pair(this->log, this->logIdentity), std::pair(this->index, this->indexIdentity) })
  {
    if (was && IdentityOf(file) == was)
    {
      ::unlink(file.c_str());
    }
  }
  this->RollBack();
  this->identity.reset();
  return {};
}

// When the last server closes the file, SQLite removes the file that has the log's name. This may
// be the log of another file, so it is only allowed while the names still lead to the open files.
QuotaBook::Connection::~Connection()
{
  if (!this->identity)
  {
    return;
  }
  if (this->IsThere())
  {
    sqlite3_db_config(this->database.get(), SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE, 0, nullptr);
    return;
  }
  try
  {
    (void)this->Leave();
  }
  catch (...) // lack of memory: the files with its names remain
  {
  }
}

// Records the original of the model. If this model is the first to show that two names have the
// same original, the names are joined.
Result<std::string> QuotaBook::Connection::OriginalOf(const CountedModel& model)
{
  const auto ofModel = this->AskText(this->originalOf, model.digest);
  KDSTREAM_TRY(ofModel);
  const std::string input = "input " + std::string(model.inputDigest);
  const bool isInputKnown = !model.inputDigest.empty();
  const auto ofInput = this->AskText(this->originalOf, std::string_view(input));
  KDSTREAM_TRY(ofInput);
  this->hasEntered = !*ofModel || (isInputKnown && *ofInput != *ofModel);
  if (!this->hasEntered)
  {
    return **ofModel;
  }
  const std::string original = isInputKnown && *ofInput ? **ofInput
                               : *ofModel               ? **ofModel
                                                        : std::string(model.digest);
  const std::string_view of = original;
  if (!*ofModel)
  {
    KDSTREAM_TRY(this->Ask(this->enter, model.digest, of, model.division,
      static_cast<std::int64_t>(std::max<std::uint64_t>(1, model.partitions))));
  }
  else if (**ofModel != original)
  {
    KDSTREAM_TRY(this->Ask(this->join, of, std::string_view(**ofModel)));
  }
  if (isInputKnown && !*ofInput)
  {
    KDSTREAM_TRY(
      this->Ask(this->enter, std::string_view(input), of, std::string_view(), std::int64_t{ 0 }));
  }
  if (isInputKnown && *ofInput) // other models of the same input exist
  {
    KDSTREAM_TRY(this->Ask(this->removeTwice, of));
    KDSTREAM_TRY(this->Ask(this->countAnew, of));
  }
  return original;
}

Result<std::vector<CountedName>> QuotaBook::Connection::ModelsLike(const CountedModel& model)
{
  const auto original = this->OriginalOf(model);
  KDSTREAM_TRY(original);
  std::vector<CountedName> models;
  KDSTREAM_TRY(this->ForEach(
    this->named,
    [&models](const Statement& row) {
      models.push_back({ row.Text(0), row.Text(1), row.Integer(2) });
    },
    std::string_view(*original)));
  return models;
}

// Opens the file if it is not open. Errors: InputOutput; then it is still not open.
Status QuotaBook::File::Open(std::int64_t now)
{
  const auto folder = IdentityOf(FolderOf(this->path));
  if (folder && this->devicesAbove.contains(folder->first) && !IdentityOf(this->path))
  {
    return QuotaError("the file system of its folder is not mounted", this->path);
  }
  auto opened = std::make_unique<Connection>(this->path);
  auto status = opened->Open();
  if (status && this->lastOpen != opened->identity)
  {
    status = opened->Tidy(now - std::int64_t{ this->window.count() } * second);
  }
  if (!status)
  {
    if (opened->database && opened->IsLocked())
    {
      this->NoteLock();
    }
    return status;
  }
  this->devicesAbove = std::move(opened->devicesAbove);
  this->lastOpen = opened->identity;
  this->open = std::move(opened);
  return {};
}

Status QuotaBook::File::Follow(std::int64_t now)
{
  const bool isThere = this->open->IsFileThere();
  const FileIdentity was = this->open->identity.value();
  if (auto left = this->open->Leave(); !left)
  {
    this->NoteLock();
    return left;
  }
  this->open.reset();
  KDSTREAM_TRY(this->Open(now));
  // If only the file's log (-wal) was removed, all entries are in the file.
  const bool isSame = isThere && this->open->identity.value() == was;
  return isSame ? Status() : this->WasReplaced();
}

// After this no other server writes or removes the log, so committed entries are in the file's own
// log.
Status QuotaBook::File::Begin()
{
  const auto begun = this->open->Ask(this->open->begin);
  if (!begun && this->open->IsLocked())
  {
    this->NoteLock();
  }
  KDSTREAM_TRY(begun);
  return this->open->IsThere() ? Status() : this->WasReplaced();
}

QuotaBook::QuotaBook(std::unique_ptr<File> file, QuotaLimits limits, Clock clock)
  : Kept(std::move(file))
  , Limits(limits)
  , Now(clock ? std::move(clock) : Clock(SystemMicroseconds))
{
}

QuotaBook::~QuotaBook() = default;

void QuotaBook::Close()
{
  const std::lock_guard lock(this->Kept->mutex);
  this->Kept->open.reset();
}

Result<std::unique_ptr<QuotaBook>> QuotaBook::Open(
  const std::filesystem::path& file, QuotaLimits limits, Clock clock)
{
  auto kept = std::make_unique<File>();
  kept->path = file;
  kept->window = limits.window;
  std::unique_ptr<QuotaBook> book(new QuotaBook(std::move(kept), limits, std::move(clock)));
  KDSTREAM_TRY(book->Kept->Open(book->Now()));
  return book;
}

// Records nothing if the work is refused or fails.
template <class Work>
QuotaBook::Taken QuotaBook::InTransaction(const CountedModel& model, const Work& work)
{
  auto& file = *this->Kept;
  const auto failures = file.failures.load();
  const std::lock_guard lock(file.mutex);
  // Another request has failed to lock the file in the meantime, or a moment ago. So this request
  // does not wait again: each request waits at most once, not for all requests before it in the
  // queue.
  if (file.failures != failures ||
      std::chrono::steady_clock::now() < file.lastFailure + pauseOfLocked)
  {
    return QuotaError(lockedFile, file.path);
  }
  if (file.open && !file.open->IsThere())
  {
    KDSTREAM_TRY(file.Follow(this->Now()));
  }
  if (!file.open)
  {
    KDSTREAM_TRY(file.Open(this->Now()));
  }
  return this->TryTransaction(model, work);
}

// However this ends, the transaction is closed, and so is a connection that has failed.
template <class Work>
QuotaBook::Taken QuotaBook::TryTransaction(const CountedModel& model, const Work& work)
{
  auto& file = *this->Kept;
  auto& connection = *file.open;
  bool fails = false;
  struct AtEnd
  {
    File& file;
    const bool& fails;
    ~AtEnd()
    {
      if (!this->file.open->RollBack() || this->fails)
      {
        this->file.open.reset();
      }
    }
  } const atEnd{ file, fails };
  const auto failed = [&](Error error) -> Taken
  {
    // If the names lead to other files, the connection stays open, and the next call follows the
    // names.
    fails = !connection.IsLocked() && connection.IsThere();
    return error;
  };
  if (const auto begun = file.Begin(); !begun)
  {
    return failed(begun.GetError());
  }
  auto models = connection.ModelsLike(model);
  if (!models)
  {
    return failed(models.GetError());
  }
  if (connection.hasEntered) // keep what is known about inputs even if this request is refused
  {
    if (const auto committed = connection.Ask(connection.commit); !committed)
    {
      return failed(committed.GetError());
    }
    if (const auto begun = file.Begin(); !begun)
    {
      return failed(begun.GetError());
    }
  }
  Taken taken = work(connection, std::move(*models), this->Now());
  if (!taken)
  {
    return failed(taken.GetError());
  }
  if (!*taken)
  {
    if (const auto committed = connection.Ask(connection.commit); !committed)
    {
      return failed(committed.GetError());
    }
  }
  return taken;
}

// A partition that the subject has had within the window may be sent again. Partitions of models
// with another division count by their share of the original.
QuotaBook::Taken QuotaBook::EnterPartition(
  const Holder& holder, std::uint32_t partition, std::int64_t now) const
{
  auto& file = holder.file;
  const auto& subject = holder.subject;
  const std::int64_t window = std::int64_t{ this->Limits.window.count() } * second;
  std::int64_t had = 0;
  double shareHad = 0;
  std::optional<std::int64_t> oldest;
  for (const CountedName& each : holder.models)
  {
    const std::string_view model = each.name;
    // Entries in the future were made while the clock was ahead. They are not removed, because
    // otherwise setting back the clock would give a new quota; they are dated now instead.
    KDSTREAM_TRY(file.Ask(file.date, now, subject, model, now + clocksDiffer));
    KDSTREAM_TRY(file.Ask(file.expire, subject, model, now - window));
    if (const int gone = sqlite3_changes(file.database.get()); gone > 0)
    {
      KDSTREAM_TRY(file.Ask(file.lower, std::int64_t{ gone }, subject, model));
    }
    const bool isDividedAlike = each.division == holder.model.division;
    if (isDividedAlike)
    {
      const auto has = file.Ask(file.has, subject, model, std::int64_t{ partition });
      KDSTREAM_TRY(has);
      if (*has)
      {
        return std::optional<QuotaRefusal>();
      }
    }
    const auto count = file.Ask(file.count, subject, model);
    KDSTREAM_TRY(count);
    if (count->value_or(0) > 0)
    {
      had += isDividedAlike ? **count : 0;
      shareHad += isDividedAlike ? 0 : double(**count) / double(each.partitions);
      const auto first = file.Ask(file.oldest, subject, model);
      KDSTREAM_TRY(first);
      oldest = std::min(oldest.value_or(now), first->value_or(now));
    }
  }
  const auto partitions = static_cast<double>(holder.model.partitions);
  const auto most =
    std::max<std::int64_t>(1, std::llround(std::floor(this->Limits.share * partitions)));
  constexpr double rounding = 1e-9; // of sums of shares
  if (had + std::llround(std::ceil(shareHad * partitions - rounding)) >= most)
  {
    auto refusal =
      Refusal("the quota of " + std::to_string(most) + " partitions of this model is used up", now,
        oldest.value_or(now) + window);
    refusal.isShare = true;
    return std::optional(std::move(refusal));
  }
  const std::string_view model = holder.model.digest;
  KDSTREAM_TRY(file.Ask(file.add, subject, model, std::int64_t{ partition }, now));
  KDSTREAM_TRY(file.Ask(file.raise, subject, model));
  return std::optional<QuotaRefusal>();
}

// The time from which the common pace of all models of the original continues.
Result<std::int64_t> QuotaBook::DueOf(
  const Holder& holder, std::string_view what, std::int64_t now, std::int64_t latest)
{
  std::int64_t from = now;
  for (const CountedName& each : holder.models)
  {
    const auto due =
      holder.file.Ask(holder.file.due, holder.subject, std::string_view(each.name), what);
    KDSTREAM_TRY(due);
    from = std::max(from, DueFrom(*due, now, latest));
  }
  return from;
}

// While the pace is kept, one more partition is always allowed, so that a partition of any size can
// be delivered.
QuotaBook::Taken QuotaBook::EnterBytes(
  const Holder& holder, std::uint64_t bytes, std::int64_t now) const
{
  const auto rate = this->Limits.bytesPerSecond;
  const auto timeOf = [rate](std::uint64_t size) -> std::int64_t
  {
    return std::llround(
      static_cast<double>(size) / static_cast<double>(rate) * static_cast<double>(second));
  };
  const std::string_view what = "bytes";
  const auto from = DueOf(holder, what, now, now + byteBurst + timeOf(largestBlob));
  KDSTREAM_TRY(from);
  if (*from - now >= byteBurst)
  {
    return std::optional(
      Refusal("the quota of " + std::to_string(rate) + " bytes a second is used up", now,
        *from - byteBurst + 1));
  }
  KDSTREAM_TRY(holder.file.Ask(
    holder.file.pace, holder.subject, holder.model.digest, what, *from + timeOf(bytes)));
  return std::optional<QuotaRefusal>();
}

QuotaBook::Taken QuotaBook::EnterRegion(const Holder& holder, std::int64_t now) const
{
  const std::string_view what = "regions";
  const auto from = DueOf(holder, what, now, now + regionBurst);
  KDSTREAM_TRY(from);
  const auto next = *from + regionBurst / std::int64_t{ this->Limits.regionsPerMinute };
  if (next - now > regionBurst)
  {
    return std::optional(Refusal("the quota of " + std::to_string(this->Limits.regionsPerMinute) +
                                   " regions a minute is used up",
      now, next - regionBurst));
  }
  KDSTREAM_TRY(holder.file.Ask(holder.file.pace, holder.subject, holder.model.digest, what, next));
  return std::optional<QuotaRefusal>();
}

QuotaBook::Taken QuotaBook::TakePartition(
  std::string_view subject, const CountedModel& model, std::uint32_t partition, std::uint64_t bytes)
{
  return this->InTransaction(model,
    [&](Connection& file, std::vector<CountedName> models, std::int64_t now) -> Taken
    {
      const Holder holder{ subject, model, file, std::move(models) };
      if (this->Limits.share > 0)
      {
        auto taken = this->EnterPartition(holder, partition, now);
        if (!taken || *taken)
        {
          return taken;
        }
      }
      return this->Limits.bytesPerSecond > 0 ? this->EnterBytes(holder, bytes, now)
                                             : Taken(std::optional<QuotaRefusal>());
    });
}

QuotaBook::Taken QuotaBook::TakeRegion(std::string_view subject, const CountedModel& model)
{
  if (this->Limits.regionsPerMinute == 0)
  {
    return std::optional<QuotaRefusal>();
  }
  return this->InTransaction(model,
    [&](Connection& file, std::vector<CountedName> models, std::int64_t now) {
      return this->EnterRegion({ subject, model, file, std::move(models) }, now);
    });
}

}
