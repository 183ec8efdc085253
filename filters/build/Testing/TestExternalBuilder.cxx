// SPDX-License-Identifier: BSD-3-Clause
// Stores that are built out of core: the same to the byte as in memory, whatever the limit, the
// threads and the median method, and however often the build was killed.
#include "Testing/Fixtures/Attributes.h"
#include "Testing/Fixtures/Meshes.h"
#include "filters/build/ExternalBuilder.h"
#include "filters/build/Testing/KilledBuild.h"
#include "filters/meshio/MeshWriter.h"
#include "filters/outofcore/journal/BuildFolder.h"
#include "filters/program/TbbExecution.h"

#include <gtest/gtest.h>

#include <cstring>
#include <fstream>
#include <iterator>
#include <optional>
#include <set>

#include <sys/mount.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

using namespace kdstream;
using namespace kdstream::fixtures;
namespace fs = std::filesystem;

namespace
{

constexpr std::uint64_t KiB = 1024;
constexpr std::uint64_t smallMemory = 512 * KiB; // many blocks, and a tree out of core

std::string BytesOf(const fs::path& file)
{
  std::ifstream stream(file, std::ios::binary);
  return { std::istreambuf_iterator<char>(stream), {} };
}

class ExternalBuilderTest : public ::testing::Test
{
protected:
  ExternalBuilderTest()
  {
    // In memory where the system can: every build waits for the disk some fifty times.
    const fs::path parent =
      ::access("/dev/shm", W_OK) == 0 ? fs::path("/dev/shm") : fs::temp_directory_path();
    std::string name = (parent / "kdstream-external-XXXXXX").string();

    this->Folder = ::mkdtemp(name.data());
    fs::create_directory(this->Spill());
    this->Options.memory = leastMemory;
    this->Options.temporaryFolder = this->Spill();
    this->Options.tree.verticesPerPartition = 200;
    this->Probe.stepMemory = smallMemory;
  }
  ~ExternalBuilderTest() override { fs::remove_all(this->Folder); }

  fs::path Spill() const { return this->Folder / "spill"; }
  fs::path Input() const { return this->Folder / "in.ply"; }
  fs::path Store() const { return this->Folder / "m.kds"; }

  void Write(const Mesh& mesh)
  {
    const Status status = WriteMesh(this->Input(), mesh);
    ASSERT_TRUE(status) << status.GetError().message;
  }
  // The store's bytes as a build in memory makes them.
  std::string InMemory(const Execution& execution = {})
  {
    BuildOptions options = this->Options;
    options.memory = 0;
    const auto report = BuildStore(this->Input(), this->Folder / "memory.kds", options, execution);
    EXPECT_TRUE(report) << report.GetError().message;
    const std::string bytes = BytesOf(this->Folder / "memory.kds");
    fs::remove(this->Folder / "memory.kds");
    return bytes;
  }
  Result<BuildReport> External(const Execution& execution = {})
  {
    return BuildStoreExternally(
      this->Input(), this->Store(), this->Options, execution, this->Probe);
  }
  // Removes the store; its bytes.
  std::string Take()
  {
    const std::string bytes = BytesOf(this->Store());
    fs::remove(this->Store());
    return bytes;
  }
  void ExpectNothingLeft(const std::set<std::string>& but = { "in.ply", "spill" })
  {
    EXPECT_TRUE(fs::is_empty(this->Spill()));
    std::set<std::string> names;
    for (const fs::directory_entry& entry : fs::directory_iterator(this->Folder))
    {
      names.insert(entry.path().filename().string());
    }
    EXPECT_EQ(names, but);
  }

  // A build in a process of its own that is killed before the k-th of its steps: operations on
  // files, and reports of progress. Whether it was.
  bool BuildAndKill(std::size_t k)
  {
    return BuildAndKillAt(
      k, this->Probe, [&](const Execution& execution) { return this->External(execution); });
  }
  // How many such steps a whole build has, and the numbers of those that publish: a sync or a
  // rename is next to them.
  std::size_t CountSteps(std::vector<std::size_t>& publishing)
  {
    std::size_t steps = 0;
    this->Probe.hook = [&](FileOperation operation)
    {
      if (operation == FileOperation::Rename)
      {
        publishing.push_back(steps);
      }
      ++steps;
    };
    Execution execution;
    execution.progress = [&](std::string_view, double)
    {
      ++steps;
      return true;
    };
    const auto report = this->External(execution);
    EXPECT_TRUE(report) << report.GetError().message;
    this->Probe.hook = {};
    return steps;
  }
  // What was left by a build that was killed when its k-th step came.
  fs::path Left() const { return BuildFolder::PathFor(this->Store(), this->Spill()); }

  fs::path Folder;
  BuildOptions Options;
  ExternalBuildProbe Probe;
};

}

TEST_F(ExternalBuilderTest, EveryMeshGivesTheStoreOfTheBuildInMemory)
{
  constexpr MedianMethod methods[] = { MedianMethod::Automatic, MedianMethod::Heaps,
    MedianMethod::Torben, MedianMethod::Sort, MedianMethod::Histogram };
  constexpr unsigned threads[] = { 1, 2, 5 };
  unsigned turn = 0;
  std::vector<NamedMesh> meshes = AllMeshes();
  meshes.push_back({ "equal coordinates", Shuffled(GridPlate(60), 3) });
  for (const NamedMesh& named : meshes)
  {
    const bool small = named.mesh.points.size() < 1000;
    for (const bool attributes :
      small ? std::vector<bool>{ false, true } : std::vector<bool>{ false })
    {
      this->Write(attributes ? WithAttributes(named.mesh, 7) : named.mesh);
      for (const bool weld : { false, true })
      {
        SCOPED_TRACE(named.name + (attributes ? ", attributes" : "") + (weld ? ", welded" : ""));
        this->Options.weld = weld;
        this->Options.bits = (turn / 2) % 2 == 0 ? 20 : 0;
        const std::string expected = this->InMemory();
        {
          this->Probe.stepMemory = (turn % 2 == 0 ? 128 : 512) * KiB;
          this->Options.median = methods[turn % 5];
          const auto report = this->External(MakeTbbExecution(threads[turn % 3]));
          ASSERT_TRUE(report) << report.GetError().message;
          EXPECT_TRUE(this->Take() == expected);
          ++turn;
        }
      }
    }
  }
  this->ExpectNothingLeft();
}

// In memory such a mesh gets other numbers (GatherMesh.h), out of core it does not.
TEST_F(ExternalBuilderTest, AMeshInNoOrderGivesTheSameStoreToo)
{
  Mesh open = DisplacedSphere(6); // with holes: edges of the boundary are sorted by vertices
  std::erase_if(open.triangles, [n = 0](const Triangle&) mutable { return ++n % 13 == 0; });
  const Mesh plain = Shuffled(open, 5);
  Mesh cloud;
  cloud.points = plain.points;
  const NamedMesh meshes[] = { { "plain", plain }, { "attributes", WithAttributes(plain, 3) },
    { "equal coordinates", Shuffled(GridPlate(130), 3) }, { "no faces", cloud } };
  this->Options.tree.verticesPerPartition = 100;
  this->Probe.stepMemory = 4096 * KiB;
  for (const NamedMesh& named : meshes)
  {
    this->Write(named.mesh);
    ASSERT_GE(named.mesh.points.size(), std::size_t{ 2 * 4096 });
    for (const LevelMaker maker : { LevelMaker::Collapse, LevelMaker::Cluster })
    {
      SCOPED_TRACE(named.name + (maker == LevelMaker::Cluster ? ", cluster" : ", collapse"));
      this->Options.levels.maker = maker;
      this->Options.weld = maker == LevelMaker::Cluster;
      const auto report = this->External(MakeTbbExecution(2));
      ASSERT_TRUE(report) << report.GetError().message;
      EXPECT_TRUE(this->Take() == this->InMemory(MakeTbbExecution(3)));
    }
  }
}

TEST_F(ExternalBuilderTest, MemoryThreadsAndMedianChangeNothing)
{
  for (const Mesh& mesh : { Shuffled(GridPlate(130), 3), Shuffled(DisplacedSphere(5), 5) })
  {
    this->Write(mesh);
    const std::string expected = this->InMemory();
    std::set<std::uint64_t> passes;
    for (const MedianMethod median : { MedianMethod::Automatic, MedianMethod::Heaps,
           MedianMethod::Torben, MedianMethod::Sort, MedianMethod::Histogram })
    {
      this->Options.median = median;
      for (const unsigned threads : { 1U, 2U, 5U })
      {
        this->Probe.stepMemory = (threads == 1 ? 32 : threads == 2 ? 64 : 512) * KiB;
        const auto report = this->External(MakeTbbExecution(threads));
        ASSERT_TRUE(report) << report.GetError().message;
        EXPECT_GT(report->temporaryBytes, 0U);
        EXPECT_GT(report->passes, 1U);
        if (threads == 1)
        {
          passes.insert(report->passes);
        }
        EXPECT_TRUE(this->Take() == expected)
          << NameOfMedianMethod(median) << ", " << threads << " threads";
      }
    }
    EXPECT_GT(passes.size(), 2U) << "the methods are not all in use";
  }
}

TEST_F(ExternalBuilderTest, KilledAnywhereItLeavesNoStoreAndGoesOn)
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
      // Its last steps may be in the threads' or the system's hands.
      EXPECT_GT(k, steps * 9 / 10);
      this->Take();
      continue;
    }
    // When all is written, what is left to do is to clear away.
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

TEST_F(ExternalBuilderTest, WhatDoesNotFitIsNotTakenUp)
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
    std::string bytes = BytesOf(file);
    bytes[at] = static_cast<char>(bytes[at] ^ 1);
    std::ofstream(file, std::ios::binary) << bytes;
  };
  struct Case
  {
    const char* name;
    std::function<void()> damage;
    std::uint64_t most; // phases that may be taken up
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

// And nothing of what was done is lost by the attempt.
TEST_F(ExternalBuilderTest, ABuildOfOtherOptionsOrAnotherInputIsNotResumed)
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
    // As the program builds: with enough memory for all.
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
  other.partitioner = Partitioner::KMeans; // in memory alone
  EXPECT_NE(refused(other).message.find("--resume: stores by k-means"), std::string::npos);
  other = same;
  other.memory = leastMemory - 1;
  EXPECT_EQ(refused(other).message,
    "--resume: building out of core takes at least 64 MiB; build without --resume to start over");
  const auto time = fs::last_write_time(this->Input());
  fs::last_write_time(this->Input(), time + std::chrono::seconds(1));
  EXPECT_EQ(refused(same).code, ErrorCode::InvalidInput);
  fs::last_write_time(this->Input(), time);
  const auto report = BuildStore(this->Input(), this->Store(), same);
  ASSERT_TRUE(report) << report.GetError().message;
  EXPECT_EQ(report->resumedPhases, 5U);
  EXPECT_TRUE(this->Take() == expected);
  this->ExpectNothingLeft();
}

TEST_F(ExternalBuilderTest, WhatIsLeftIsToldInTheWordsOfTheProgress)
{
  this->Write(Shuffled(Torus(96, 48), 2));
  for (const Partitioner partitioner : { Partitioner::KdTree, Partitioner::Octree })
  {
    this->Options.partitioner = partitioner;
    this->Options.resume = false;
    std::vector<std::size_t> publishing;
    this->CountSteps(publishing);
    const std::string expected = this->Take();
    for (const std::size_t published : publishing)
    {
      std::string told;
      this->Options.resume = false;
      this->Options.tellEarlierBuild = [&](const std::string& found) { told += found; };
      ASSERT_TRUE(this->BuildAndKill(published + 2));
      // A plain build hints at it, once, and ends all the same.
      ASSERT_TRUE(BuildStore(this->Input(), this->Store(), this->Options));
      EXPECT_TRUE(this->Take() == expected);
      const std::string before = "with --resume it would go on with the step ";
      ASSERT_NE(told.find(before), std::string::npos) << told;
      const std::string rest = told.substr(told.find(before) + before.size());
      const std::string step = rest.substr(0, rest.find(';'));
      EXPECT_EQ(rest, step + "; this build starts over");
      told.clear();
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
      EXPECT_EQ(told, "going on with the step " + step);
      EXPECT_EQ(first, step);
    }
  }
  this->ExpectNothingLeft();
  // Nothing is hinted at where nothing is left, or where --resume would be refused.
  std::string told;
  this->Options.resume = false;
  this->Options.tellEarlierBuild = [&](const std::string& found) { told += found; };
  ASSERT_TRUE(BuildStore(this->Input(), this->Store(), this->Options));
  std::vector<std::size_t> publishing;
  this->CountSteps(publishing);
  ASSERT_TRUE(this->BuildAndKill(publishing.back() + 2));
  this->Options.title = "other";
  ASSERT_TRUE(BuildStore(this->Input(), this->Store(), this->Options));
  EXPECT_EQ(told, "");
}

TEST_F(ExternalBuilderTest, AConvertedInputIsKnownByWhatItWasMadeFrom)
{
  const fs::path from = this->Folder / "scan.vtp";
  std::ofstream(from) << "anything";
  const Mesh mesh = Shuffled(Torus(96, 48), 2);
  this->Write(mesh);
  this->Options.convertedFrom = from;
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
  EXPECT_EQ(this->External().GetError().code, ErrorCode::InvalidInput);
  std::ofstream(from) << "anything";
  fs::last_write_time(from, time);
  fs::remove(this->Input());
  this->Write(mesh); // converted again: another time of change
  const auto report = this->External();
  ASSERT_TRUE(report) << report.GetError().message;
  EXPECT_EQ(report->resumedPhases, 5U);
  EXPECT_TRUE(this->Take() == expected);
  this->ExpectNothingLeft({ "in.ply", "scan.vtp", "spill" });
}

TEST_F(ExternalBuilderTest, GoesOnWithMoreMemoryAndSaysThatItHasTooLittle)
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
      report = this->External(); // what was done is still there
    }
    ASSERT_TRUE(report) << report.GetError().message;
    EXPECT_EQ(report->resumedPhases, 3U);
    EXPECT_TRUE(this->Take() == expected);
    this->ExpectNothingLeft();
  }
}

TEST_F(ExternalBuilderTest, ProgressNeverRunsBackAndACancelLeavesNothing)
{
  this->Write(WithAttributes(Shuffled(Torus(96, 48), 2), 4));
  std::vector<std::string> steps;
  double last = 0;
  std::size_t calls = 0, stopAt = ~std::size_t{ 0 };
  Execution execution;
  execution.progress = [&](std::string_view step, double fraction)
  {
    if (steps.empty() || steps.back() != step)
    {
      steps.emplace_back(step);
      last = 0;
    }
    EXPECT_GE(fraction, last) << step;
    EXPECT_LE(fraction, 1) << step;
    last = fraction;
    return ++calls < stopAt;
  };
  ASSERT_TRUE(this->External(execution));
  EXPECT_EQ(
    steps, (std::vector<std::string>{ "read", "tree", "faces", "levels", "encode", "write" }));
  const std::string digest = this->Take();
  this->Write(Torus(20, 20));
  ASSERT_TRUE(this->External());
  const std::string old = BytesOf(this->Store());
  this->Write(WithAttributes(Shuffled(Torus(96, 48), 2), 4));
  const std::size_t all = calls;
  ASSERT_GT(all, 50U);
  for (stopAt = 1; stopAt <= all; stopAt += all / 20)
  {
    calls = 0;
    steps.clear();
    const auto report = this->External(execution);
    ASSERT_FALSE(report) << stopAt;
    EXPECT_EQ(report.GetError().code, ErrorCode::Cancelled);
    this->ExpectNothingLeft({ "in.ply", "spill", "m.kds" });
    EXPECT_TRUE(BytesOf(this->Store()) == old) << "the old store is gone";
  }
}

TEST_F(ExternalBuilderTest, ResumeGoesOutOfCoreAtOnceAndABuildInMemoryClearsAway)
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

// A fan far from the origin, beside an ordinary surface.
TEST_F(ExternalBuilderTest, AHubThatNoMemoryHoldsIsNamed)
{
  Mesh mesh = Torus(40, 30);
  const auto hub = static_cast<VertexId>(mesh.points.size());
  constexpr VertexId rim = 150000; // 64 MiB hold 139,810
  mesh.points.push_back({ 8, 0.5, -2 });
  for (VertexId i = 1; i <= rim; ++i)
  {
    mesh.points.push_back({ 8 + double(i % 500), double(i / 500), double(0.25F) });
    mesh.triangles.push_back({ hub + i % rim + 1, hub, hub + i });
  }
  this->Write(Shuffled(mesh, 3));
  const auto refused = this->External();
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.GetError().code, ErrorCode::LimitExceeded);
  EXPECT_EQ(refused.GetError().message,
    "the vertex at (8.000000, 0.500000, -2.000000) has 150000 triangles, which must be in memory "
    "together: --memory 69M would do");
  this->ExpectNothingLeft();
  this->Options.memory = std::uint64_t{ 69 } << 20;
  const auto built = this->External();
  ASSERT_TRUE(built) << built.GetError().message;
  EXPECT_EQ(built->info.vertices, mesh.points.size());
}

TEST_F(ExternalBuilderTest, SaysWhatIsWrong)
{
  this->Write(Torus(96, 48));
  const auto message = [&]() -> std::string
  {
    const auto report = this->External();
    EXPECT_FALSE(report);
    EXPECT_FALSE(fs::exists(this->Store()));
    return report ? "" : report.GetError().message;
  };
  {
    const auto other = BuildFolder::Open(this->Left(), "other", false);
    ASSERT_TRUE(other);
    EXPECT_NE(message().find("another build of this store is running"), std::string::npos);
  }
  this->ExpectNothingLeft();
  this->Options.temporaryFolder = this->Folder / "no";
  EXPECT_NE(message().find((this->Folder / "no").string()), std::string::npos);
  this->Options.temporaryFolder = this->Spill();
  this->Write(Mesh{ {}, {}, ScalarType::Float32, {} });
  EXPECT_EQ(message(), "the mesh has no vertices");
  std::ofstream(this->Input()) << "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\n"
                                  "property float y\nproperty float z\nelement face 1\n"
                                  "property list uchar int vertex_indices\nend_header\n"
                                  "0 0 0\n1 0 0\n3 0 1 2\n";
  EXPECT_NE(message().find("face 0: index 2 out of range"), std::string::npos);
  this->Options.partitioner = Partitioner::KMeans;
  EXPECT_NE(message().find("in memory alone"), std::string::npos);
  this->Options.partitioner = Partitioner::KdTree;
  this->Options.memory = leastMemory - 1;
  EXPECT_NE(message().find("at least 64 MiB"), std::string::npos);
  this->ExpectNothingLeft();
}

// In a process of its own, since the limit stays: files of at most so many bytes.
TEST_F(ExternalBuilderTest, AFullDiskIsAnErrorThatSaysWhatWasNeeded)
{
  this->Write(Shuffled(Torus(96, 48), 2));
  const std::size_t whole = fs::file_size(this->Input());
  for (const std::size_t bytes : { whole / 50, whole / 10, whole / 4, whole / 2 })
  {
    SCOPED_TRACE(bytes);
    const fs::path said = this->Folder / "said";
    const pid_t child = ::fork();
    if (child == 0)
    {
      std::ofstream report(said);
      ::signal(SIGXFSZ, SIG_IGN);
      const rlimit limit{ bytes, bytes };
      ::setrlimit(RLIMIT_FSIZE, &limit);
      const auto built = this->External();
      report << (built ? "built" : built.GetError().message) << std::flush;
      ::_exit(built || built.GetError().code != ErrorCode::InputOutput ? 1 : 0);
    }
    int state = 0;
    ::waitpid(child, &state, 0);
    EXPECT_TRUE(WIFEXITED(state) && WEXITSTATUS(state) == 0);
    const std::string text = BytesOf(said);
    EXPECT_NE(text.find("the temporary folder is too small"), std::string::npos) << text;
    EXPECT_NE(text.find(" bytes"), std::string::npos) << text;
    fs::remove(said);
    this->ExpectNothingLeft();
  }
}

// A file system of its own that has no room, for the temporary files and then for the store.
TEST_F(ExternalBuilderTest, ARealDiskThatIsFullIsAnErrorAndNothingStays)
{
  this->Write(Shuffled(Torus(96, 48), 2));
  const std::size_t whole = fs::file_size(this->Input());
  const fs::path disk = this->Folder / "disk";
  fs::create_directory(disk);
  for (const bool spill : { true, false })
  {
    for (const std::size_t bytes : { whole / 20, whole / 4 })
    {
      SCOPED_TRACE(std::to_string(bytes) + (spill ? " for temporary files" : " for the store"));
      const std::string size = "size=" + std::to_string(bytes);
      if (::mount("tmpfs", disk.c_str(), "tmpfs", 0, size.c_str()) != 0)
      {
        GTEST_SKIP() << "no file system can be mounted here: " << std::strerror(errno);
      }
      this->Options.temporaryFolder = spill ? disk : this->Spill();
      const auto built = BuildStoreExternally(
        this->Input(), spill ? this->Store() : disk / "m.kds", this->Options, {}, this->Probe);
      EXPECT_TRUE(fs::is_empty(disk));
      EXPECT_EQ(::umount(disk.c_str()), 0);
      ASSERT_FALSE(built);
      EXPECT_EQ(built.GetError().code, ErrorCode::InputOutput);
      const std::string& text = built.GetError().message;
      EXPECT_EQ(text.find("the temporary folder is too small") != text.npos, spill) << text;
      EXPECT_TRUE(!spill || text.find(" bytes") != text.npos) << text;
      EXPECT_EQ(text.find("the store takes about ") != text.npos, !spill) << text;
      this->ExpectNothingLeft({ "in.ply", "spill", "disk" });
    }
  }
}
