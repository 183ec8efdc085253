// From a mesh file to a store: the README's picture from "read" to "store", in memory.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/KdTree.h"
#include "filters/core/Levels.h"
#include "filters/store/PartitionMesh.h"
#include "filters/store/Store.h"

#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace kdstream
{

struct BuildOptions
{
  Partitioner partitioner = Partitioner::KdTree;
  KdTreeOptions tree;
  LevelOptions levels;
  bool weld = true;       // a soup (MeshFileInfo) is welded in any case
  std::uint8_t bits = 20; // of the grid (8-24), or 0: lossless
  // Most bytes the build may take; 0 = no limit. A mesh that needs more is refused (LimitExceeded).
  std::uint64_t memory = 0;
  std::string title, credit, license, unit;
  std::string inputName; // stored as the input's name; empty: that of the file
};

struct BuildReport
{
  StoreInfo info;
  // Vertices in different places that fall together on the grid: what its bits lose.
  std::uint64_t mergedByGrid = 0;
  std::vector<std::string> ignoredAttributes; // of the input: MeshFileInfo
  std::vector<std::pair<std::string, double>>
    seconds; // read, tree, faces, levels, encode, write, total
};

// Builds `store` from `input`. The store appears whole or not at all.
// Complexity O(n log n + t log t); peak memory as EstimateBuildMemory
// (BuildMemory.h). The content depends on input
// and options alone. Errors: those of MeshReader and ComputeDepths; a mesh without vertices
// or with attributes that no store can hold (PrepareMesh);
// LimitExceeded; InputOutput; Cancelled. The message does not name the file.
Result<BuildReport> BuildStore(const std::filesystem::path& input,
  const std::filesystem::path& store, const BuildOptions& options, const Execution& execution = {});

// The same from a mesh in memory. name: stored as the input's name.
Result<BuildReport> BuildStore(Mesh mesh, const std::string& name,
  const std::filesystem::path& store, const BuildOptions& options, const Execution& execution = {});

}
