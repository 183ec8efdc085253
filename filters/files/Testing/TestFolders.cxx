// SPDX-License-Identifier: BSD-3-Clause
#include "Testing/Fixtures/ErrorAt.h"
#include "filters/files/Folders.h"

#include "Testing/Fixtures/TemporaryFolder.h"

#include <gtest/gtest.h>

#include <sys/stat.h>

#include <set>
#include <string>

using namespace kdstream;
using fixtures::TemporaryFolder;
namespace fs = std::filesystem;

namespace
{

mode_t AllModeOf(const fs::path& folder)
{
  struct stat state = {};
  return ::stat(folder.c_str(), &state) == 0 ? state.st_mode & 07777 : 0;
}

}

TEST(Folders, AreMadeForTheirOwnerAndStayAsTheyAre)
{
  const TemporaryFolder folder;
  for (const std::string name : { "a/b/c", "d", "e/" })
  {
    ASSERT_TRUE(MakePrivateFolder(folder / name)) << name;
    EXPECT_EQ(AllModeOf(folder / name), 0700U);
  }
  for (const mode_t mode : { 01777, 0755, 02770, 0700 })
  {
    ASSERT_EQ(::chmod((folder / "d").c_str(), mode), 0);
    ASSERT_TRUE(MakePrivateFolder(folder / "d"));
    EXPECT_EQ(AllModeOf(folder / "d"), mode);
  }
  fs::create_symlink("d", folder / "link");
  EXPECT_TRUE(MakePrivateFolder(folder / "link"));
  std::ofstream(folder / "file") << "x";
  const Status file = MakePrivateFolder(folder / "file");
  ASSERT_TRUE(fixtures::FailsAt(file, ErrorCode::InputOutput));
  EXPECT_EQ(file.GetError().file, folder / "file");
  EXPECT_FALSE(MakePrivateFolder(folder / "file/in"));
}

TEST(Folders, AreWaitedForWithAllThatIsInThem)
{
  const TemporaryFolder folder;
  fs::create_directories(folder / "a/b");
  std::ofstream(folder / "a/b/file") << "x";
  fs::create_symlink("nowhere", folder / "a/link");
  EXPECT_TRUE(SyncTree(folder.Path));
  EXPECT_TRUE(SyncFolder(folder / "a"));
  EXPECT_FALSE(SyncTree(folder / "none"));
}

TEST(Folders, AreListedAndRemovedWithAllThatIsInThem)
{
  const TemporaryFolder folder;
  fs::create_directories(folder / "a/b");
  std::ofstream(folder / "a/b/file") << "x";
  std::ofstream(folder / "stays") << "x";
  fs::create_symlink(folder / "stays", folder / "a/link");
  fs::create_directory_symlink(folder.Path, folder / "a/out");
  const auto names = NamesIn(folder / "a");
  ASSERT_TRUE(names);
  EXPECT_EQ(std::set<std::string>(names->begin(), names->end()),
    (std::set<std::string>{ "b", "link", "out" }));
  EXPECT_FALSE(NamesIn(folder / "none"));
  RemoveTree(folder / "a");
  EXPECT_FALSE(fs::exists(folder / "a"));
  EXPECT_TRUE(fs::exists(folder / "stays")) << "links are not followed";
  RemoveTree(folder / "none");
  RemoveTree(folder / "stays"); // a file
  EXPECT_FALSE(fs::exists(folder / "stays"));
}
