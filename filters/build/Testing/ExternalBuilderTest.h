// SPDX-License-Identifier: BSD-3-Clause
// A build out of core in a folder of its own, finished or killed, and the same build in memory.
#pragma once

#include "Testing/Fixtures/TemporaryFolder.h"
#include "filters/build/ExternalBuilder.h"
#include "filters/build/Testing/KilledBuild.h"
#include "filters/meshio/MeshWriter.h"
#include "filters/outofcore/journal/BuildFolder.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <set>
#include <string>
#include <vector>

namespace kdstream
{

inline constexpr std::uint64_t KiB = 1024;
inline constexpr std::uint64_t smallMemory = 512 * KiB; // many blocks, and a tree out of core

// A build in a temporary folder, with partitions of 200 vertices.
class ExternalBuilderTest : public ::testing::Test
{
protected:
  ExternalBuilderTest()
  {
    std::filesystem::create_directory(this->Spill());
    this->Options.memory = leastMemory;
    this->Options.temporaryFolder = this->Spill();
    this->Options.tree.verticesPerPartition = 200;
    this->Probe.stepMemory = smallMemory;
  }

  std::filesystem::path Spill() const { return this->Folder / "spill"; }
  std::filesystem::path Input() const { return this->Folder / "in.ply"; }
  std::filesystem::path Store() const { return this->Folder / "m.kds"; }

  void Write(const Mesh& mesh)
  {
    const Status status = WriteMesh(this->Input(), mesh);
    ASSERT_TRUE(status) << status.GetError().message;
  }
  // The bytes of the store that a build in memory makes.
  std::string InMemory(const Execution& execution = {})
  {
    BuildOptions options = this->Options;
    options.memory = 0;
    const auto report = BuildStore(this->Input(), this->Folder / "memory.kds", options, execution);
    EXPECT_TRUE(report) << report.GetError().message;
    this->Merged = report ? report->mergedByGrid : 0;
    const std::string bytes = fixtures::ReadWhole(this->Folder / "memory.kds");
    std::filesystem::remove(this->Folder / "memory.kds");
    return bytes;
  }
  Result<BuildReport> External(const Execution& execution = {})
  {
    return BuildStoreExternally(
      this->Input(), this->Store(), this->Options, execution, this->Probe);
  }
  // Removes the store, and returns its bytes.
  std::string Take()
  {
    const std::string bytes = fixtures::ReadWhole(this->Store());
    std::filesystem::remove(this->Store());
    return bytes;
  }
  void ExpectNothingLeft(const std::set<std::string>& but = { "in.ply", "spill" })
  {
    EXPECT_TRUE(std::filesystem::is_empty(this->Spill()));
    EXPECT_EQ(this->Temporary.Names(), but);
  }

  // Runs a build in a process of its own, which is killed before the k-th of its steps (file
  // operations and progress reports). Returns whether it was killed.
  bool BuildAndKill(std::size_t k)
  {
    return BuildAndKillAt(
      k, this->Probe, [&](const Execution& execution) { return this->External(execution); });
  }
  // Counts these steps in a complete build. publishing: set to the numbers of the steps that rename
  // a file.
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
  // Builds, and stops at the call `stopAt` of the progress. Expects that progress never runs back.
  // steps: set to the steps' names. Returns the number of calls.
  Result<std::size_t> BuildUntil(std::size_t stopAt, std::vector<std::string>& steps)
  {
    steps.clear();
    double last = 0;
    std::size_t calls = 0;
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
    const auto report = this->External(execution);
    KDSTREAM_TRY(report);
    return calls;
  }
  // The folder with what a killed build left.
  std::filesystem::path Left() const { return BuildFolder::PathFor(this->Store(), this->Spill()); }

  // Every build waits for the disk some fifty times.
  const fixtures::TemporaryFolder Temporary{ fixtures::FastTemporaryPath() };
  const std::filesystem::path Folder = this->Temporary.Path;
  BuildOptions Options;
  ExternalBuildProbe Probe;
  std::uint64_t Merged = 0; // by the grid; of the last store built in memory
};

}
