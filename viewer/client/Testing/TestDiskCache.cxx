// SPDX-License-Identifier: BSD-3-Clause
// Blobs on the disk: they are found again, also by other programs; the least recently used are
// removed first; damaged ones are never returned.
#include "viewer/client/DiskCache.h"

#include "Testing/Fixtures/TemporaryFolder.h"

#include <gtest/gtest.h>
#include <sqlite3.h>

#include <sys/resource.h>
#include <sys/stat.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <random>
#include <thread>

using namespace kdstream;
using fixtures::TemporaryFolder;

namespace
{

using Bytes = std::vector<std::uint8_t>;
constexpr std::uint64_t plenty = std::uint64_t{ 1 } << 30;

CacheKey Key(int i)
{
  return { "http://a:1", "digest", "partitions/" + std::to_string(i) };
}

Bytes Content(int i, std::size_t size = 1000)
{
  std::mt19937 random(static_cast<unsigned>(i));
  Bytes bytes(size);
  for (auto& byte : bytes)
  {
    byte = static_cast<std::uint8_t>(random());
  }
  return bytes;
}

std::shared_ptr<DiskCache> Open(const std::filesystem::path& folder, std::uint64_t most = plenty)
{
  auto cache = DiskCache::Open(folder, most);
  EXPECT_TRUE(cache) << cache.GetError().message;
  return cache ? *cache : nullptr;
}

void Sql(const std::filesystem::path& folder, const std::string& sql)
{
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open((folder / "blobs.sqlite").c_str(), &database), SQLITE_OK);
  EXPECT_EQ(sqlite3_exec(database, sql.c_str(), nullptr, nullptr, nullptr), SQLITE_OK)
    << sqlite3_errmsg(database);
  sqlite3_close(database);
}

// Finds an entry, after waiting until it is on the disk.
std::optional<Bytes> FindSoon(DiskCache& cache, const CacheKey& key)
{
  for (int i = 0; i < 500; ++i)
  {
    if (auto found = cache.Find(key))
    {
      return found;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return std::nullopt;
}

// Otherwise anybody who may write to the folder could make this program compute without end.
TEST(TestDiskCache, TablesOfAnotherProgramAreReplaced)
{
  const std::string endless = "(WITH RECURSIVE c(x) AS (SELECT 1 UNION ALL SELECT x + 1 FROM c) "
                              "SELECT count(*) FROM c)";
  for (const std::string& change : { "ALTER TABLE entries RENAME TO e; CREATE VIEW entries AS "
                                     "SELECT origin, digest, name, used, sum, " +
                                       endless + " AS bytes FROM e",
         "CREATE TRIGGER t BEFORE INSERT ON entries BEGIN SELECT " + endless + "; END",
         std::string("CREATE INDEX i ON entries(length(hex(bytes)))"),
         std::string("ALTER TABLE entries ADD COLUMN more AS (hex(zeroblob(1000)))"),
         std::string("CREATE TABLE more(a)") })
  {
    const TemporaryFolder folder;
    {
      const auto cache = Open(folder.Path);
      cache->Put(Key(1), Content(1));
    }
    Sql(folder.Path, change);
    const auto cache = Open(folder.Path);
    EXPECT_FALSE(cache->Find(Key(1))) << change;
    cache->Put(Key(2), Content(2));
    EXPECT_EQ(FindSoon(*cache, Key(2)), Content(2)) << change;
  }
}

TEST(TestDiskCache, KeepsWhatWasPutBeyondItsLife)
{
  const TemporaryFolder folder;
  {
    const auto cache = Open(folder / "new/folder");
    EXPECT_FALSE(cache->Find(Key(1)));
    for (int i = 0; i < 100; ++i)
    {
      cache->Put(Key(i), Content(i));
    }
    cache->Put(Key(1), Content(1001)); // replaces the first
  }
  const auto cache = Open(folder / "new/folder");
  EXPECT_EQ(cache->Find(Key(1)), Content(1001));
  for (int i = 2; i < 100; ++i)
  {
    EXPECT_EQ(cache->Find(Key(i)), Content(i));
  }
  // Another origin, build or name means another entry.
  EXPECT_FALSE(cache->Find({ "http://b:1", "digest", "partitions/2" }));
  EXPECT_FALSE(cache->Find({ "http://a:1", "other", "partitions/2" }));
  EXPECT_FALSE(cache->Find({ "http://a:1", "digest", "partitions/200" }));
  const auto rights = std::filesystem::status(folder / "new/folder").permissions();
  EXPECT_EQ(rights & std::filesystem::perms::others_all, std::filesystem::perms::none);
}

TEST(TestDiskCache, WhatWasUsedLongestAgoGoesFirst)
{
  const TemporaryFolder folder;
  {
    const auto cache = Open(folder.Path);
    for (int i = 0; i < 100; ++i)
    {
      cache->Put(Key(i), Content(i));
    }
  }
  Sql(folder.Path, "UPDATE entries SET used = rowid");
  {
    const auto cache = Open(folder.Path);
    EXPECT_TRUE(cache->Find(Key(3))); // counts as a use
  }
  {
    const auto cache = Open(folder.Path, 50'000);
    cache->Put(Key(100), Content(100));
  }
  const auto cache = Open(folder.Path, 50'000);
  int kept = 0;
  for (int i = 0; i <= 100; ++i)
  {
    const auto found = cache->Find(Key(i));
    kept += found ? 1 : 0;
    EXPECT_TRUE(!found || *found == Content(i));
  }
  EXPECT_LE(kept, 50);
  EXPECT_GE(kept, 30);
  EXPECT_TRUE(cache->Find(Key(3)));
  EXPECT_TRUE(cache->Find(Key(100)));
  EXPECT_TRUE(cache->Find(Key(99)));
  EXPECT_FALSE(cache->Find(Key(4)));
}

TEST(TestDiskCache, TwoProgramsMayUseItAtOnce)
{
  const TemporaryFolder folder;
  const auto first = Open(folder.Path);
  const auto second = Open(folder.Path);
  std::thread other(
    [&]
    {
      for (int i = 0; i < 300; ++i)
      {
        second->Put(Key(i), Content(i));
        second->Find(Key(i / 2));
      }
    });
  for (int i = 300; i < 600; ++i)
  {
    first->Put(Key(i), Content(i));
    first->Find(Key(i - 100));
  }
  other.join();
  for (int i = 0; i < 600; ++i)
  {
    EXPECT_EQ(FindSoon(i % 2 == 0 ? *first : *second, Key(i)), Content(i)) << i;
  }
}

TEST(TestDiskCache, WhatIsDamagedIsNotFoundAndTakesItsPlaceAgain)
{
  const TemporaryFolder folder;
  {
    const auto cache = Open(folder.Path);
    cache->Put(Key(1), Content(1));
    cache->Put(Key(2), Content(2));
  }
  Sql(folder.Path, "UPDATE entries SET bytes = zeroblob(1000) WHERE name = 'partitions/1'");
  {
    const auto cache = Open(folder.Path);
    EXPECT_FALSE(cache->Find(Key(1)));
    EXPECT_EQ(cache->Find(Key(2)), Content(2));
    cache->Put(Key(1), Content(1));
  }
  EXPECT_EQ(Open(folder.Path)->Find(Key(1)), Content(1));
}

TEST(TestDiskCache, AnotherVersionsFileAndNoDatabaseBeginAnew)
{
  const TemporaryFolder folder;
  {
    const auto cache = Open(folder.Path);
    cache->Put(Key(1), Content(1));
  }
  Sql(folder.Path, "PRAGMA user_version = 77");
  {
    const auto cache = Open(folder.Path);
    EXPECT_FALSE(cache->Find(Key(1)));
    cache->Put(Key(2), Content(2));
  }
  EXPECT_EQ(Open(folder.Path)->Find(Key(2)), Content(2));
  std::ofstream(folder / "blobs.sqlite") << std::string(10'000, 'x');
  {
    const auto cache = Open(folder.Path);
    EXPECT_FALSE(cache->Find(Key(2)));
    cache->Put(Key(3), Content(3));
  }
  EXPECT_EQ(Open(folder.Path)->Find(Key(3)), Content(3));
}

// A limit on the size of files stands for a full disk.
TEST(TestDiskCache, AFullDiskIsReportedOnceAndWhatIsThereStays)
{
  const TemporaryFolder folder;
  {
    const auto cache = Open(folder.Path);
    cache->Put(Key(1), Content(1));
  }
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit little{ 100'000, before.rlim_max };
  std::atomic<int> reported = 0;
  {
    auto cache = DiskCache::Open(folder.Path, plenty,
      [&reported](const Error& why)
      { reported += why.message.empty() || why.remedy == Remedy::Retry ? 100 : 1; });
    ASSERT_TRUE(cache);
    setrlimit(RLIMIT_FSIZE, &little);
    for (int i = 2; i < 5; ++i)
    {
      (*cache)->Put(Key(i), Content(i, 1'000'000));
    }
    for (int i = 0; i < 500 && reported == 0; ++i)
    {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    (*cache)->Put(Key(6), Content(6));
    EXPECT_EQ((*cache)->Find(Key(1)), Content(1));
  }
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);
  EXPECT_EQ(reported, 1);
  const auto cache = Open(folder.Path);
  EXPECT_EQ(cache->Find(Key(1)), Content(1));
  EXPECT_FALSE(cache->Find(Key(3)));
}

// For example in /tmp: the cache does not decide who may write there. But its file is readable only
// by the owner.
TEST(TestDiskCache, AFolderThatWasThereKeepsItsPermissions)
{
  const TemporaryFolder folder;
  const auto modeOf = [](const std::filesystem::path& path)
  {
    struct stat state = {};
    return ::stat(path.c_str(), &state) == 0 ? state.st_mode & 07777 : 0;
  };
  for (const mode_t mode : { 01777, 0755, 0750 })
  {
    ASSERT_EQ(::chmod(folder.Path.c_str(), mode), 0);
    Open(folder.Path)->Put(Key(1), Content(1));
    EXPECT_EQ(modeOf(folder.Path), mode);
    EXPECT_EQ(modeOf(folder / "blobs.sqlite"), 0600U);
  }
  Open(folder / "new/cache");
  EXPECT_EQ(modeOf(folder / "new/cache"), 0700U);
}

// A long transaction of another program is not damage: no entry is removed, and readers do not
// wait.
TEST(TestDiskCache, ABusyFileIsNotADamagedOne)
{
  const TemporaryFolder folder;
  const auto before = Open(folder.Path);
  before->Put(Key(1), Content(1));
  ASSERT_TRUE(FindSoon(*before, Key(1)));
  sqlite3* other = nullptr;
  ASSERT_EQ(sqlite3_open((folder / "blobs.sqlite").c_str(), &other), SQLITE_OK);
  sqlite3_busy_timeout(other, 60000); // the cache also writes when something was found
  ASSERT_EQ(sqlite3_exec(other, "BEGIN IMMEDIATE", nullptr, nullptr, nullptr), SQLITE_OK);
  const auto busy = DiskCache::Open(folder.Path, plenty);
  ASSERT_TRUE(busy) << busy.GetError().message;
  EXPECT_EQ((*busy)->Find(Key(1)), Content(1));
  EXPECT_EQ(before->Find(Key(1)), Content(1));
  ASSERT_EQ(sqlite3_exec(other, "COMMIT", nullptr, nullptr, nullptr), SQLITE_OK);
  (*busy)->Put(Key(2), Content(2));
  EXPECT_EQ(FindSoon(**busy, Key(2)), Content(2));
  EXPECT_EQ(FindSoon(*before, Key(2)), Content(2)) << "it is the same file still";
  sqlite3_close(other);
}

// If another program makes the new file at the same time, the cache waits for a moment.
TEST(TestDiskCache, ANewFileMayBeBusyForAMoment)
{
  const TemporaryFolder folder;
  sqlite3* other = nullptr;
  ASSERT_EQ(sqlite3_open((folder / "blobs.sqlite").c_str(), &other), SQLITE_OK);
  ASSERT_EQ(sqlite3_exec(other, "BEGIN IMMEDIATE", nullptr, nullptr, nullptr), SQLITE_OK);
  std::thread ends(
    [other]
    {
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
      EXPECT_EQ(sqlite3_exec(other, "COMMIT", nullptr, nullptr, nullptr), SQLITE_OK);
    });
  const auto cache = DiskCache::Open(folder.Path, plenty);
  ends.join();
  sqlite3_close(other);
  ASSERT_TRUE(cache) << cache.GetError().message;
  (*cache)->Put(Key(1), Content(1));
  EXPECT_EQ(FindSoon(**cache, Key(1)), Content(1));
}

// A file is not damaged either if another program has locked it, so that its version cannot be
// read.
TEST(TestDiskCache, ALockedFileStaysAsItIs)
{
  const TemporaryFolder folder;
  sqlite3* other = nullptr;
  ASSERT_EQ(sqlite3_open((folder / "blobs.sqlite").c_str(), &other), SQLITE_OK);
  ASSERT_EQ(
    sqlite3_exec(other, "CREATE TABLE precious(x); BEGIN EXCLUSIVE", nullptr, nullptr, nullptr),
    SQLITE_OK);
  EXPECT_FALSE(DiskCache::Open(folder.Path, plenty));
  ASSERT_EQ(
    sqlite3_exec(other, "INSERT INTO precious VALUES(1); COMMIT", nullptr, nullptr, nullptr),
    SQLITE_OK);
  sqlite3_close(other);
  Sql(folder.Path, "SELECT x FROM precious");
}

// If another program keeps the file busy, the cache does not wait again and again, and reports this
// once.
TEST(TestDiskCache, AFileThatStaysBusyIsReportedOnce)
{
  const TemporaryFolder folder;
  Open(folder.Path)->Put(Key(1), Content(1));
  for (const std::string mode : { "NORMAL", "EXCLUSIVE" }) // EXCLUSIVE: nobody can read
  {
    sqlite3* other = nullptr;
    ASSERT_EQ(sqlite3_open((folder / "blobs.sqlite").c_str(), &other), SQLITE_OK);
    const std::string lock = "PRAGMA locking_mode = " + mode + "; BEGIN EXCLUSIVE";
    ASSERT_EQ(sqlite3_exec(other, lock.c_str(), nullptr, nullptr, nullptr), SQLITE_OK);
    std::atomic<int> reported = 0;
    Error why;
    {
      const auto onTrouble = [&](const Error& error)
      {
        why = error;
        ++reported;
      };
      const auto cache = DiskCache::Open(folder.Path, plenty, onTrouble);
      ASSERT_TRUE(cache) << cache.GetError().message;
      EXPECT_EQ((*cache)->Find(Key(1)), Content(1)) << mode;
      for (int i = 2; i < 5; ++i)
      {
        (*cache)->Put(Key(i), Content(i));
      }
    }
    EXPECT_EQ(reported, 1) << mode;
    EXPECT_EQ(why.code, ErrorCode::InputOutput) << mode;
    EXPECT_EQ(why.remedy, Remedy::Retry) << mode << ": " << why.message;
    sqlite3_close(other);
  }
  const auto cache = Open(folder.Path);
  EXPECT_EQ(cache->Find(Key(1)), Content(1));
  cache->Put(Key(5), Content(5));
  EXPECT_EQ(FindSoon(*cache, Key(5)), Content(5));
}

// In a folder that others may write to, the name may lead to any file.
TEST(TestDiskCache, AnotherUsersFileThatALinkLeadsToIsNotTouched)
{
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder / "cache");
  std::ofstream(folder / "victim") << std::string(5000, 'v');
  std::filesystem::create_symlink("../victim", folder / "cache/blobs.sqlite");
  const auto cache = DiskCache::Open(folder / "cache", plenty);
  ASSERT_FALSE(cache);
  EXPECT_EQ(cache.GetError().code, ErrorCode::InputOutput);
  EXPECT_EQ(cache.GetError().file, folder / "cache/blobs.sqlite");
  EXPECT_EQ(fixtures::ReadWhole(folder / "victim"), std::string(5000, 'v'));
  EXPECT_TRUE(std::filesystem::is_symlink(folder / "cache/blobs.sqlite"));
  // If the link leads to nothing, no file is made there.
  std::filesystem::remove(folder / "victim");
  EXPECT_FALSE(DiskCache::Open(folder / "cache", plenty));
  EXPECT_FALSE(std::filesystem::exists(folder / "victim"));
}

// SQLite would write through such a link, or trust such a file.
TEST(TestDiskCache, FilesOfOthersBesideTheFileAreNotTouched)
{
  for (const std::string ending : { "-wal", "-shm", "-journal" })
  {
    const TemporaryFolder folder;
    Open(folder / "cache")->Put(Key(1), Content(1));
    const auto planted = folder / ("cache/blobs.sqlite" + ending);
    std::filesystem::create_symlink("../victim", planted);
    Error why;
    const auto cache =
      DiskCache::Open(folder / "cache", plenty, [&why](const Error& error) { why = error; });
    ASSERT_TRUE(cache) << cache.GetError().message;
    EXPECT_EQ((*cache)->Find(Key(1)), Content(1)) << "it is read without them";
    EXPECT_EQ(why.code, ErrorCode::InputOutput);
    EXPECT_EQ(why.file, planted.string());
    EXPECT_EQ(why.remedy, Remedy::Unknown) << why.message;
    EXPECT_TRUE(std::filesystem::is_symlink(planted));
    EXPECT_FALSE(std::filesystem::exists(folder / "victim")) << ending;
  }
}

TEST(TestDiskCache, AFolderThatCannotBeIsRefused)
{
  const TemporaryFolder folder;
  std::ofstream(folder / "file") << "";
  const auto cache = DiskCache::Open(folder / "file/cache", plenty);
  ASSERT_FALSE(cache);
  EXPECT_EQ(cache.GetError().code, ErrorCode::InputOutput);
  EXPECT_EQ(cache.GetError().file, folder / "file/cache");
}

}
