// SPDX-License-Identifier: BSD-3-Clause
// From a mesh file to a store, with less memory than the mesh takes: step "build" out of core.
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

// The smallest options.memory with which a build out of core is tried.
inline constexpr std::uint64_t leastMemory = std::uint64_t{ 64 } << 20;

// Only for tests.
struct ExternalBuildProbe
{
  FileHook hook;                // for the files of the build folder
  std::uint64_t stepMemory = 0; // bytes for each step; 0: as options.memory allows
};

// An input that has been opened, and the time that this took.
struct OpenedInput
{
  StepClock clock{};
  std::unique_ptr<MeshReader> reader{}; // null: not open yet
};

// Builds `store` from `input`, with files in options.temporaryFolder: to the byte the same store as
// a build in memory. Peak memory: options.memory + 64 MiB, including libraries. The build is a list
// of phases; with options.resume it continues after the last finished phase. Errors: those of
// BuildStore, and of CheckExternalBuild.
Result<BuildReport> BuildStoreExternally(const std::filesystem::path& input,
  const std::filesystem::path& store, const BuildOptions& options, const Execution& execution = {},
  const ExternalBuildProbe& probe = {}, OpenedInput opened = {});

// Describes what a build without options.resume would discard: the step with which a build with
// options.resume would continue, or the options that it would need. Empty if there is nothing to
// continue.
std::string DescribeResumable(const std::filesystem::path& input,
  const std::filesystem::path& store, const BuildOptions& options);

// Checks that a store with these options can be built out of core. Errors: LimitExceeded for a
// limit below leastMemory, and for the baseline kmeans, which works only in memory.
Status CheckExternalBuild(const BuildOptions& options);

}
