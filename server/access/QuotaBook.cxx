// SPDX-License-Identifier: BSD-3-Clause
// Three tables: which partitions a subject has had, and when; how many those are, so that nobody
// counts them; and paces: the time at which all that was had would be had at the allowed rate
// (the generic cell rate algorithm). A pace is kept as long as that time is not too far ahead.
#include "server/access/QuotaBook.h"

#include "filters/store/Sqlite.h"
#include "filters/store/Store.h"

#include <fcntl.h>
#include <sqlite3.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <ctime>
#include <mutex>
#include <utility>

namespace kdstream
{

namespace
{

constexpr std::int64_t second = 1'000'000; // in microseconds
constexpr std::int64_t byteBurst = 10 * second, regionBurst = 60 * second;
constexpr std::uint64_t largestBlob = Store::largestBlobBytes;
// By so much the clock of a server may be wrong, or differ from that of another.
constexpr std::int64_t clocksDiffer = 600 * second;

constexpr const char* schema =
  "PRAGMA busy_timeout = 2000;"
  "PRAGMA journal_mode = WAL;"
  "PRAGMA synchronous = NORMAL;"
  "BEGIN IMMEDIATE;"
  "CREATE TABLE IF NOT EXISTS had (subject TEXT, model TEXT, partition INTEGER, time INTEGER,"
  " PRIMARY KEY (subject, model, partition)) WITHOUT ROWID;"
  "CREATE INDEX IF NOT EXISTS had_by_time ON had (subject, model, time);"
  "CREATE TABLE IF NOT EXISTS counts (subject TEXT, model TEXT, count INTEGER,"
  " PRIMARY KEY (subject, model)) WITHOUT ROWID;"
  "CREATE TABLE IF NOT EXISTS paces (subject TEXT, model TEXT, what TEXT, due INTEGER,"
  " PRIMARY KEY (subject, model, what)) WITHOUT ROWID;"
  "COMMIT;";

// What has expired of subjects that do not come any more.
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

std::string UtcOf(std::int64_t microseconds)
{
  const std::time_t time = microseconds / second;
  std::tm utc{};
  gmtime_r(&time, &utc);
  char text[40];
  return { text, std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &utc) };
}

// From when on a pace goes on: from `due`, as it is kept, or from now. A pace is ahead of `latest`
// only where the clock was ahead, of this server or of another with the same file. By a little, it
// still counts: each step back would be a whole new quota. By more it begins anew, or nobody would
// be served until the clock has caught up.
std::int64_t DueFrom(std::optional<std::int64_t> due, std::int64_t now, std::int64_t latest)
{
  return due && *due <= latest + clocksDiffer ? std::max(now, *due) : now;
}

QuotaRefusal Refusal(const std::string& what, std::int64_t now, std::int64_t ends)
{
  const auto seconds = std::max<std::int64_t>(1, (ends - now + second - 1) / second);
  return { what + ": again at " + UtcOf(now + seconds * second), std::chrono::seconds(seconds) };
}

// Which file it is; zeros where there is none.
std::pair<dev_t, ino_t> IdentityOf(const std::filesystem::path& file)
{
  struct stat status = {};
  const bool isThere = ::stat(file.c_str(), &status) == 0;
  return isThere ? std::pair(status.st_dev, status.st_ino) : std::pair<dev_t, ino_t>();
}

// Makes the file, if it is not there, for its owner alone: it tells who looked at what.
void MakePrivate(const std::filesystem::path& file)
{
  const int made = ::open(file.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
  if (made >= 0)
  {
    ::close(made);
  }
}

}

struct QuotaBook::File
{
  std::filesystem::path path;
  std::chrono::seconds window{};
  std::mutex mutex;                         // for what follows
  std::atomic<std::uint64_t> failures{ 0 }; // to begin
  std::chrono::steady_clock::time_point lastFailure;
  std::pair<dev_t, ino_t> identity;
  Database database;
  Statement begin, commit, rollback, date, expire, lower, has, count, oldest, add, raise, due, pace;

  // Opens the file, in place of the one of before.
  Status Open(std::int64_t now);
  // Whether the path still leads to the file that is open.
  bool IsThere() const { return IdentityOf(this->path) == this->identity; }
  Status Prepare();
  Error Failure() const; // of the database
  Error Failure(const std::string& why) const;

  // What a statement answers, a number; nothing where it has no row.
  Result<std::optional<std::int64_t>> Ask(Statement& statement);
  template <class... Values>
  Result<std::optional<std::int64_t>> Ask(Statement& statement, const Values&... values)
  {
    int parameter = 0;
    (statement.Bind(++parameter, values), ...);
    return this->Ask(statement);
  }
};

Error QuotaBook::File::Failure() const
{
  return this->Failure(sqlite3_errmsg(this->database.get()));
}

Error QuotaBook::File::Failure(const std::string& why) const
{
  return { ErrorCode::InputOutput, "the quotas cannot be kept: " + why, this->path.string() };
}

Status QuotaBook::File::Prepare()
{
  const std::pair<Statement*, const char*> all[] = {
    { &this->begin, "BEGIN IMMEDIATE" },
    { &this->commit, "COMMIT" },
    { &this->rollback, "ROLLBACK" },
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

Result<std::optional<std::int64_t>> QuotaBook::File::Ask(Statement& statement)
{
  const auto row = statement.Step();
  if (!row)
  {
    auto error = this->Failure();
    statement.Reset();
    return error;
  }
  const auto answer = *row ? std::optional(statement.Integer(0)) : std::nullopt;
  statement.Reset();
  return answer;
}

Status QuotaBook::File::Open(std::int64_t now)
{
  for (Statement* const each :
    { &this->begin, &this->commit, &this->rollback, &this->date, &this->expire, &this->lower,
      &this->has, &this->count, &this->oldest, &this->add, &this->raise, &this->due, &this->pace })
  {
    *each = {}; // before their database
  }
  this->identity = {};
  MakePrivate(this->path);
  auto opened = OpenForWriting(this->path);
  KDSTREAM_TRY(opened);
  this->database = std::move(*opened);
  std::string old = tidy;
  old.replace(
    old.find('@'), 1, std::to_string(now - std::int64_t{ this->window.count() } * second));
  if (!Execute(this->database.get(), schema) || !Execute(this->database.get(), old))
  {
    return this->Failure();
  }
  KDSTREAM_TRY(this->Prepare());
  this->identity = IdentityOf(this->path);
  return {};
}

QuotaBook::QuotaBook(std::unique_ptr<File> file, QuotaLimits limits, Clock clock)
  : Kept(std::move(file))
  , Limits(limits)
  , Now(clock ? std::move(clock) : Clock(SystemMicroseconds))
{
}

QuotaBook::~QuotaBook() = default;

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

// Nothing is entered where it is refused, or fails.
template <class Work>
QuotaBook::Taken QuotaBook::InTransaction(const Work& work)
{
  auto& file = *this->Kept;
  const auto failures = file.failures.load();
  const std::lock_guard lock(file.mutex);
  // It was tried meanwhile, or just now: who waits waits once, not one after all, nor do those who
  // come from a queue.
  if (file.failures != failures ||
      std::chrono::steady_clock::now() < file.lastFailure + pauseOfLocked)
  {
    return file.Failure("the file is locked");
  }
  if (!file.IsThere())
  {
    KDSTREAM_TRY(OfFile(file.path.string(), file.Open(this->Now())));
    return Error{ ErrorCode::InputOutput,
      "the quotas' file was removed or replaced: what was had is counted anew in the one of its "
      "name",
      file.path.string() };
  }
  const auto begun = file.Ask(file.begin);
  if (!begun)
  {
    ++file.failures;
    file.lastFailure = std::chrono::steady_clock::now();
    return begun.GetError();
  }
  Taken taken = work(this->Now());
  const bool entered = taken && !*taken;
  const auto ended = file.Ask(entered ? file.commit : file.rollback);
  if (!ended)
  {
    (void)file.Ask(file.rollback).HasValue();
    return taken ? ended.GetError() : taken.GetError();
  }
  return taken;
}

// A partition that the subject has had within the window may be had again.
QuotaBook::Taken QuotaBook::EnterPartition(
  const Holder& holder, std::uint64_t partitions, std::uint32_t partition, std::int64_t now)
{
  auto& file = *this->Kept;
  const auto& [subject, model] = holder;
  const std::int64_t window = std::int64_t{ this->Limits.window.count() } * second;
  // What was had in the future was had while the clock was ahead. It is not forgotten, or whoever
  // waits for the clock to be set back had a new quota; nor does it count until that future.
  KDSTREAM_TRY(file.Ask(file.date, now, subject, model, now + clocksDiffer));
  KDSTREAM_TRY(file.Ask(file.expire, subject, model, now - window));
  if (const int gone = sqlite3_changes(file.database.get()); gone > 0)
  {
    KDSTREAM_TRY(file.Ask(file.lower, std::int64_t{ gone }, subject, model));
  }
  const auto has = file.Ask(file.has, subject, model, std::int64_t{ partition });
  KDSTREAM_TRY(has);
  if (*has)
  {
    return std::optional<QuotaRefusal>();
  }
  const auto count = file.Ask(file.count, subject, model);
  KDSTREAM_TRY(count);
  const auto most = std::max<std::int64_t>(
    1, std::llround(std::floor(this->Limits.share * static_cast<double>(partitions))));
  if (count->value_or(0) >= most)
  {
    const auto oldest = file.Ask(file.oldest, subject, model);
    KDSTREAM_TRY(oldest);
    auto refusal =
      Refusal("the quota of " + std::to_string(most) + " partitions of this model is used up", now,
        oldest->value_or(now) + window);
    refusal.isShare = true;
    return std::optional(std::move(refusal));
  }
  KDSTREAM_TRY(file.Ask(file.add, subject, model, std::int64_t{ partition }, now));
  KDSTREAM_TRY(file.Ask(file.raise, subject, model));
  return std::optional<QuotaRefusal>();
}

// One more may always be had while the pace is kept: a partition of any size passes.
QuotaBook::Taken QuotaBook::EnterBytes(const Holder& holder, std::uint64_t bytes, std::int64_t now)
{
  auto& file = *this->Kept;
  const auto& [subject, model] = holder;
  const std::string_view what = "bytes";
  const auto due = file.Ask(file.due, subject, model, what);
  KDSTREAM_TRY(due);
  const auto rate = this->Limits.bytesPerSecond;
  const auto timeOf = [rate](std::uint64_t size) -> std::int64_t
  {
    return std::llround(
      static_cast<double>(size) / static_cast<double>(rate) * static_cast<double>(second));
  };
  const auto from = DueFrom(*due, now, now + byteBurst + timeOf(largestBlob));
  if (from - now >= byteBurst)
  {
    return std::optional(
      Refusal("the quota of " + std::to_string(rate) + " bytes a second is used up", now,
        from - byteBurst + 1));
  }
  KDSTREAM_TRY(file.Ask(file.pace, subject, model, what, from + timeOf(bytes)));
  return std::optional<QuotaRefusal>();
}

QuotaBook::Taken QuotaBook::TakePartition(std::string_view subject, std::string_view model,
  std::uint64_t partitions, std::uint32_t partition, std::uint64_t bytes)
{
  const Holder holder{ subject, model };
  return this->InTransaction(
    [&](std::int64_t now) -> Taken
    {
      if (this->Limits.share > 0)
      {
        auto taken = this->EnterPartition(holder, partitions, partition, now);
        if (!taken || *taken)
        {
          return taken;
        }
      }
      return this->Limits.bytesPerSecond > 0 ? this->EnterBytes(holder, bytes, now)
                                             : Taken(std::optional<QuotaRefusal>());
    });
}

QuotaBook::Taken QuotaBook::TakeRegion(std::string_view subject, std::string_view model)
{
  if (this->Limits.regionsPerMinute == 0)
  {
    return std::optional<QuotaRefusal>();
  }
  return this->InTransaction(
    [&](std::int64_t now) -> Taken
    {
      auto& file = *this->Kept;
      const std::string_view what = "regions";
      const auto due = file.Ask(file.due, subject, model, what);
      KDSTREAM_TRY(due);
      const auto next = DueFrom(*due, now, now + regionBurst) +
                        regionBurst / std::int64_t{ this->Limits.regionsPerMinute };
      if (next - now > regionBurst)
      {
        return std::optional(
          Refusal("the quota of " + std::to_string(this->Limits.regionsPerMinute) +
                    " regions a minute is used up",
            now, next - regionBurst));
      }
      KDSTREAM_TRY(file.Ask(file.pace, subject, model, what, next));
      return std::optional<QuotaRefusal>();
    });
}

}
