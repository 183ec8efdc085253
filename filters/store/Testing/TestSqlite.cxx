// SPDX-License-Identifier: BSD-3-Clause
// Names of files that SQLite cannot be given.
#include "filters/store/Sqlite.h"

#include <gtest/gtest.h>

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
  const Result<Database> read = OpenForReading("model.kds");
  const Result<Database> written = OpenForWriting("model.kds");
  fs::current_path(before);
  for (const Result<Database>* const opened : { &read, &written })
  {
    ASSERT_FALSE(*opened);
    EXPECT_EQ(opened->GetError().code, ErrorCode::InputOutput);
    EXPECT_EQ(
      opened->GetError().message, "the current folder cannot be found: No such file or directory");
  }
}

}
