// SPDX-License-Identifier: BSD-3-Clause
// File names that cannot be passed to SQLite, and files that cannot be read.
#include "Testing/Fixtures/ErrorAt.h"
#include "Testing/Fixtures/TemporaryFolder.h"
#include "filters/store/Sqlite.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sqlite3.h>
#include <unistd.h>

#include <array>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <string>

using namespace kdstream;
namespace fs = std::filesystem;

namespace
{

// If the current folder was removed, relative names lead nowhere.
TEST(TestSqlite, ARemovedCurrentFolderIsAnError)
{
  const fs::path before = fs::current_path();
  const fixtures::TemporaryFolder folder;
  fs::current_path(folder.Path);
  fs::remove(folder.Path);
  const Result<Database> opened = OpenForWriting("model.kds");
  fs::current_path(before);
  ASSERT_FALSE(opened);
  EXPECT_TRUE(fixtures::FailsAt(opened, ErrorCode::InputOutput));
}

// A read that the system refuses may succeed later, so it does not count as damage.
TEST(TestSqlite, AReadThatFailsIsNotDamage)
{
  const fs::path file =
    fs::temp_directory_path() / ("kdstream-sqlite-" + std::to_string(::getpid()));
  {
    const Result<Database> written = OpenForWriting(file);
    ASSERT_TRUE(written);
    ASSERT_TRUE(
      Execute(written->get(), "CREATE TABLE numbers (n); INSERT INTO numbers VALUES (7)"));
  }
  const int descriptor = ::open(file.c_str(), O_RDONLY),
            unreadable = ::open(file.c_str(), O_WRONLY);
  fs::remove(file);
  ASSERT_GE(descriptor, 0);
  ASSERT_GE(unreadable, 0);
  const char* const select = "SELECT n FROM numbers";
  {
    const Result<Database> database = OpenForReading(descriptor);
    ASSERT_TRUE(database);
    EXPECT_EQ(QueryInteger(database->get(), select).Value(), 7);
    const Result<Database> refused = OpenForReading(unreadable);
    const Result<std::int64_t> number =
      refused ? QueryInteger(refused->get(), select) : refused.GetError();
    ASSERT_FALSE(number);
    EXPECT_TRUE(fixtures::FailsAt(number, ErrorCode::InputOutput));
  }
  ::close(descriptor);
  ::close(unreadable);
}

// A file with some numbers, changed by the statements `more`.
class StrangersFile
{
public:
  explicit StrangersFile(const std::string& more = "")
  {
    sqlite3* database = nullptr;
    EXPECT_EQ(sqlite3_open(this->Path.c_str(), &database), SQLITE_OK);
    const std::string all = "CREATE TABLE numbers (n); INSERT INTO numbers VALUES (7);" + more;
    EXPECT_EQ(sqlite3_exec(database, all.c_str(), nullptr, nullptr, nullptr), SQLITE_OK)
      << sqlite3_errmsg(database);
    EXPECT_EQ(sqlite3_close(database), SQLITE_OK);
    this->Descriptor = ::open(this->Path.c_str(), O_RDWR | O_CLOEXEC);
    EXPECT_GE(this->Descriptor, 0);
  }
  ~StrangersFile()
  {
    ::close(this->Descriptor);
    fs::remove(this->Path);
  }
  StrangersFile(const StrangersFile&) = delete;
  StrangersFile& operator=(const StrangersFile&) = delete;

  const fs::path Path =
    fs::temp_directory_path() / ("kdstream-stranger-" + std::to_string(::getpid()));
  int Descriptor = -1;
};

const std::string endless = "WITH RECURSIVE c(x) AS (SELECT 1 UNION ALL SELECT x + 1 FROM c) ";

TEST(TestSqlite, AStatementThatDoesNotEndIsEnded)
{
  const StrangersFile file;
  for (const Result<Database>& database :
    { OpenForReading(file.Descriptor), OpenForWriting(file.Descriptor) })
  {
    ASSERT_TRUE(database);
    const auto counted = QueryInteger(database->get(), endless + "SELECT count(*) FROM c");
    ASSERT_FALSE(counted);
    EXPECT_TRUE(fixtures::FailsAt(counted, ErrorCode::Damaged));
    // The work for all rows of a statement counts together.
    auto rows = Statement::Prepare(database->get(), (endless + "SELECT x FROM c").c_str());
    ASSERT_TRUE(rows);
    Result<bool> row = true;
    std::uint64_t count = 0;
    for (; row && *row; row = rows->Step())
    {
      ++count;
    }
    EXPECT_FALSE(row);
    EXPECT_LT(count, 1'100'000u);
    // Each further statement may take as long again.
    EXPECT_EQ(QueryInteger(database->get(), "SELECT n FROM numbers").Value(), 7);
    rows->Reset();
    EXPECT_TRUE(rows->Step());
  }
}

TEST(TestSqlite, ViewsAndTriggersOfAFileDoNotRun)
{
  const StrangersFile file("CREATE VIEW seen AS SELECT n FROM numbers; CREATE TABLE told (n);"
                           "CREATE TRIGGER t AFTER UPDATE ON numbers BEGIN INSERT INTO told VALUES "
                           "(new.n); END");
  const auto reading = OpenForReading(file.Descriptor);
  ASSERT_TRUE(reading);
  EXPECT_FALSE(QueryInteger(reading->get(), "SELECT n FROM seen"));
  const auto byName = OpenForWriting(file.Path);
  ASSERT_TRUE(byName);
  ASSERT_TRUE(Execute(byName->get(), "UPDATE numbers SET n = 8"));
  EXPECT_FALSE(QueryInteger(byName->get(), "SELECT n FROM seen"));
  EXPECT_EQ(QueryInteger(byName->get(), "SELECT count(*) FROM told").Value(), 0);
  // Neither can another file be attached, nor the schema be written.
  EXPECT_FALSE(Execute(byName->get(), "ATTACH '/tmp/other' AS other"));
  EXPECT_TRUE(Execute(byName->get(), "PRAGMA writable_schema = ON"));
  EXPECT_FALSE(Execute(byName->get(), "DELETE FROM sqlite_schema"));
}

TEST(TestSqlite, ValuesThatAreTooLargeAreRefused)
{
  const StrangersFile file;
  const auto database = OpenForReading(file.Descriptor);
  ASSERT_TRUE(database);
  const auto hexadecimal = [&](int bytes)
  {
    return QueryInteger(
      database->get(), "SELECT length(hex(zeroblob(" + std::to_string(bytes) + ")))");
  };
  EXPECT_EQ(hexadecimal(1 << 20).Value(), 2 << 20);
  ASSERT_FALSE(hexadecimal(1 << 26));
  EXPECT_TRUE(fixtures::FailsAt(hexadecimal(1 << 26), ErrorCode::Damaged));
  LimitValues(database->get(), 1000);
  EXPECT_FALSE(hexadecimal(1 << 20));
}

TEST(TestSqlite, ASchemaIsComparedToTheLetter)
{
  constexpr std::array<std::string_view, 1> expected{ "CREATE TABLE numbers (n)" };
  const auto same = [&expected](const std::string& more)
  {
    const StrangersFile file(more);
    const auto database = OpenForReading(file.Descriptor);
    return database && HasSchema(database->get(), expected).Value();
  };
  EXPECT_TRUE(same(""));
  EXPECT_FALSE(same("ALTER TABLE numbers ADD COLUMN m"));
  EXPECT_FALSE(same("CREATE INDEX i ON numbers(n)"));
  EXPECT_FALSE(same("CREATE VIEW v AS SELECT 1"));
  EXPECT_FALSE(same("DROP TABLE numbers"));
}

}
