// SPDX-License-Identifier: BSD-3-Clause
// Out-of-core builds that were killed: --resume continues with valid results, and gives the same
// store, byte for byte.
#include "Testing/Fixtures/ErrorAt.h"
#include "Testing/Fixtures/Meshes.h"
#include "filters/baselines/stores/Baselines.h"
#include "filters/build/Testing/ExternalBuilderTest.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <functional>

using namespace kdstream;
using namespace kdstream::fixtures;
namespace fs = std::filesystem;

namespace
{

class ResumedBuild : public ExternalBuilderTest
{
};

}

TEST_F(ResumedBuild, KilledAnywhereItLeavesNoStoreAndGoesOn)
{
  this->Write(Shuffled(Torus(96, 48), 2));
  const std::string expected = this->InMemory();
  std::vector<std::size_t> points;
  const std::size_t steps = this->CountSteps(points);
  ASSERT_TRUE(this->Take() == expected);
  ASSERT_EQ(points.size(), 5U) << "a phase each";
  for (const std::size_t rename : std::vector<std::size_t>(points))
  {
    points.push_back(rename + 1); // its fsync
    points.push_back(rename + 2);
  }
  constexpr std::size_t spread = 40;
  for (std::size_t i = 0; i < spread; ++i)
  {
    points.push_back(i * steps / spread);
  }
  std::sort(points.begin(), points.end());
  std::uint64_t before = 0, most = 0;
  for (const std::size_t k : points)
  {
    SCOPED_TRACE("killed before step " + std::to_string(k) + " of " + std::to_string(steps));
    this->Options.resume = false;
    if (!this->BuildAndKill(k))
    {
      // Its last steps may run in other threads or in the system.
      EXPECT_GT(k, steps * 9 / 10);
      this->Take();
      continue;
    }
    // Once everything is written, only temporary files are left to be removed.
    const bool whole = fs::exists(this->Store());
    if (whole)
    {
      EXPECT_GT(k, steps * 9 / 10);
      EXPECT_TRUE(this->Take() == expected);
    }
    this->Options.resume = k % 5 != 0;
    const auto report = this->External();
    ASSERT_TRUE(report) << report.GetError().message;
    EXPECT_TRUE(this->Take() == expected);
    this->ExpectNothingLeft();
    if (!this->Options.resume)
    {
      EXPECT_EQ(report->resumedPhases, 0U);
    }
    else if (!whole)
    {
      EXPECT_GE(report->resumedPhases, before);
      before = report->resumedPhases;
      most = std::max(most, before);
    }
    EXPECT_EQ(report->seconds.size(), 7U);
  }
  EXPECT_EQ(most, 5U);
}

TEST_F(ResumedBuild, WhatDoesNotFitIsNotTakenUp)
{
  this->Write(Shuffled(Torus(96, 48), 2));
  std::vector<std::size_t> publishing;
  this->CountSteps(publishing);
  const std::string expected = this->Take();
  const std::size_t last = publishing.back() + 2; // all phases are finished
  const fs::path journal = this->Left() / "journal";
  const auto someFile = [&]()
  {
    for (const fs::directory_entry& entry : fs::directory_iterator(this->Left()))
    {
      if (entry.path() != journal && entry.file_size() > 1000)
      {
        return entry.path();
      }
    }
    return fs::path{};
  };
  const auto flip = [](const fs::path& file, std::size_t at)
  {
    std::string bytes = ReadWhole(file);
    bytes[at] = static_cast<char>(bytes[at] ^ 1);
    std::ofstream(file, std::ios::binary) << bytes;
  };
  struct Case
  {
    const char* name;
    std::function<void()> damage;
    std::uint64_t most; // maximum number of phases that may be resumed
  };
  const Case cases[] = {
    { "nothing is wrong", [] {}, 5 },
    { "a bit of the journal", [&] { flip(journal, 60); }, 0 },
    { "the journal's end", [&] { fs::resize_file(journal, fs::file_size(journal) - 1); }, 0 },
    { "no journal", [&] { fs::remove(journal); }, 0 },
    { "a short file",
      [&]
      {
        const fs::path file = someFile();
        fs::resize_file(file, fs::file_size(file) - 1);
      },
      4 },
    { "a file is gone", [&] { fs::remove(someFile()); }, 4 },
    { "a link in place of a file",
      [&]
      {
        const fs::path file = someFile();
        fs::rename(file, this->Folder / "moved");
        fs::create_symlink(this->Folder / "moved", file);
      },
      4 },
    { "foreign files",
      [&]
      {
        std::ofstream(this->Left() / "4711") << "no file of any phase";
        std::ofstream(this->Left() / "notes") << "neither";
        fs::create_directory(this->Left() / "folder");
      },
      5 },
    { "a file of the same size", [&] { flip(someFile(), 500); }, 4 },
  };
  for (const Case& it : cases)
  {
    SCOPED_TRACE(it.name);
    this->Options.resume = false;
    ASSERT_TRUE(this->BuildAndKill(last));
    it.damage();
    this->Options.resume = true;
    const auto report = this->External();
    ASSERT_TRUE(report) << report.GetError().message;
    EXPECT_LE(report->resumedPhases, it.most);
    EXPECT_EQ(report->resumedPhases == 5, it.most == 5);
    EXPECT_TRUE(this->Take() == expected);
    fs::remove(this->Folder / "moved");
    this->ExpectNothingLeft();
  }
}

// The refused attempt must not lose finished work.
TEST_F(ResumedBuild, ABuildOfOtherOptionsOrAnotherInputIsNotResumed)
{
  this->Write(Shuffled(Torus(96, 48), 2));
  std::vector<std::size_t> publishing;
  this->CountSteps(publishing);
  const std::string expected = this->Take();
  ASSERT_TRUE(this->BuildAndKill(publishing.back() + 2)); // all phases are finished
  this->Options.resume = true;
  const BuildOptions same = this->Options;
  const auto refused = [&](const BuildOptions& options)
  {
    // As the program does it; with enough memory for everything.
    const auto report = BuildStore(this->Input(), this->Store(), options);
    EXPECT_FALSE(report);
    EXPECT_FALSE(fs::exists(this->Store()));
    return report ? Error{} : report.GetError();
  };
  BuildOptions other = same;
  other.title = "other";
  other.bits = 0;
  EXPECT_EQ(refused(other).code, ErrorCode::InvalidArgument);
  EXPECT_NE(refused(other).message.find("--precision 20 (now lossless), --title none (now other);"),
    std::string::npos)
    << refused(other).message;
  other = same;
  other.tree.partitions = 32;
  other.weld = false;
  EXPECT_NE(refused(other).message.find("--partitions none (now 32), --weld on (now off);"),
    std::string::npos)
    << refused(other).message;
  other = same;
  other.partitioner = &KMeansMethod(); // only in memory
  EXPECT_NE(refused(other).message.find("--resume: k-means partitions"), std::string::npos);
  other = same;
  other.memory = leastMemory - 1;
  EXPECT_TRUE(fixtures::Mentions(refused(other).message, { "--resume: ", "64 MiB" }));
  const auto time = fs::last_write_time(this->Input());
  fs::last_write_time(this->Input(), time + std::chrono::seconds(1));
  EXPECT_EQ(refused(same).code, ErrorCode::InvalidArgument);
  fs::last_write_time(this->Input(), time);
  const auto report = BuildStore(this->Input(), this->Store(), same);
  ASSERT_TRUE(report) << report.GetError().message;
  EXPECT_EQ(report->resumedPhases, 5U);
  EXPECT_TRUE(this->Take() == expected);
  this->ExpectNothingLeft();
}

TEST_F(ResumedBuild, WhatIsLeftIsReportedInTheWordsOfTheProgress)
{
  this->Write(Shuffled(Torus(96, 48), 2));
  for (const PartitionMethod* const partitioner : { &KdTreeMethod(), &OctreeMethod() })
  {
    this->Options.partitioner = partitioner;
    this->Options.resume = false;
    std::vector<std::size_t> publishing;
    this->CountSteps(publishing);
    const std::string expected = this->Take();
    for (const std::size_t published : publishing)
    {
      std::string reported;
      this->Options.resume = false;
      this->Options.tellEarlierBuild = [&](const std::string& found) { reported += found; };
      ASSERT_TRUE(this->BuildAndKill(published + 2));
      // A build without --resume mentions it once, and ends as usual.
      ASSERT_TRUE(BuildStore(this->Input(), this->Store(), this->Options));
      EXPECT_TRUE(this->Take() == expected);
      const std::string before = "--resume would continue it with the step ";
      ASSERT_NE(reported.find(before), std::string::npos) << reported;
      const std::string rest = reported.substr(reported.find(before) + before.size());
      const std::string step = rest.substr(0, rest.find(';'));
      EXPECT_EQ(rest, step + "; this build starts over");
      reported.clear();
      ASSERT_TRUE(this->BuildAndKill(published + 2));
      this->Options.resume = true;
      std::string first;
      Execution resumed;
      resumed.progress = [&](std::string_view name, double)
      {
        first = first.empty() ? std::string(name) : first;
        return true;
      };
      ASSERT_TRUE(this->External(resumed));
      EXPECT_TRUE(this->Take() == expected);
      EXPECT_EQ(reported, "continuing with the step " + step);
      EXPECT_EQ(first, step);
    }
  }
  this->ExpectNothingLeft();
  // Nothing is mentioned if no files are left.
  std::string reported;
  this->Options.resume = false;
  this->Options.tellEarlierBuild = [&](const std::string& found) { reported += found; };
  ASSERT_TRUE(BuildStore(this->Input(), this->Store(), this->Options));
  std::vector<std::size_t> publishing;
  this->CountSteps(publishing);
  EXPECT_EQ(reported, "");
}

// The files may be hours of work. So a build that removes them, maybe because of a wrong option,
// must say so.
TEST_F(ResumedBuild, WhatAnotherBuildHasLeftIsRemovedWithAWord)
{
  this->Write(Shuffled(Torus(96, 48), 2));
  std::vector<std::size_t> publishing;
  this->CountSteps(publishing);
  std::string reported;
  this->Options.tellEarlierBuild = [&](const std::string& found) { reported += found; };
  const std::string left =
    "there are files of a killed build of this store, which this build removes: ";
  ASSERT_TRUE(this->BuildAndKill(publishing.back() + 2));
  this->Options.title = "other";
  ASSERT_TRUE(BuildStore(this->Input(), this->Store(), this->Options));
  EXPECT_EQ(reported, left + "to continue it with --resume, --title none (now other) is needed");
  this->Options.title = "";

  ASSERT_TRUE(this->BuildAndKill(publishing.back() + 2));
  reported.clear();
  const fs::path moved = this->Folder / "moved.ply";
  fs::copy_file(this->Input(), moved);
  ASSERT_TRUE(BuildStore(moved, this->Store(), this->Options));
  EXPECT_EQ(reported, left + "to continue it with --resume, their input " +
                        fs::canonical(this->Input()).string() + " is needed");

  ASSERT_TRUE(this->BuildAndKill(publishing.back() + 2));
  reported.clear();
  fs::last_write_time(this->Input(), fs::last_write_time(this->Input()) + std::chrono::seconds(1));
  ASSERT_TRUE(BuildStore(this->Input(), this->Store(), this->Options));
  EXPECT_EQ(reported, left + "their input has changed since, so --resume cannot use them");
  fs::remove(moved);
  this->Take();
  this->ExpectNothingLeft();
}

TEST_F(ResumedBuild, AConvertedInputIsKnownByWhatItWasMadeFrom)
{
  const fs::path from = this->Folder / "scan.vtp", picture = this->Folder / "scan.png";
  std::ofstream(from) << "anything";
  std::ofstream(picture) << "a picture";
  const Mesh mesh = Shuffled(Torus(96, 48), 2);
  this->Write(mesh);
  this->Options.convertedFrom = from;
  this->Options.convertedWith = { picture };
  std::vector<std::size_t> publishing;
  this->CountSteps(publishing);
  const std::string expected = this->Take();
  ASSERT_TRUE(this->BuildAndKill(publishing.back() + 2)); // all phases are finished
  this->Options.resume = true;
  this->Options.convertedBy = "--reconstruct poisson";
  EXPECT_NE(this->External().GetError().message.find(
              "kdstream-convert none (now \"--reconstruct poisson\")"),
    std::string::npos);
  this->Options.convertedBy = "";
  const auto time = fs::last_write_time(from);
  std::ofstream(from) << "something else";
  EXPECT_EQ(this->External().GetError().code, ErrorCode::InvalidArgument);
  std::ofstream(from) << "anything";
  fs::last_write_time(from, time);
  const auto timeOfPicture = fs::last_write_time(picture);
  std::ofstream(picture) << "another picture";
  EXPECT_NE(this->External().GetError().message.find(picture.string()), std::string::npos);
  std::ofstream(picture) << "a picture";
  fs::last_write_time(picture, timeOfPicture);
  fs::remove(this->Input());
  this->Write(mesh); // as a new conversion does: the time of change differs
  const auto report = this->External();
  ASSERT_TRUE(report) << report.GetError().message;
  EXPECT_EQ(report->resumedPhases, 5U);
  EXPECT_TRUE(this->Take() == expected);
  this->ExpectNothingLeft({ "in.ply", "scan.png", "scan.vtp", "spill" });
}

TEST_F(ResumedBuild, GoesOnWithMoreMemoryAndSaysThatItHasTooLittle)
{
  this->Write(Shuffled(DisplacedSphere(5), 5));
  std::vector<std::size_t> publishing;
  this->CountSteps(publishing);
  const std::string expected = this->Take();
  for (const std::uint64_t memory : { 8 * smallMemory, smallMemory / 16 })
  {
    SCOPED_TRACE(memory);
    this->Options.resume = false;
    this->Probe.stepMemory = smallMemory;
    ASSERT_TRUE(this->BuildAndKill(publishing[2] + 2)); // mesh, tree and faces are finished
    this->Options.resume = true;
    this->Probe.stepMemory = memory;
    auto report = this->External();
    if (memory < smallMemory)
    {
      ASSERT_FALSE(report);
      EXPECT_EQ(report.GetError().code, ErrorCode::LimitExceeded);
      EXPECT_NE(report.GetError().message.find("had more memory than this one"), std::string::npos);
      this->Probe.stepMemory = smallMemory;
      report = this->External(); // the finished phases are still there
    }
    ASSERT_TRUE(report) << report.GetError().message;
    EXPECT_EQ(report->resumedPhases, 3U);
    EXPECT_TRUE(this->Take() == expected);
    this->ExpectNothingLeft();
  }
}

TEST_F(ResumedBuild, ResumeGoesOutOfCoreAtOnceAndABuildInMemoryClearsAway)
{
  this->Write(Torus(96, 48));
  std::vector<std::size_t> publishing;
  this->CountSteps(publishing);
  const std::string expected = this->Take();
  ASSERT_TRUE(this->BuildAndKill(publishing[2] + 2));
  ASSERT_TRUE(fs::exists(this->Left()));
  this->Options.resume = true;
  const auto resumed = BuildStore(this->Input(), this->Store(), this->Options);
  ASSERT_TRUE(resumed) << resumed.GetError().message;
  EXPECT_EQ(resumed->resumedPhases, 3U);
  EXPECT_TRUE(this->Take() == expected);
  this->ExpectNothingLeft();

  this->Options.resume = false;
  ASSERT_TRUE(this->BuildAndKill(publishing[2] + 2));
  const auto inMemory = BuildStore(this->Input(), this->Store(), this->Options);
  ASSERT_TRUE(inMemory) << inMemory.GetError().message;
  EXPECT_EQ(inMemory->temporaryBytes, 0U);
  EXPECT_TRUE(this->Take() == expected);
  this->ExpectNothingLeft();
}
