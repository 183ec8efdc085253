// SPDX-License-Identifier: BSD-3-Clause
// A file that replaces its target when it is complete. No other file is changed, and the target's
// permissions are kept.
#include "Testing/Fixtures/ErrorAt.h"
#include "filters/files/NewFile.h"

#include "Testing/Fixtures/TemporaryFolder.h"
#include "filters/files/WriteWhole.h"

#include <gtest/gtest.h>

#include <csignal>
#include <set>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

using namespace kdstream;
using fixtures::ReadWhole;
using fixtures::TemporaryFolder;
namespace fs = std::filesystem;

namespace
{

mode_t ModeOf(const fs::path& file)
{
  struct stat state = {};
  return ::stat(file.c_str(), &state) == 0 ? state.st_mode & 0777 : 0;
}

// Calls work() in a process of its own, as a user who is not root. Returns whether work() returned
// true.
template <class Work>
bool AsAnybody(const Work& work)
{
  const pid_t child = ::fork();
  if (child == 0)
  {
    constexpr uid_t nobody = 65534;
    const bool changed = ::geteuid() != 0 || ::setresuid(nobody, nobody, nobody) == 0;
    ::_exit(changed && work() ? 0 : 1);
  }
  int state = 0;
  ::waitpid(child, &state, 0);
  return WIFEXITED(state) && WEXITSTATUS(state) == 0;
}

constexpr mode_t usualMask = 022;

class NewFileTest : public ::testing::Test
{
protected:
  NewFileTest()
    : Mask(::umask(usualMask))
  {
  }
  ~NewFileTest() override { ::umask(this->Mask); }
  fs::path File() const { return this->Folder / "out.json"; }
  Status Write(const std::string& bytes) const { return WriteWhole(this->File(), bytes); }

  TemporaryFolder Folder;

private:
  mode_t Mask;
};

}

TEST_F(NewFileTest, IsThereWholeOrNotAtAll)
{
  ASSERT_TRUE(this->Write("old"));
  {
    auto file = NewFile::Create(this->File());
    ASSERT_TRUE(file);
    ASSERT_TRUE(file->Write("new and unfinished"));
    EXPECT_EQ(ReadWhole(this->File()), "old");
    EXPECT_EQ(this->Folder.Names().size(), 2U);
  }
  EXPECT_EQ(this->Folder.Names(), std::set<std::string>{ "out.json" });
  EXPECT_EQ(ReadWhole(this->File()), "old");
  ASSERT_TRUE(this->Write("new"));
  EXPECT_EQ(ReadWhole(this->File()), "new");
  EXPECT_EQ(this->Folder.Names(), std::set<std::string>{ "out.json" });
}

// Links with the names of temporary files might lead to files of other users.
TEST_F(NewFileTest, NoLinkBesideItIsFollowed)
{
  std::ofstream(this->Folder / "victim") << "precious";
  const std::string process = std::to_string(::getpid());
  for (const std::string name : { "out.json.new", "out.json.part", "out.json.tmp", "out.json~",
         ".out.json.new", ".out.json.unfinished" })
  {
    fs::create_symlink("victim", this->Folder / name);
  }
  fs::create_symlink("victim", this->Folder / ("out.json.tmp-" + process + "-0"));
  fs::create_symlink("victim", this->Folder / ".out.json.aaaaaa.unfinished"); // like a leftover
  const auto before = this->Folder.Names();
  for (const std::string bytes : { "one", "two" })
  {
    NewFile::RemoveLeftovers(this->File());
    ASSERT_TRUE(this->Write(bytes));
    EXPECT_EQ(ReadWhole(this->File()), bytes);
    EXPECT_EQ(ReadWhole(this->Folder / "victim"), "precious");
  }
  auto after = before;
  after.insert("out.json");
  EXPECT_EQ(this->Folder.Names(), after);
}

TEST_F(NewFileTest, NamesCannotBeForeseen)
{
  std::set<fs::path> names;
  for (int i = 0; i < 20; ++i)
  {
    names.insert(NewFile::Create(this->File())->Path());
  }
  EXPECT_EQ(names.size(), 20U);
  const fs::path longest = this->Folder / std::string(255, 'n');
  ASSERT_TRUE(WriteWhole(longest, "x"));
  EXPECT_EQ(ReadWhole(longest), "x");
}

TEST_F(NewFileTest, ANewOneHasWhatTheUmaskGives)
{
  for (const auto& [mask, mode] :
    { std::pair<mode_t, mode_t>{ 022, 0644 }, { 077, 0600 }, { 0, 0666 } })
  {
    ::umask(mask);
    ASSERT_TRUE(this->Write("x"));
    EXPECT_EQ(ModeOf(this->File()), mode);
    fs::remove(this->File());
  }
}

TEST_F(NewFileTest, AReplacedFileKeepsItsPermissionsAlsoWhileItIsWritten)
{
  for (const mode_t mode : { 0600, 0640, 0664, 0444, 0755 })
  {
    ASSERT_TRUE(this->Write("x"));
    ASSERT_EQ(::chmod(this->File().c_str(), mode), 0);
    auto file = NewFile::Create(this->File());
    ASSERT_TRUE(file);
    EXPECT_EQ(ModeOf(file->Path()), 0600U);
    ASSERT_TRUE(file->Finish());
    EXPECT_EQ(ModeOf(this->File()), mode);
  }
}

TEST_F(NewFileTest, RootLeavesAFileToItsOwner)
{
  if (::geteuid() != 0)
  {
    GTEST_SKIP() << "only root gives files away";
  }
  ASSERT_TRUE(this->Write("x"));
  ASSERT_EQ(::chown(this->File().c_str(), 1234, 4321), 0);
  ASSERT_TRUE(this->Write("y"));
  struct stat state = {};
  ASSERT_EQ(::stat(this->File().c_str(), &state), 0);
  EXPECT_EQ(state.st_uid, 1234U);
  EXPECT_EQ(state.st_gid, 4321U);
}

TEST_F(NewFileTest, ALinkIsReplacedAndWhatItLeadsToStays)
{
  std::ofstream(this->Folder / "private") << "precious";
  ASSERT_EQ(::chmod((this->Folder / "private").c_str(), 0600), 0);
  fs::create_symlink("private", this->File());
  ASSERT_TRUE(this->Write("x"));
  EXPECT_FALSE(fs::is_symlink(this->File()));
  EXPECT_EQ(ModeOf(this->File()), 0600U) << "it was private";
  EXPECT_EQ(ReadWhole(this->Folder / "private"), "precious");
  // The new file does not become writable for everybody either, even if the target of a stranger's
  // link is.
  fs::remove(this->File());
  ASSERT_EQ(::chmod((this->Folder / "private").c_str(), 0666), 0);
  fs::create_symlink("private", this->File());
  ASSERT_TRUE(this->Write("x"));
  EXPECT_EQ(ModeOf(this->File()), 0644U);
  // If a link leads nowhere, nothing is created at its target.
  fs::remove(this->File());
  fs::create_symlink("nowhere", this->File());
  ASSERT_TRUE(this->Write("x"));
  EXPECT_FALSE(fs::exists(this->Folder / "nowhere"));
}

TEST_F(NewFileTest, WhatIsNotARegularFileIsNotTouched)
{
  fs::create_directory(this->File());
  EXPECT_FALSE(this->Write("x"));
  fs::remove(this->File());
  ASSERT_EQ(::mkfifo(this->File().c_str(), 0600), 0);
  EXPECT_FALSE(this->Write("x"));
  EXPECT_FALSE(WriteWhole(this->Folder / "none/x", "x"));
  EXPECT_EQ(this->Folder.Names(), std::set<std::string>{ "out.json" });
}

TEST_F(NewFileTest, WhatKilledWritersHaveLeftGoesAndWhatIsBeingWrittenStays)
{
  const fs::path left = this->Folder / ".out.json.abcdef.unfinished";
  const fs::path other = this->Folder / ".other.json.abcdef.unfinished";
  std::ofstream(left) << "half";
  std::ofstream(other) << "half";
  auto writing = NewFile::Create(this->File());
  ASSERT_TRUE(writing);
  NewFile::RemoveLeftovers(this->File());
  EXPECT_FALSE(fs::exists(left));
  EXPECT_TRUE(fs::exists(other));
  EXPECT_TRUE(fs::exists(writing->Path()));
  ASSERT_TRUE(writing->Finish());
}

// If the rename has worked, a folder that cannot be synchronized is not reported as a failure.
TEST_F(NewFileTest, IsWrittenInAFolderThatCannotBeRead)
{
  ASSERT_EQ(::chmod(this->Folder.Path.c_str(), 0777), 0);
  ASSERT_TRUE(AsAnybody([&] { return this->Write("old").HasValue(); }));
  ASSERT_EQ(::chmod(this->Folder.Path.c_str(), 0333), 0);
  EXPECT_TRUE(AsAnybody([&] { return this->Write("new").HasValue(); }));
  ASSERT_EQ(::chmod(this->Folder.Path.c_str(), 0777), 0);
  EXPECT_EQ(ReadWhole(this->File()), "new");
}

// A limit on the size of files stands in for a full disk.
TEST_F(NewFileTest, AFullDiskLeavesWhatWas)
{
  ASSERT_TRUE(this->Write("old"));
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit little{ 1000, before.rlim_max };
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &little), 0);
  const Status written = this->Write(std::string(5000, 'x'));
  ::setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);
  EXPECT_TRUE(fixtures::FailsAt(written, ErrorCode::DiskFull));
  EXPECT_EQ(ReadWhole(this->File()), "old");
  EXPECT_EQ(this->Folder.Names(), std::set<std::string>{ "out.json" });
}
