// SPDX-License-Identifier: BSD-3-Clause
// Stores that are built out of core equal those built in memory, byte for byte, for any limit,
// number of threads and median method. Also error messages.
#include "Testing/Fixtures/Attributes.h"
#include "Testing/Fixtures/ErrorAt.h"
#include "Testing/Fixtures/Meshes.h"
#include "filters/baselines/stores/Baselines.h"
#include "filters/build/Testing/ExternalBuilderTest.h"
#include "filters/program/TbbExecution.h"

#include <gtest/gtest.h>

#include <cerrno>
#include <csignal>
#include <cstring>
#include <fstream>
#include <set>

#include <sys/mount.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

using namespace kdstream;
using namespace kdstream::fixtures;
namespace fs = std::filesystem;

TEST_F(ExternalBuilderTest, EveryMeshGivesTheStoreOfTheBuildInMemory)
{
  constexpr MedianMethod methods[] = { FindMedianByHistogram, FindMedianByHeaps, FindMedianByTorben,
    FindMedianBySort };
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
          this->Options.median = methods[turn % 4];
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

// In memory the vertices of such a mesh are renumbered (GatherMesh.h); out of core they are not.
TEST_F(ExternalBuilderTest, AMeshInNoOrderGivesTheSameStoreToo)
{
  // With holes: edges of the boundary are sorted by vertices.
  Mesh open = DisplacedSphere(6);
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
    for (const char* median : { "histogram", "heaps", "torben", "sort" })
    {
      this->Options.median = MedianMethodOfName(median);
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
        EXPECT_TRUE(this->Take() == expected) << median << ", " << threads << " threads";
      }
    }
    EXPECT_GT(passes.size(), 2U) << "the methods are not all in use";
  }
}

TEST_F(ExternalBuilderTest, ProgressNeverRunsBackAndACancelLeavesNothing)
{
  this->Write(WithAttributes(Shuffled(Torus(96, 48), 2), 4));
  std::vector<std::string> steps;
  const auto calls = this->BuildUntil(~std::size_t{ 0 }, steps);
  ASSERT_TRUE(calls);
  EXPECT_EQ(
    steps, (std::vector<std::string>{ "read", "tree", "faces", "levels", "encode", "write" }));
  const std::string digest = this->Take();
  this->Write(Torus(20, 20));
  ASSERT_TRUE(this->External());
  const std::string old = ReadWhole(this->Store());
  this->Write(WithAttributes(Shuffled(Torus(96, 48), 2), 4));
  ASSERT_GT(*calls, 50U);
  for (std::size_t stopAt = 1; stopAt <= *calls; stopAt += *calls / 20)
  {
    const auto report = this->BuildUntil(stopAt, steps);
    ASSERT_FALSE(report) << stopAt;
    EXPECT_EQ(report.GetError().code, ErrorCode::Cancelled);
    this->ExpectNothingLeft({ "in.ply", "spill", "m.kds" });
    EXPECT_TRUE(ReadWhole(this->Store()) == old) << "the old store is gone";
  }
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
  EXPECT_TRUE(FailsAt(refused, ErrorCode::LimitExceeded, "(8.000000, 0.500000, -2.000000)"));
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
    EXPECT_EQ(this->External().GetError().file, this->Store()) << "the folder is not at fault";
  }
  this->ExpectNothingLeft();
  this->Options.temporaryFolder = this->Folder / "no";
  EXPECT_NE(message().find((this->Folder / "no").string()), std::string::npos);
  this->Options.temporaryFolder = this->Spill();
  this->Write(Mesh{ {}, {}, ScalarType::Float32, {} });
  EXPECT_TRUE(fixtures::FailsAt(this->External(), ErrorCode::InvalidInput, "no vertices"));
  std::ofstream(this->Input()) << "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\n"
                                  "property float y\nproperty float z\nelement face 1\n"
                                  "property list uchar int vertex_indices\nend_header\n"
                                  "0 0 0\n1 0 0\n3 0 1 2\n";
  EXPECT_NE(message().find("face 0 (line 12) names vertex 2"), std::string::npos);
  this->Options.partitioner = &KMeansMethod();
  EXPECT_NE(message().find("only be built in memory"), std::string::npos);
  this->Options.partitioner = &KdTreeMethod();
  this->Options.memory = leastMemory - 1;
  EXPECT_NE(message().find("at least 64 MiB"), std::string::npos);
  this->ExpectNothingLeft();
}

// Limits the size of files. Runs in a process of its own, because the limit stays.
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
      ::_exit(built || built.GetError().code != ErrorCode::DiskFull ? 1 : 0);
    }
    int state = 0;
    ::waitpid(child, &state, 0);
    EXPECT_TRUE(WIFEXITED(state) && WEXITSTATUS(state) == 0);
    const std::string text = ReadWhole(said);
    EXPECT_NE(text.find("the temporary folder is too small"), std::string::npos) << text;
    EXPECT_NE(text.find(" bytes"), std::string::npos) << text;
    fs::remove(said);
    this->ExpectNothingLeft();
  }
}

// A full file system: first for the temporary files, then for the store.
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
      EXPECT_EQ(built.GetError().code, ErrorCode::DiskFull);
      const std::string& text = built.GetError().message;
      EXPECT_EQ(text.find("the temporary folder is too small") != text.npos, spill) << text;
      EXPECT_TRUE(!spill || text.find(" bytes") != text.npos) << text;
      EXPECT_EQ(text.find("the store needs about ") != text.npos, !spill) << text;
      this->ExpectNothingLeft({ "in.ply", "spill", "disk" });
    }
  }
}
