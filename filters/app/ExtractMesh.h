// SPDX-License-Identifier: BSD-3-Clause
// Which mesh is taken out of a store: by kdstream-store extract and distance.
#pragma once

#include "filters/core/Result.h"
#include "filters/core/Types.h"
#include "filters/store/Store.h"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace kdstream
{

// One of the first four; the whole original where none is given.
struct WantedMesh
{
  std::optional<unsigned> level;
  std::optional<std::uint32_t> partition;
  std::optional<NodeId> region;      // the partitions around a node of the tree
  std::string resolutions;           // a file: doc/cli.md#kdstream-store
  unsigned rings = 1;                // of a region
  std::optional<unsigned> inContext; // of a region: the level around it
};

// The mesh that the options ask for, without vertices that no triangle uses. Errors:
// InvalidArgument, naming the option, for what the store does not have; NotFound where the file of
// resolutions cannot be read; those of reading the store.
Result<Mesh> ExtractMesh(const Store& store, const WantedMesh& wanted);

// Whether the mesh is the whole original with vertices that no triangle uses, and the store has
// some. Formats that hold only surfaces leave them out.
bool HasUnused(const Store& store, const WantedMesh& wanted);

// What a mesh has of the original.
struct WantedPartitions
{
  std::vector<std::uint32_t> partitions; // that are shown as the original, ascending
  bool alone = false;                    // nothing else is in the mesh
};

// The partitions that are wanted; none for a level. Errors: as above.
Result<WantedPartitions> PartitionsOf(const Store& store, const WantedMesh& wanted);

}
