// SPDX-License-Identifier: BSD-3-Clause
// Stores by an octree, built out of core: byte for byte the same as in memory, for any limit and
// number of threads, and however often the build was killed.
#include "Testing/Fixtures/Attributes.h"
#include "Testing/Fixtures/Meshes.h"
#include "filters/baselines/stores/Baselines.h"
#include "filters/build/Testing/ExternalBuilderTest.h"
#include "filters/program/TbbExecution.h"

#include <gtest/gtest.h>

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

class ExternalOctreeStore : public ExternalBuilderTest
{
protected:
  ExternalOctreeStore()
  {
    this->Options.partitioner = &OctreeMethod();
    this->Options.tree.verticesPerPartition = 100;
  }

  void ExpectTheSame(const std::string& expected, unsigned threads)
  {
    const auto report = this->External(MakeTbbExecution(threads));
    ASSERT_TRUE(report) << report.GetError().message;
    EXPECT_EQ(report->mergedByGrid, this->Merged);
    EXPECT_GT(report->passes, 1U);
    EXPECT_TRUE(this->Take() == expected);
  }
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
  this->ExpectNothingLeft();
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
  std::vector<std::size_t> publishing;
  this->CountSteps(publishing);
  ASSERT_TRUE(this->Take() == expected);
  ASSERT_EQ(publishing.size(), 4U) << "a phase each";
  for (std::size_t phase = 0; phase < publishing.size(); ++phase)
  {
    SCOPED_TRACE("killed behind phase " + std::to_string(phase));
    for (const std::uint64_t memory : { 4 * unit, 16 * unit, unit })
    {
      this->Options.resume = false;
      this->Probe.stepMemory = 4 * unit;
      ASSERT_TRUE(this->BuildAndKill(publishing[phase] + 2));
      EXPECT_FALSE(fs::exists(this->Store()));
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
      this->ExpectNothingLeft();
    }
  }
}

TEST_F(ExternalOctreeStore, ACancelOrAnErrorLeavesNothing)
{
  this->Write(Shuffled(Torus(96, 48), 2));
  std::vector<std::string> steps;
  const auto calls = this->BuildUntil(~std::size_t{ 0 }, steps);
  ASSERT_TRUE(calls);
  EXPECT_EQ(steps, (std::vector<std::string>{ "read", "tree", "faces", "encode", "write" }));
  this->Take();
  ASSERT_GT(*calls, 50U);
  for (std::size_t stopAt = 1; stopAt <= *calls; stopAt += *calls / 40 + 1)
  {
    const auto report = this->BuildUntil(stopAt, steps);
    ASSERT_FALSE(report) << stopAt;
    EXPECT_EQ(report.GetError().code, ErrorCode::Cancelled);
    this->ExpectNothingLeft();
  }

  // These vertices in one place form one partition, whatever size is wanted.
  this->Write(WithCopiesOfTheFirst(Torus(96, 48), 2000));
  this->Options.weld = false;
  const auto report = this->External();
  ASSERT_FALSE(report);
  EXPECT_EQ(report.GetError().code, ErrorCode::LimitExceeded);
  EXPECT_NE(report.GetError().message.find("a partition of 2001 vertices"), std::string::npos)
    << report.GetError().message;
  this->ExpectNothingLeft();
}
