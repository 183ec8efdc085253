// SPDX-License-Identifier: BSD-3-Clause
// Durability: the bytes are on the disk before the file gets its name, and the name is on the disk
// afterwards. This program's own fsync records its calls.
#include "Testing/Fixtures/ErrorAt.h"
#include "filters/files/Folders.h"
#include "filters/files/NewFile.h"
#include "filters/files/WriteWhole.h"

#include "Testing/Fixtures/TemporaryFolder.h"

#include <gtest/gtest.h>

#include <cerrno>
#include <functional>
#include <set>

#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

namespace
{

std::function<void(const struct stat& state)> onSync;
bool folderFails = false;

}

extern "C" int fsync(int descriptor)
{
  struct stat state = {};
  if (onSync && ::fstat(descriptor, &state) == 0)
  {
    onSync(state);
    if (folderFails && S_ISDIR(state.st_mode))
    {
      errno = EIO;
      return -1;
    }
  }
  return static_cast<int>(::syscall(SYS_fsync, descriptor));
}

using namespace kdstream;
using fixtures::ReadWhole;
using fixtures::TemporaryFolder;
namespace fs = std::filesystem;

namespace
{

class DurableFile : public ::testing::Test
{
protected:
  ~DurableFile() override
  {
    onSync = {};
    folderFails = false;
  }
};

}

TEST_F(DurableFile, WaitsForItsBytesThenForItsName)
{
  const TemporaryFolder folder;
  const fs::path file = folder / "a";
  ASSERT_TRUE(WriteWhole(file, "old"));
  std::string calls;
  onSync = [&](const struct stat& state)
  { calls += (S_ISDIR(state.st_mode) ? "folder " : "file ") + ReadWhole(file) + ";"; };
  ASSERT_TRUE(WriteWhole(file, "new"));
  EXPECT_EQ(calls, "file old;folder new;");
  calls.clear();
  auto temporary = NewFile::Create(file);
  ASSERT_TRUE(temporary);
  ASSERT_TRUE(temporary->Finish(NewFile::Lasts::Processes));
  EXPECT_EQ(calls, "");
}

// A disk failure is reported, and the message says where the file is now.
TEST_F(DurableFile, SaysWhereItIsWhenTheFolderFails)
{
  const TemporaryFolder folder;
  onSync = [](const struct stat&) {};
  folderFails = true;
  const Status written = WriteWhole(folder / "a", "new");
  EXPECT_TRUE(fixtures::FailsAt(written, ErrorCode::InputOutput, "is written"));
  EXPECT_EQ(ReadWhole(folder / "a"), "new");
}

TEST_F(DurableFile, ATreeIsWaitedForWhole)
{
  const TemporaryFolder folder;
  fs::create_directories(folder / "a/b/c");
  std::set<ino_t> all, synced;
  const auto numberOf = [](const fs::path& path)
  {
    struct stat state = {};
    return ::stat(path.c_str(), &state) == 0 ? state.st_ino : 0;
  };
  for (const std::string name : { "1", "a/2", "a/b/3", "a/b/c/4" })
  {
    ASSERT_TRUE(WriteAnew(folder / name, "x"));
    all.insert({ numberOf(folder / name), numberOf((folder / name).parent_path()) });
  }
  onSync = [&](const struct stat& state) { synced.insert(state.st_ino); };
  ASSERT_TRUE(SyncTree(folder.Path));
  EXPECT_EQ(synced, all);
}
