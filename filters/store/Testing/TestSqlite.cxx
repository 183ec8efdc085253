// SPDX-License-Identifier: BSD-3-Clause
// Names of files that SQLite cannot be given, and files that cannot be read.
#include "filters/store/Sqlite.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <string>

using namespace kdstream;
namespace fs = std::filesystem;

namespace
{

// A current folder that somebody has removed: relative names lead nowhere then.
TEST(TestSqlite, ARemovedCurrentFolderIsAnError)
{
  const fs::path before = fs::current_path();
  std::string name = (fs::temp_directory_path() / "kdstream-sqlite-XXXXXX").string();
  ASSERT_NE(::mkdtemp(name.data()), nullptr);
  fs::current_path(name);
  fs::remove(name);
  const Result<Database> opened = OpenForWriting("model.kds");
  fs::current_path(before);
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.GetError().code, ErrorCode::InputOutput);
  EXPECT_EQ(
    opened.GetError().message, "the current folder cannot be found: No such file or directory");
}

// What the system refuses may pass: it is not taken for damage.
TEST(TestSqlite, AReadThatFailsIsNoDamage)
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
    EXPECT_EQ(number.GetError().code, ErrorCode::InputOutput);
    EXPECT_EQ(number.GetError().message, "cannot be read or written: Bad file descriptor");
  }
  ::close(descriptor);
  ::close(unreadable);
}

}
