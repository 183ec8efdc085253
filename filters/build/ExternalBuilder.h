// SPDX-License-Identifier: BSD-3-Clause
// From a mesh file to a store with less memory than the mesh takes: step "build" out of core.
#pragma once

#include "filters/build/Builder.h"
#include "filters/build/StepClock.h"
#include "filters/core/Execution.h"
#include "filters/meshio/MeshReader.h"
#include "filters/outofcore/files/SpillFile.h"

#include <filesystem>
#include <memory>
#include <string>

namespace kdstream
{

// The least options.memory that a build out of core is tried with.
inline constexpr std::uint64_t leastMemory = std::uint64_t{ 64 } << 20;

// Only for tests.
struct ExternalBuildProbe
{
  FileHook hook;                // of the build folder's files
  std::uint64_t stepMemory = 0; // bytes for each step; 0: what options.memory leaves
};

// An input that has been opened, and how long that took.
struct OpenedInput
{
  StepClock clock{};
  std::unique_ptr<MeshReader> reader{}; // null: not yet
};

// Builds `store` from `input` by files in options.temporaryFolder: the same store as the build in
// memory makes, to the byte. Peak memory: options.memory + 64 MiB, what libraries take included.
// The build is a list of phases; a build with options.resume continues after the last finished
// phase. Errors: those of BuildStore, and of CheckExternalBuild.
Result<BuildReport> BuildStoreExternally(const std::filesystem::path& input,
  const std::filesystem::path& store, const BuildOptions& options, const Execution& execution = {},
  const ExternalBuildProbe& probe = {}, OpenedInput opened = {});

// What a build without options.resume would throw away: the files from which a build with it would
// continue, or what that build would need. Empty if there is nothing to continue from.
std::string DescribeResumable(const std::filesystem::path& input,
  const std::filesystem::path& store, const BuildOptions& options);

// Checks that such a store can be built out of core. Errors: LimitExceeded for a limit below
// leastMemory, and for the baseline kmeans, which works only in memory.
Status CheckExternalBuild(const BuildOptions& options);

}
