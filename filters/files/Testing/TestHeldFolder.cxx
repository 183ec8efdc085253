// SPDX-License-Identifier: BSD-3-Clause
#include "Testing/Fixtures/ErrorAt.h"
#include "filters/files/HeldFolder.h"

#include "Testing/Fixtures/TemporaryFolder.h"

#include <gtest/gtest.h>

#include <sys/stat.h>
#include <unistd.h>

using namespace kdstream;
using fixtures::TemporaryFolder;
namespace fs = std::filesystem;

namespace
{

constexpr uid_t anotherUser = 1000;

mode_t ModeOf(const fs::path& path)
{
  struct stat state = {};
  return ::stat(path.c_str(), &state) == 0 ? state.st_mode & 07777 : 0;
}

}

TEST(HeldFolder, FollowsOnlyTheLinkThatIsNamed)
{
  const TemporaryFolder folder;
  fs::create_directories(folder / "real/away");
  fs::create_directory_symlink("real", folder / "link");
  fs::create_directory_symlink("away", folder / "real/below");
  const auto held = HeldFolder::Open(folder / "link");
  ASSERT_TRUE(held);
  EXPECT_EQ(held->Name(), folder / "link");
  const auto below = held->Below("below", 0777);
  ASSERT_FALSE(below);
  EXPECT_EQ(below.GetError().file, (folder / "link/below").string());
  EXPECT_TRUE(fixtures::FailsAt(below, ErrorCode::InputOutput));
  fs::create_symlink("nowhere", folder / "real/dangling");
  EXPECT_FALSE(held->Below("dangling", 0777));
  EXPECT_FALSE(fs::exists(folder / "real/nowhere"));
  bool made = true;
  EXPECT_TRUE(held->Below("away", 0777, &made));
  EXPECT_FALSE(made);
  EXPECT_TRUE(held->Below("new", 0700, &made));
  EXPECT_TRUE(made);
  EXPECT_EQ(ModeOf(folder / "real/new"), 0700U);
  std::ofstream(folder / "real/file") << "x";
  EXPECT_FALSE(held->Below("file", 0777));
  EXPECT_FALSE(HeldFolder::Open(folder / "none"));
  EXPECT_FALSE(HeldFolder::Open(folder / "real/file"));
}

TEST(HeldFolder, StaysTheFolderThatItWas)
{
  const TemporaryFolder folder;
  fs::create_directories(folder / "a/in");
  const auto held = HeldFolder::Open(folder / "a");
  ASSERT_TRUE(held);
  const auto in = held->Below("in", 0777);
  ASSERT_TRUE(in);
  fs::rename(folder / "a/in", folder / "moved");
  fs::create_directory(folder / "a/in");
  std::ofstream(in->Path() / "file") << "x";
  EXPECT_TRUE(fs::exists(folder / "moved/file"));
  EXPECT_TRUE(fs::is_empty(folder / "a/in"));
}

TEST(HeldFolder, UsesFilesAndFoldersOfItsUserOnly)
{
  const TemporaryFolder folder;
  const auto held = HeldFolder::Open(folder.Path);
  ASSERT_TRUE(held);
  ASSERT_TRUE(held->OwnBelow("new"));
  EXPECT_EQ(ModeOf(folder / "new"), 0700U);
  fs::create_directory(folder / "open");
  ASSERT_EQ(::chmod((folder / "open").c_str(), 0777), 0);
  ASSERT_TRUE(held->OwnBelow("open"));
  EXPECT_EQ(ModeOf(folder / "open"), 0755U);

  const auto none = held->HasOwnFile("file");
  ASSERT_TRUE(none);
  EXPECT_FALSE(*none);
  std::ofstream(folder / "file") << "x";
  const auto own = held->HasOwnFile("file");
  ASSERT_TRUE(own);
  EXPECT_TRUE(*own);
  fs::create_hard_link(folder / "file", folder / "twin");
  EXPECT_FALSE(held->HasOwnFile("file"));
  fs::remove(folder / "twin");
  fs::create_symlink("file", folder / "link");
  ASSERT_EQ(::mkfifo((folder / "fifo").c_str(), 0600), 0);
  for (const char* name : { "link", "fifo", "new" })
  {
    const auto other = held->HasOwnFile(name);
    ASSERT_FALSE(other) << name;
    EXPECT_TRUE(fixtures::FailsAt(other, ErrorCode::InputOutput));
    EXPECT_EQ(other.GetError().file, (folder / name).string());
  }
}

TEST(HeldFolder, DoesNotTouchAnotherUsersFiles)
{
  if (::geteuid() != 0)
  {
    GTEST_SKIP() << "only root can give files away";
  }
  const TemporaryFolder folder;
  fs::create_directory(folder / "theirs");
  std::ofstream(folder / "file") << "x";
  ASSERT_EQ(::chmod((folder / "theirs").c_str(), 0777), 0);
  ASSERT_EQ(::chown((folder / "theirs").c_str(), anotherUser, anotherUser), 0);
  ASSERT_EQ(::chown((folder / "file").c_str(), anotherUser, anotherUser), 0);
  const auto held = HeldFolder::Open(folder.Path);
  ASSERT_TRUE(held);
  EXPECT_FALSE(held->OwnBelow("theirs"));
  EXPECT_EQ(ModeOf(folder / "theirs"), 0777U);
  EXPECT_TRUE(held->Below("theirs", 0777));
  EXPECT_FALSE(held->HasOwnFile("file"));
}
