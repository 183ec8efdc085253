// SPDX-License-Identifier: BSD-3-Clause
// Folders for temporary files: the next build removes those of killed processes, and no others.
#include "filters/outofcore/files/LockedFolder.h"
#include "filters/outofcore/files/SpillFile.h"

#include "Testing/Fixtures/TemporaryFolder.h"

#include <gtest/gtest.h>

#include <csignal>
#include <fstream>

#include <sys/wait.h>
#include <unistd.h>

namespace kdstream
{
namespace
{

namespace fs = std::filesystem;
using fixtures::TemporaryFolder;

// A process that makes a folder with a file in it, then waits to be killed.
class Holder
{
public:
  explicit Holder(const fs::path& parent)
  {
    int ends[2] = {};
    EXPECT_EQ(::pipe(ends), 0);
    this->Process = ::fork();
    if (this->Process == 0)
    {
      Result<SpillFolder> folder = SpillFolder::Create(parent);
      const bool made = folder && folder->CreateFile("points", 0);
      std::ofstream(folder->Path() / "points") << "1 2 3\n";
      const char ready = made ? 1 : 0;
      if (::write(ends[1], &ready, 1) == 1)
      {
        ::pause();
      }
      ::_exit(1);
    }
    char ready = 0;
    EXPECT_EQ(::read(ends[0], &ready, 1), 1);
    EXPECT_EQ(ready, 1);
    ::close(ends[0]);
    ::close(ends[1]);
  }
  ~Holder() { this->Kill(); }
  Holder(const Holder&) = delete;
  Holder& operator=(const Holder&) = delete;

  void Kill()
  {
    if (this->Process > 0)
    {
      ::kill(this->Process, SIGKILL);
      ::waitpid(std::exchange(this->Process, 0), nullptr, 0);
    }
  }

private:
  pid_t Process = 0;
};

std::size_t CountEntries(const fs::path& folder)
{
  return static_cast<std::size_t>(
    std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

TEST(LockedFolder, GoesWithTheNextBuildOnceItsProcessWasKilled)
{
  const TemporaryFolder parent;
  Holder killed(parent.Path), alive(parent.Path);
  EXPECT_EQ(CountEntries(parent.Path), 2U);
  for (const fs::directory_entry& entry : fs::directory_iterator(parent.Path))
  {
    EXPECT_EQ(entry.path().filename().string()[0], '.') << entry.path() << " is seen by all";
  }
  RemoveDeadFolders(parent.Path);
  EXPECT_EQ(CountEntries(parent.Path), 2U) << "processes that work keep theirs";
  killed.Kill();
  RemoveDeadFolders(parent.Path);
  EXPECT_EQ(CountEntries(parent.Path), 1U);
  alive.Kill();
  RemoveDeadFolders(parent.Path);
  EXPECT_EQ(CountEntries(parent.Path), 0U);
}

TEST(LockedFolder, StaysWhileThisProcessHasIt)
{
  const TemporaryFolder parent;
  {
    const Result<SpillFolder> folder = SpillFolder::Create(parent.Path);
    ASSERT_TRUE(folder);
    RemoveDeadFolders(parent.Path);
    EXPECT_TRUE(fs::exists(folder->Path()));
  }
  EXPECT_EQ(CountEntries(parent.Path), 0U);
}

// A name does not prove who made a file: files, links, and folders that others made stay.
TEST(LockedFolder, WhatOnlyLooksLikeOneStays)
{
  const TemporaryFolder parent, elsewhere;
  std::ofstream(elsewhere / "kept") << "1\n";
  const std::string begin = ".kdstream-files-";
  std::ofstream(parent / (begin + "0123456789abcdef-7-abcdef")) << "a file\n";
  fs::create_directory_symlink(elsewhere.Path, parent / (begin + "0123456789abcdef-8-abcdef"));
  for (const char* const rest : { "", "-", "--", "x-y-z", "x-7", "x-0-abc", "x--7-abc", "x-7z-abc",
         "x-99999999999999999999-abc" })
  {
    fs::create_directory(parent / (begin + rest));
  }
  fs::create_directory(parent / ".kdstream-other");
  const std::size_t before = CountEntries(parent.Path);
  RemoveDeadFolders(parent.Path);
  EXPECT_EQ(CountEntries(parent.Path), before);
  EXPECT_TRUE(fs::exists(elsewhere / "kept"));
  RemoveDeadFolders(parent / "none"); // without an error
}

}
}
