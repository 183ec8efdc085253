// SPDX-License-Identifier: BSD-3-Clause
// From a mesh file to a store: conducts step "build" of the pipeline picture. What a caller needs
// to build one, kdstream-build and the tests: BuildOptions, BuildReport, BuildStore, which builds
// in memory what fits --memory, and hands over to ExternalBuilder.h what does not.
#pragma once

#include "filters/build/PartitionMethod.h"
#include "filters/build/PieceTextures.h"
#include "filters/core/Execution.h"
#include "filters/core/levels/Levels.h"
#include "filters/core/tree/KdTree.h"
#include "filters/meshio/Tolerance.h"
#include "filters/outofcore/tree/MedianSearch.h"
#include "filters/store/Store.h"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace kdstream
{

struct BuildOptions
{
  const PartitionMethod* partitioner = &KdTreeMethod(); // what the mesh is cut by
  KdTreeOptions tree;
  LevelOptions levels;
  bool weld = true;       // a soup (MeshFileInfo) is welded in any case
  std::uint8_t bits = 20; // of the grid (8-24), or 0: lossless
  // Most bytes the build may take; 0 = no limit. A mesh that needs more is built out of core
  // (ExternalBuilder.h).
  std::uint64_t memory = 0;
  MedianMethod median = nullptr;         // out of core; null: FindMedianByHistogram
  std::filesystem::path temporaryFolder; // for what is out of core; empty: beside the store
  // Go on with an interrupted build of the same input and options. What one of others has left
  // stays as it is, and the build is refused.
  bool resume = false;
  // Called at most once, early, with a sentence for the user: with `resume`, from where the build
  // continues; without it, from where it could have continued.
  std::function<void(const std::string& found)> tellEarlierBuild = [](const std::string&) {};
  // Called once the input has been read and welded, with the numbers that are left.
  std::function<void(std::uint64_t vertices, std::uint64_t triangles)> tellSize =
    [](std::uint64_t, std::uint64_t) {};
  bool strict = false; // refuse input of which something was dropped or forgiven (Tolerance.h)
  std::string title, credit, license, unit, description;
  // What is up, and from where the model is looked at first: towards the eye. Guessed where they
  // are not given (GuessHomeView.h). REQUIRES: directions (DirectionOf).
  std::optional<Vec3> up, view;
  // Makes textures of partitions, by arrays of paint that the input has; null: there are none.
  std::shared_ptr<const PieceTextures> textures;
  std::string inputName; // stored as the input's name; empty: that of the file
  // By whose bytes the input is known (InputDigest.h), one after the other; empty: the file.
  std::vector<std::filesystem::path> inputFiles;
  // For an input that is made anew for each build from another file: that file, and all else that
  // the input depends on. An interrupted build of the same file is the same build. Empty: none.
  std::filesystem::path convertedFrom;
  std::string convertedBy;
  std::vector<std::filesystem::path> convertedWith; // files that it names: pictures, materials
};

struct BuildReport
{
  ModelDescription info;
  ScalarType scalarType = ScalarType::Float32; // of the input
  // Vertices in different places that fall together on the grid: what its bits lose.
  std::uint64_t mergedByGrid = 0;
  std::vector<std::string> ignoredAttributes; // of the input: MeshFileInfo
  Tolerance tolerance;                        // the same
  // Over all vertices: reading the input, and out of core the tree's.
  std::uint64_t passes = 1;
  // Of the files out of core: the most bytes at any time, and all bytes read and written.
  std::uint64_t temporaryBytes = 0, bytesRead = 0, bytesWritten = 0;
  std::uint64_t resumedPhases = 0; // that were taken over from an interrupted build
  std::vector<std::pair<std::string, double>>
    seconds; // read, tree, faces, levels, encode, write, total
};

// Builds `store` from `input`. The store appears whole or not at all.
// In memory where that keeps options.memory for certain (CheckInputMemory), which is decided before
// a point is read; else out of core. Complexity O(n log n + t log t); peak memory: MostBuildMemory.
// The content depends on input and options alone. Errors: those of MeshReader and ComputeDepths; a
// mesh without vertices or with attributes that no store can hold (PrepareMesh); with
// options.strict what Tolerance::Check refuses; LimitExceeded; InputOutput; Cancelled; with
// options.resume those of BuildFolder::Open. The message does not name the file.
Result<BuildReport> BuildStore(const std::filesystem::path& input,
  const std::filesystem::path& store, const BuildOptions& options, const Execution& execution = {});

// The same from a mesh in memory, and in memory: options.memory is not asked. name: stored as the
// input's name.
Result<BuildReport> BuildStore(Mesh mesh, const std::string& name,
  const std::filesystem::path& store, const BuildOptions& options, const Execution& execution = {});

}
