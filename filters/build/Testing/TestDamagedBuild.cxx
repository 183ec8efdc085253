// SPDX-License-Identifier: BSD-3-Clause
// Folders of killed builds that were damaged afterwards, on the disk or by hand. --resume must make
// the same store or report an error; it must never make another store, and never end by a signal.
#include "Testing/Fixtures/Meshes.h"
#include "filters/build/Testing/ExternalBuilderTest.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <functional>
#include <map>
#include <random>

#include <fcntl.h>
#include <sys/stat.h>

using namespace kdstream;
using namespace kdstream::fixtures;
namespace fs = std::filesystem;

namespace
{

// A file of a folder and its time of change, which damage to a disk does not alter.
struct KeptFile
{
  std::string bytes;
  timespec changed{};
};
using KeptFolder = std::map<std::string, KeptFile>;

KeptFolder Keep(const fs::path& folder)
{
  KeptFolder kept;
  for (const auto& entry : fs::directory_iterator(folder))
  {
    struct stat state = {};
    ::stat(entry.path().c_str(), &state);
    kept[entry.path().filename().string()] = { ReadWhole(entry.path()), state.st_mtim };
  }
  return kept;
}

void PutBack(const KeptFolder& kept, const fs::path& folder)
{
  fs::remove_all(folder);
  ASSERT_EQ(::mkdir(folder.c_str(), 0700), 0);
  for (const auto& [name, file] : kept)
  {
    std::ofstream(folder / name, std::ios::binary) << file.bytes;
    const timespec times[] = { file.changed, file.changed };
    ASSERT_EQ(::utimensat(AT_FDCWD, (folder / name).c_str(), times, 0), 0);
  }
}

class Damage
{
public:
  explicit Damage(unsigned seed)
    : Random(seed)
  {
  }

  // Damages the folder in one to three ways. Returns a description for the message of a failure.
  std::string Do(KeptFolder& folder)
  {
    std::string done;
    for (std::size_t i = 0, times = 1 + this->Below(3); i < times && !folder.empty(); ++i)
    {
      done += this->DoOne(folder) + "; ";
    }
    return done;
  }

private:
  std::size_t Below(std::size_t end)
  {
    return std::uniform_int_distribution<std::size_t>(0, end - 1)(this->Random);
  }
  KeptFolder::iterator Any(KeptFolder& folder)
  {
    const auto journal = folder.find("journal");
    return journal != folder.end() && this->Below(6) == 0
             ? journal
             : std::next(folder.begin(), static_cast<std::ptrdiff_t>(this->Below(folder.size())));
  }

  std::string DoOne(KeptFolder& folder)
  {
    const auto it = this->Any(folder);
    const std::string name = it->first;
    std::string& bytes = it->second.bytes;
    const std::size_t size = bytes.size(), at = size == 0 ? 0 : this->Below(size);
    const std::size_t some = std::min(size - at, std::size_t{ 1 } << this->Below(16));
    const bool isSeen = this->Below(8) == 0; // the time of the change shows it
    it->second.changed.tv_nsec += isSeen ? 1 : 0;
    switch (size == 0 ? 6 : this->Below(9))
    {
      case 0:
      case 1:
        bytes[at] = static_cast<char>(bytes[at] ^ (1 << this->Below(8)));
        return "a bit of " + name + " at " + std::to_string(at);
      case 2:
        std::fill_n(bytes.begin() + static_cast<std::ptrdiff_t>(at), some, '\0');
        return std::to_string(some) + " zeros in " + name + " at " + std::to_string(at);
      case 3:
        for (std::size_t i = at; i < at + some; ++i)
        {
          bytes[i] = static_cast<char>(this->Below(256));
        }
        return "a block of " + name + " at " + std::to_string(at);
      case 4:
        bytes.resize(at);
        return name + " is cut off at " + std::to_string(at);
      case 5:
        bytes.append(1 + this->Below(100'000), static_cast<char>(this->Below(256)));
        return name + " is longer";
      case 6:
        folder.erase(it);
        return name + " is gone";
      case 7:
      {
        const auto other = this->Any(folder);
        std::swap(bytes, other->second.bytes);
        return name + " and " + other->first + " are swapped";
      }
      default:
      {
        // A block from elsewhere in the same file, as if a write had gone to a wrong place.
        const std::size_t from = this->Below(size);
        const std::string moved = bytes.substr(from, std::min(some, size - from));
        bytes.replace(at, std::min(moved.size(), size - at), moved, 0, size - at);
        return "a block of " + name + " from " + std::to_string(from) + " at " + std::to_string(at);
      }
    }
  }

  std::mt19937 Random;
};

class DamagedBuild : public ExternalBuilderTest
{
protected:
  // Runs a build with --resume in a process of its own. Returns its exit code, or -1 if a signal
  // ended it.
  int Resume()
  {
    const pid_t child = ::fork();
    if (child == 0)
    {
      ::_exit(this->External() ? 0 : 1);
    }
    int state = 0;
    ::waitpid(child, &state, 0);
    return WIFEXITED(state) ? WEXITSTATUS(state) : -1;
  }
};

}

// KDSTREAM_DAMAGED_BUILDS: the number of damaged builds, for longer runs.
TEST_F(DamagedBuild, IsTheSameStoreOrAnError)
{
  const char* const asked = std::getenv("KDSTREAM_DAMAGED_BUILDS");
  const int count = asked ? std::atoi(asked) : 30;
  this->Write(Shuffled(Torus(96, 48), 2));
  std::vector<std::size_t> publishing;
  this->CountSteps(publishing);
  const std::string expected = this->Take();
  std::vector<KeptFolder> lefts; // copies of the folder after each phase
  for (const std::size_t k : publishing)
  {
    ASSERT_TRUE(this->BuildAndKill(k + 2));
    lefts.push_back(Keep(this->Left()));
  }
  this->Options.resume = true;
  int same = 0, errors = 0, others = 0, signals = 0;
  for (int i = 0; i < count; ++i)
  {
    const auto seed = static_cast<unsigned>(i);
    KeptFolder folder = lefts[seed * 7 % lefts.size()];
    const std::string done = Damage(seed).Do(folder);
    PutBack(folder, this->Left());
    const int ended = this->Resume();
    const std::string store = this->Take();
    same += ended == 0 && store == expected;
    errors += ended == 1 && store.empty();
    others += ended >= 0 && !store.empty() && store != expected;
    signals += ended < 0;
    EXPECT_TRUE(ended == 0 ? store == expected : ended == 1 && store.empty())
      << "case " << i << ": " << done << " ended with " << ended;
  }
  fs::remove_all(this->Left());
  std::cout << count << " damaged folders: " << same << " times the same store, " << errors
            << " errors, " << others << " other stores, " << signals << " signals\n";
  EXPECT_EQ(same + errors, count);
}

// Damages one file at a time, keeping its size and time. The damage must be found, and the work
// repeated from the phase that made the file.
TEST_F(DamagedBuild, ABitOfAnyFileIsFound)
{
  this->Write(Shuffled(Torus(96, 48), 2));
  std::vector<std::size_t> publishing;
  this->CountSteps(publishing);
  const std::string expected = this->Take();
  ASSERT_TRUE(this->BuildAndKill(publishing.back() + 2)); // all phases are finished
  const KeptFolder left = Keep(this->Left());
  this->Options.resume = true;
  PutBack(left, this->Left());
  auto report = this->External();
  ASSERT_TRUE(report);
  ASSERT_EQ(report->resumedPhases, 5U) << "nothing is wrong";
  EXPECT_TRUE(this->Take() == expected);
  std::string reported;
  this->Options.tellEarlierBuild = [&](const std::string& found) { reported = found; };
  for (const auto& [name, file] : left)
  {
    if (file.bytes.empty() || name == "journal")
    {
      continue;
    }
    SCOPED_TRACE(name);
    KeptFolder damaged = left;
    char& byte = damaged[name].bytes[file.bytes.size() / 3];
    byte = static_cast<char>(byte ^ 1);
    PutBack(damaged, this->Left());
    report = this->External();
    ASSERT_TRUE(report) << report.GetError().message;
    EXPECT_LT(report->resumedPhases, 5U);
    EXPECT_NE(reported.find("missing or changed"), std::string::npos) << reported;
    EXPECT_TRUE(this->Take() == expected);
  }
  this->ExpectNothingLeft();
}

TEST_F(DamagedBuild, WhateverHasAFilesNameIsNotTakenForIt)
{
  this->Write(Shuffled(Torus(96, 48), 2));
  std::vector<std::size_t> publishing;
  this->CountSteps(publishing);
  const std::string expected = this->Take();
  ASSERT_TRUE(this->BuildAndKill(publishing.back() + 2)); // all phases are finished
  const KeptFolder left = Keep(this->Left());
  const fs::path victim = this->Folder / "victim";
  const std::pair<const char*, std::function<void(const fs::path&)>> kinds[] = {
    { "a folder", [](const fs::path& file) { fs::create_directories(file / "in/it"); } },
    { "a pipe", [](const fs::path& file) { ::mkfifo(file.c_str(), 0600); } },
    { "an endless device", [](const fs::path& file) { fs::create_symlink("/dev/zero", file); } },
    { "a link to itself", [](const fs::path& file) { fs::create_symlink(file, file); } },
    { "a link", [&](const fs::path& file) { fs::create_symlink(victim, file); } },
    { "an endless file",
      [](const fs::path& file)
      {
        std::ofstream(file, std::ios::binary) << "";
        fs::resize_file(file, std::uintmax_t{ 1 } << 42);
      } },
  };
  this->Options.resume = true;
  for (const std::string& name : { std::string("journal"), left.begin()->first })
  {
    for (const auto& [kind, make] : kinds)
    {
      SCOPED_TRACE(name + ": " + kind);
      std::ofstream(victim, std::ios::binary) << left.at(name).bytes;
      PutBack(left, this->Left());
      fs::remove(this->Left() / name);
      make(this->Left() / name);
      ASSERT_EQ(this->Resume(), 0);
      EXPECT_TRUE(this->Take() == expected);
      EXPECT_EQ(ReadWhole(victim), left.at(name).bytes);
      fs::remove(victim);
      this->ExpectNothingLeft();
    }
  }
}
