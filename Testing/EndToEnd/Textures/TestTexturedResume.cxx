// SPDX-License-Identifier: BSD-3-Clause
// A killed build of a textured mesh is resumed only if pictures and material libraries have not
// changed; it makes the same store as a build in memory.
#include "Testing/EndToEnd/ProgramsTest.h"
#include "filters/model/JsonReader.h"
#include "filters/texture/WritePicture.h"

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <thread>

#include <fcntl.h>
#include <sys/file.h>

using namespace kdstream;
using namespace kdstream::fixtures;
namespace fs = std::filesystem;

namespace
{

class TestTexturedResume : public ProgramsTest
{
protected:
  void SetUp() override
  {
    fs::create_directory(this->Folder / "spill");
    this->WritePng(255);
    this->WriteText("m.mtl", "newmtl a\nmap_Kd a.png\n");
    constexpr int side = 220; // too many vertices for 64M: built out of core
    std::string text = "mtllib m.mtl\nusemtl a\n";
    char line[200];
    for (int i = 0; i < side * side; ++i)
    {
      const int x = i % side, y = i / side;
      std::snprintf(line, sizeof line, "v %d %d %d\nvt %g %g\n", x, y, x % 20 < 3 ? x * y % 7 : 0,
        x / double(side), y / double(side));
      text += line;
    }
    for (int i = 0; i < side * (side - 1); ++i)
    {
      const int a = i + 1, b = a + 1, c = b + side, d = a + side;
      std::snprintf(line, sizeof line, "f %d/%d %d/%d %d/%d %d/%d\n", a, a, b, b, c, c, d, d);
      text += i % side == side - 1 ? "" : line;
    }
    this->WriteText("m.obj", text);
  }

  void WritePng(std::uint8_t red)
  {
    const auto png = EncodePicture({ 2, 1, 3, { red, 0, 0, 0, 0, 255 } }, PictureType::Png);
    this->WriteText("a.png", { png.begin(), png.end() });
  }

  Outcome Resume()
  {
    return this->Build(
      { "m.obj", "-o", "m.kds", "--temp-dir", "spill", "--quiet", "--resume", "--memory", "64M" });
  }

  // Kills a build after its first phase. Fails if all builds are too quick.
  void KillBuild()
  {
    bool killed = false;
    for (int i = 0; i < 20 && !killed; ++i)
    {
      fs::remove(this->Folder / "m.kds");
      killed = this->KillBetweenPhases();
    }
    ASSERT_TRUE(killed) << "no build was killed between its phases";
    fs::remove(this->Folder / "m.kds");
  }

  // Builds; returns the store's digest, and the most bytes of temporary files.
  std::pair<std::string, std::uint64_t> BuildWith(std::vector<std::string> more)
  {
    more.insert(more.begin(),
      { "m.obj", "-o", "m.kds", "--temp-dir", "spill", "--quiet", "--stats", "s.json" });
    const Outcome built = this->Build(more);
    EXPECT_EQ(built.exitCode, 0) << built.err;
    const auto stats = ParseJson(ReadWhole(this->Folder / "s.json"));
    EXPECT_TRUE(stats);
    return { std::string((*stats)["digest"].GetString()), (*stats)["temp_bytes"].GetUint64() };
  }

private:
  bool HasJournal() const
  {
    for (const fs::directory_entry& entry : fs::directory_iterator(this->Folder / "spill"))
    {
      if (fs::exists(entry.path() / "journal"))
      {
        return true;
      }
    }
    return false;
  }

  // Kills a build when its first phase is finished. Returns false if the build was too quick.
  bool KillBetweenPhases()
  {
    const pid_t child = ::fork();
    if (child == 0)
    {
      std::vector<std::string> words{ std::string(KDSTREAM_PROGRAMS) + "/kdstream-build", "m.obj",
        "-o", "m.kds", "--temp-dir", "spill", "--quiet", "--memory", "64M" };
      std::vector<char*> arguments;
      for (std::string& word : words)
      {
        arguments.push_back(word.data());
      }
      arguments.push_back(nullptr);
      if (::chdir(this->Folder.Path.c_str()) == 0 && std::freopen("/dev/null", "w", stderr))
      {
        ::execv(arguments[0], arguments.data());
      }
      ::_exit(127);
    }
    int status = 0;
    while (::waitpid(child, &status, WNOHANG) == 0)
    {
      if (this->HasJournal())
      {
        ::kill(child, SIGKILL);
        ::waitpid(child, &status, 0);
        break;
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return WIFSIGNALED(status);
  }

protected:
  void ExpectRefused(const std::string& file)
  {
    const Outcome outcome = this->Resume();
    EXPECT_EQ(outcome.exitCode, 2);
    EXPECT_NE(outcome.err.find("--resume: the interrupted build had another file " +
                               fs::canonical(this->Folder.Path).string() + "/" + file +
                               " (used by its input), or that file has changed since; its files "
                               "are kept: build without --resume to start over\n"),
      std::string::npos)
      << outcome.err;
    EXPECT_FALSE(fs::exists(this->Folder / "m.kds"));
  }
};

}

TEST_F(TestTexturedResume, AnotherPictureOrLibraryIsRefusedByName)
{
  ASSERT_NO_FATAL_FAILURE(this->KillBuild());
  for (const std::string file : { "a.png", "m.mtl" })
  {
    const auto time = fs::last_write_time(this->Folder / file);
    fs::last_write_time(this->Folder / file, time + std::chrono::seconds(1));
    this->ExpectRefused(file);
    fs::rename(this->Folder / file, this->Folder / "away");
    if (file == "a.png") // without its library there is no picture to convert
    {
      this->ExpectRefused(file);
    }
    fs::rename(this->Folder / "away", this->Folder / file);
    fs::last_write_time(this->Folder / file, time);
  }
  const Outcome resumed = this->Resume();
  EXPECT_EQ(resumed.exitCode, 0) << resumed.err;
  EXPECT_EQ(this->Store({ "verify", "m.kds" }).exitCode, 0);
}

// 48,400 vertices: out of core at 64M, in memory at 1G.
TEST_F(TestTexturedResume, OutOfCoreOrResumedTheStoreIsThatOfMemory)
{
  Picture picture{ 512, 512, 3, {} };
  for (std::size_t i = 0; i < 3 * picture.width * picture.height; ++i)
  {
    picture.texels.push_back(static_cast<std::uint8_t>((i * 7919 >> 3) ^ (i >> 11)));
  }
  const auto png = EncodePicture(picture, PictureType::Png);
  this->WriteText("a.png", { png.begin(), png.end() });
  const auto [inMemory, none] = this->BuildWith({ "--memory", "1G" });
  EXPECT_EQ(none, 0U);
  const auto [digest, written] = this->BuildWith({ "--memory", "64M", "--threads", "3" });
  EXPECT_EQ(digest, inMemory);
  EXPECT_GT(written, 10'000'000U);
  EXPECT_EQ(this->BuildWith({ "--memory", "100M", "--threads", "1" }).first, inMemory);
  ASSERT_NO_FATAL_FAILURE(this->KillBuild());
  const auto [resumed, spilled] = this->BuildWith({ "--memory", "64M", "--resume" });
  EXPECT_EQ(resumed, inMemory);
  EXPECT_GT(spilled, 0U);
  const auto stats = ParseJson(ReadWhole(this->Folder / "s.json"));
  EXPECT_GT((*stats)["resumed_phases"].GetUint64(), 0U);
  EXPECT_GT((*stats)["tiles"]["texels"].GetUint64(), picture.width * picture.height);
}

// Decoded pictures may take gigabytes.
TEST_F(TestTexturedResume, WhatAKilledConversionHasLeftIsRemoved)
{
  const std::string begin = ".kdstream-files-0123456789abcdef-7-";
  const auto leave = [&](const std::string& name)
  {
    const fs::path folder = this->Folder / (begin + name);
    fs::create_directory(folder);
    std::ofstream(folder / "input.ply") << "ply";
    return folder;
  };
  const fs::path killed = leave("killed"), busy = leave("atwork");
  const int lock = ::open(busy.c_str(), O_RDONLY | O_DIRECTORY);
  ASSERT_EQ(::flock(lock, LOCK_EX | LOCK_NB), 0);
  this->WriteText("m.obj", "mtllib m.mtl\nusemtl a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\n"
                           "f 1/1 2/1 3/1\n");
  const Outcome built = this->Build({ "m.obj", "-o", "m.kds", "--quiet" });
  EXPECT_EQ(built.exitCode, 0) << built.err;
  EXPECT_FALSE(fs::exists(killed));
  EXPECT_TRUE(fs::exists(busy / "input.ply"));
  ::close(lock);
  EXPECT_EQ(this->Files(),
    (std::set<std::string>{ begin + "atwork", "a.png", "m.kds", "m.mtl", "m.obj", "spill" }));
  // A build that converts nothing removes these files, too.
  this->WriteText("m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  EXPECT_EQ(this->Build({ "m.obj", "-o", "m.kds", "--quiet" }).exitCode, 0);
  EXPECT_FALSE(fs::exists(busy));
}

TEST_F(TestTexturedResume, AResumedBuildRemovesWhatTheKilledOneHasLeft)
{
  ASSERT_NO_FATAL_FAILURE(this->KillBuild());
  const auto left = [&]()
  {
    const std::set<std::string> files = this->Files();
    return std::count_if(files.begin(), files.end(),
      [](const std::string& name) { return name.starts_with(".kdstream"); });
  };
  EXPECT_GT(left(), 0);
  const Outcome resumed = this->Resume();
  EXPECT_EQ(resumed.exitCode, 0) << resumed.err;
  EXPECT_EQ(left(), 0);
}
