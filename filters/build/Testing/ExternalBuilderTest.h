// SPDX-License-Identifier: BSD-3-Clause
// A build out of core in a folder of its own, finished or killed, and the same build in memory.
#pragma once

#include "filters/build/ExternalBuilder.h"
#include "filters/build/Testing/KilledBuild.h"
#include "filters/meshio/MeshWriter.h"
#include "filters/outofcore/journal/BuildFolder.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <string>
#include <vector>

#include <unistd.h>

namespace kdstream
{

inline constexpr std::uint64_t KiB = 1024;
inline constexpr std::uint64_t smallMemory = 512 * KiB; // many blocks, and a tree out of core

inline std::string BytesOf(const std::filesystem::path& file)
{
  std::ifstream stream(file, std::ios::binary);
  return { std::istreambuf_iterator<char>(stream), {} };
}

// A build in a temporary folder, with partitions of 200 vertices.
class ExternalBuilderTest : public ::testing::Test
{
protected:
  ExternalBuilderTest()
  {
    // On a RAM disk if the system has one, because every build waits for the disk some fifty times.
    const std::filesystem::path parent = ::access("/dev/shm", W_OK) == 0
                                           ? std::filesystem::path("/dev/shm")
                                           : std::filesystem::temp_directory_path();
    std::string name = (parent / "kdstream-external-XXXXXX").string();
    this->Folder = ::mkdtemp(name.data());
    std::filesystem::create_directory(this->Spill());
    this->Options.memory = leastMemory;
    this->Options.temporaryFolder = this->Spill();
    this->Options.tree.verticesPerPartition = 200;
    this->Probe.stepMemory = smallMemory;
  }
  ~ExternalBuilderTest() override { std::filesystem::remove_all(this->Folder); }

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
    const std::string bytes = BytesOf(this->Folder / "memory.kds");
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
    const std::string bytes = BytesOf(this->Store());
    std::filesystem::remove(this->Store());
    return bytes;
  }
  void ExpectNothingLeft(const std::set<std::string>& but = { "in.ply", "spill" })
  {
    EXPECT_TRUE(std::filesystem::is_empty(this->Spill()));
    std::set<std::string> names;
    for (const std::filesystem::directory_entry& entry :
      std::filesystem::directory_iterator(this->Folder))
    {
      names.insert(entry.path().filename().string());
    }
    EXPECT_EQ(names, but);
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
  // The folder with what a killed build left.
  std::filesystem::path Left() const { return BuildFolder::PathFor(this->Store(), this->Spill()); }

  std::filesystem::path Folder;
  BuildOptions Options;
  ExternalBuildProbe Probe;
};

}
