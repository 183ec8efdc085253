// SPDX-License-Identifier: BSD-3-Clause
// From a mesh file to a store: step "build" of the pipeline picture. Declares what callers
// (kdstream-build and tests) need to build a store: BuildOptions, BuildReport and BuildStore.
// BuildStore builds in memory if --memory allows that, and passes everything else to
// ExternalBuilder.h.
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
  const PartitionMethod* partitioner = &KdTreeMethod(); // how the mesh is cut
  KdTreeOptions tree;
  LevelOptions levels;
  bool weld = true;       // a soup (MeshFileInfo) is always welded
  std::uint8_t bits = 20; // of the grid (8-24), or 0: lossless
  // The most bytes that the build may take; 0 = no limit. A mesh that needs more is built out of
  // core (ExternalBuilder.h).
  std::uint64_t memory = 0;
  MedianMethod median = nullptr;         // out of core; null: FindMedianByHistogram
  std::filesystem::path temporaryFolder; // for temporary files; empty: beside the store
  // Continue an interrupted build of the same input and options. If the folder has files of a
  // different build, they stay, and this build is refused.
  bool resume = false;
  // Called at most once, early, with a sentence for the user. With `resume`: where the build
  // continues. Without `resume`: where an earlier build could have been continued.
  std::function<void(const std::string& found)> tellEarlierBuild = [](const std::string&) {};
  // Called after the input has been read and welded, with the remaining counts.
  std::function<void(std::uint64_t vertices, std::uint64_t triangles)> tellSize =
    [](std::uint64_t, std::uint64_t) {};
  bool strict = false; // refuse input that was repaired or partly dropped (Tolerance.h)
  std::string title, credit, license, unit, description;
  // The up direction, and the direction from the model to the eye in the first view. Guessed if not
  // given (GuessHomeView.h). REQUIRES: directions (DirectionOf).
  std::optional<Vec3> up, view;
  // Makes textures of partitions, from the arrays of texture coordinates that the input has; null:
  // the store gets no textures.
  std::shared_ptr<const PieceTextures> textures;
  std::string inputName; // stored as the input's name; empty: the name of the file
  // The files whose bytes identify the input (InputDigest.h), in this order; empty: the input file.
  std::vector<std::filesystem::path> inputFiles;
  // For an input that is converted anew for each build: the file that it is converted from, and
  // everything else that the conversion depends on. A build can be resumed if these are the same.
  // Empty: not converted.
  std::filesystem::path convertedFrom;
  std::string convertedBy;
  std::vector<std::filesystem::path> convertedWith; // files that it refers to: pictures, materials
};

struct BuildReport
{
  ModelDescription info;
  ScalarType scalarType = ScalarType::Float32; // of the input
  // Vertices in different places that the grid puts in the same place: what its bits lose.
  std::uint64_t mergedByGrid = 0;
  std::vector<std::string> ignoredAttributes; // of the input: MeshFileInfo
  Tolerance tolerance;                        // of reading the input
  // Passes over all vertices: for reading the input, and out of core also for the tree.
  std::uint64_t passes = 1;
  // Temporary files: the most bytes at any time, and all bytes read and written.
  std::uint64_t temporaryBytes = 0, bytesRead = 0, bytesWritten = 0;
  std::uint64_t resumedPhases = 0; // phases taken from an interrupted build
  std::vector<std::pair<std::string, double>>
    seconds; // read, tree, faces, levels, encode, write, total
};

// Builds `store` from `input`. The store appears whole or not at all. Its content depends only on
// input and options. If it is certain that a build in memory stays within options.memory
// (CheckInputMemory), the store is built in memory, else out of core. This is decided before a
// point is read. Complexity O(n log n + t log t); peak memory: MostBuildMemory. Errors: those of
// MeshReader and ComputeDepths; a mesh without vertices or with attributes that no store can hold
// (PrepareMesh); with options.strict those of Tolerance::Check; LimitExceeded; InputOutput;
// Cancelled; with options.resume those of BuildFolder::Open. The message does not name the file.
Result<BuildReport> BuildStore(const std::filesystem::path& input,
  const std::filesystem::path& store, const BuildOptions& options, const Execution& execution = {});

// The same for a mesh in memory. Always builds in memory, whatever options.memory is. name: stored
// as the input's name.
Result<BuildReport> BuildStore(Mesh mesh, const std::string& name,
  const std::filesystem::path& store, const BuildOptions& options, const Execution& execution = {});

}
