// SPDX-License-Identifier: BSD-3-Clause
// Stores by an octree, built out of core: byte for byte the same as in memory, for any limit and
// number of threads, and however often the build was killed.
#include "Testing/Fixtures/Attributes.h"
#include "Testing/Fixtures/Meshes.h"
#include "filters/baselines/stores/Baselines.h"
#include "filters/build/ExternalBuilder.h"
#include "filters/build/Testing/KilledBuild.h"
#include "filters/meshio/MeshWriter.h"
#include "filters/program/TbbExecution.h"

#include <gtest/gtest.h>

#include <atomic>
#include <fstream>
#include <iterator>

using namespace kdstream;
using namespace kdstream::fixtures;
namespace fs = std::filesystem;

namespace
{

// Adds vertices in the place of the first one, each with a triangle of its own.
Mesh WithCopiesOfTheFirst(Mesh mesh, VertexId count)
{
  for (VertexId i = 0; i < count; ++i)
  {
    const auto copy = static_cast<VertexId>(mesh.points.size());
    mesh.points.push_back(mesh.points[0]);
    mesh.triangles.push_back({ copy, 0, 1 });
  }
  return mesh;
}

constexpr std::uint64_t KiB = 1024;

class ExternalOctreeStore : public ::testing::Test
{
protected:
  ExternalOctreeStore()
  {
    const fs::path parent =
      ::access("/dev/shm", W_OK) == 0 ? fs::path("/dev/shm") : fs::temp_directory_path();
    std::string name = (parent / "kdstream-octree-XXXXXX").string();
    this->Folder = ::mkdtemp(name.data());
    fs::create_directory(this->Folder / "spill");
    this->Options.partitioner = &OctreeMethod();
    this->Options.memory = leastMemory;
    this->Options.temporaryFolder = this->Folder / "spill";
    this->Options.tree.verticesPerPartition = 100;
    this->Probe.stepMemory = 512 * KiB;
  }
  ~ExternalOctreeStore() override { fs::remove_all(this->Folder); }

  void Write(const Mesh& mesh)
  {
    const Status status = WriteMesh(this->Folder / "in.ply", mesh);
    ASSERT_TRUE(status) << status.GetError().message;
  }
  // Returns the bytes of the store, and removes it.
  std::string Take()
  {
    std::ifstream stream(this->Folder / "m.kds", std::ios::binary);
    const std::string bytes{ std::istreambuf_iterator<char>(stream), {} };
    fs::remove(this->Folder / "m.kds");
    return bytes;
  }
  // Returns the bytes of the store that a build in memory makes.
  std::string InMemory()
  {
    BuildOptions options = this->Options;
    options.memory = 0;
    const auto report = BuildStore(this->Folder / "in.ply", this->Folder / "m.kds", options);
    EXPECT_TRUE(report) << report.GetError().message;
    if (report)
    {
      this->Merged = report->mergedByGrid;
    }
    return this->Take();
  }
  Result<BuildReport> External(const Execution& execution = {})
  {
    return BuildStoreExternally(
      this->Folder / "in.ply", this->Folder / "m.kds", this->Options, execution, this->Probe);
  }
  void ExpectTheSame(const std::string& expected, unsigned threads)
  {
    const auto report = this->External(MakeTbbExecution(threads));
    ASSERT_TRUE(report) << report.GetError().message;
    EXPECT_EQ(report->mergedByGrid, this->Merged);
    EXPECT_GT(report->passes, 1U);
    EXPECT_TRUE(this->Take() == expected);
  }
  bool NothingLeft() const
  {
    return fs::is_empty(this->Folder / "spill") && !fs::exists(this->Folder / "m.kds");
  }

  // Runs a build in a process of its own, which is killed before the k-th file operation or
  // progress report. Returns whether it was killed.
  bool BuildAndKill(std::size_t k)
  {
    return BuildAndKillAt(
      k, this->Probe, [&](const Execution& execution) { return this->External(execution); });
  }

  fs::path Folder;
  BuildOptions Options;
  ExternalBuildProbe Probe;
  std::uint64_t Merged = 0; // by the grid; of the last store built in memory
};

}

TEST_F(ExternalOctreeStore, EveryMeshGivesTheStoreOfTheBuildInMemory)
{
  std::vector<NamedMesh> meshes = AllMeshes();
  meshes.push_back({ "equal coordinates", Shuffled(GridPlate(60), 3) });
  Mesh cloud = Shuffled(DisplacedSphere(5), 4);
  cloud.triangles.clear();
  meshes.push_back({ "cloud", cloud });
  constexpr unsigned threads[] = { 1, 2, 5 };
  unsigned turn = 0;
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
        this->Options.tree.verticesPerPartition = turn % 3 == 0 ? 7 : 100;
        this->Probe.stepMemory = (attributes                       ? 4096
                                   : named.name == "repeated cube" ? 1024
                                                                   : 256) *
                                 KiB;
        const std::string expected = this->InMemory();
        this->ExpectTheSame(expected, threads[turn % 3]);
        ++turn;
      }
    }
  }
  EXPECT_TRUE(this->NothingLeft());
}

TEST_F(ExternalOctreeStore, MemoryAndThreadsChangeNothing)
{
  for (const Mesh& mesh :
    { Shuffled(GridPlate(130), 3), WithAttributes(Shuffled(DisplacedSphere(4), 5), 3) })
  {
    const std::uint64_t unit = mesh.attributes.empty() ? 160 * KiB : 4096 * KiB;
    this->Write(mesh);
    const std::string expected = this->InMemory();
    for (const std::uint64_t memory : { unit, 4 * unit, 32 * unit })
    {
      for (const unsigned threads : { 1U, 2U, 5U })
      {
        SCOPED_TRACE(std::to_string(memory) + " bytes, " + std::to_string(threads) + " threads");
        this->Probe.stepMemory = memory;
        this->ExpectTheSame(expected, threads);
      }
    }
  }
}

TEST_F(ExternalOctreeStore, AWantedNumberOfPartitionsIsMetAsInMemory)
{
  const Mesh coincident = WithCopiesOfTheFirst(Torus(40, 30), 120);
  this->Options.weld = false;
  this->Options.bits = 0;
  for (const Mesh& mesh : { Shuffled(GridPlate(60), 3), Torus(60, 40), coincident })
  {
    this->Write(mesh);
    const auto all = static_cast<std::uint32_t>(mesh.points.size());
    for (const std::uint32_t wanted : { 1U, 2U, 9U, 27U, 64U, 500U, all / 2, all - 1, all })
    {
      SCOPED_TRACE(wanted);
      this->Options.tree.partitions = wanted;
      this->Probe.stepMemory = wanted < 9 ? 8192 * KiB : 768 * KiB;
      this->ExpectTheSame(this->InMemory(), 2);
    }
  }
  for (const std::uint32_t wanted : { 0U, 5000U })
  {
    this->Options.tree.partitions = wanted;
    const auto report = this->External();
    ASSERT_FALSE(report);
    EXPECT_EQ(report.GetError().code, ErrorCode::InvalidArgument);
  }
}

TEST_F(ExternalOctreeStore, KilledAnywhereItLeavesNoStoreAndGoesOn)
{
  this->Write(WithAttributes(Shuffled(Torus(48, 32), 2), 4));
  constexpr std::uint64_t unit = 4096 * KiB;
  this->Probe.stepMemory = 4 * unit;
  const std::string expected = this->InMemory();
  std::atomic<std::size_t> steps{ 0 };
  std::vector<std::size_t> publishing;
  this->Probe.hook = [&](FileOperation operation)
  {
    if (operation == FileOperation::Rename)
    {
      publishing.push_back(steps);
    }
    ++steps;
  };
  Execution counting;
  counting.progress = [&](std::string_view, double)
  {
    ++steps;
    return true;
  };
  ASSERT_TRUE(this->External(counting));
  ASSERT_TRUE(this->Take() == expected);
  this->Probe.hook = {};
  ASSERT_EQ(publishing.size(), 4U) << "a phase each";
  for (std::size_t phase = 0; phase < publishing.size(); ++phase)
  {
    SCOPED_TRACE("killed behind phase " + std::to_string(phase));
    for (const std::uint64_t memory : { 4 * unit, 16 * unit, unit })
    {
      this->Options.resume = false;
      this->Probe.stepMemory = 4 * unit;
      ASSERT_TRUE(this->BuildAndKill(publishing[phase] + 2));
      EXPECT_FALSE(fs::exists(this->Folder / "m.kds"));
      this->Options.resume = true;
      this->Probe.stepMemory = memory;
      auto report = this->External();
      if (memory == unit && phase >= 2)
      {
        ASSERT_FALSE(report) << "blocks of more memory are in the files";
        EXPECT_NE(report.GetError().message.find("had more memory"), std::string::npos);
        this->Probe.stepMemory = 4 * unit;
        report = this->External(); // the finished phases are still there
      }
      ASSERT_TRUE(report) << report.GetError().message;
      EXPECT_EQ(report->resumedPhases, phase + 1);
      EXPECT_TRUE(this->Take() == expected);
      EXPECT_TRUE(this->NothingLeft());
    }
  }
}

TEST_F(ExternalOctreeStore, ACancelOrAnErrorLeavesNothing)
{
  this->Write(Shuffled(Torus(96, 48), 2));
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
  EXPECT_EQ(steps, (std::vector<std::string>{ "read", "tree", "faces", "encode", "write" }));
  this->Take();
  const std::size_t all = calls;
  ASSERT_GT(all, 50U);
  for (stopAt = 1; stopAt <= all; stopAt += all / 40 + 1)
  {
    calls = 0;
    steps.clear();
    const auto report = this->External(execution);
    ASSERT_FALSE(report) << stopAt;
    EXPECT_EQ(report.GetError().code, ErrorCode::Cancelled);
    EXPECT_TRUE(this->NothingLeft());
  }

  // These vertices in one place form one partition, whatever size is wanted.
  this->Write(WithCopiesOfTheFirst(Torus(96, 48), 2000));
  this->Options.weld = false;
  const auto report = this->External();
  ASSERT_FALSE(report);
  EXPECT_EQ(report.GetError().code, ErrorCode::LimitExceeded);
  EXPECT_NE(report.GetError().message.find("a partition of 2001 vertices"), std::string::npos)
    << report.GetError().message;
  EXPECT_TRUE(this->NothingLeft());
}
