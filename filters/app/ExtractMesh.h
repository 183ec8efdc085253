// SPDX-License-Identifier: BSD-3-Clause
// Selects the mesh that is extracted from a store: for kdstream-store extract and distance.
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

// At most one of the first four is given; without any, the whole original is wanted.
struct WantedMesh
{
  std::optional<unsigned> level;
  std::optional<std::uint32_t> partition;
  std::optional<NodeId> region;      // the partitions around a node of the tree
  std::string resolutions;           // a file: doc/cli.md#kdstream-store
  unsigned rings = 1;                // of the region
  std::optional<unsigned> inContext; // for a region: the level around it
};

// The mesh that the options select, without vertices that no triangle uses. Errors:
// InvalidArgument, naming the option, if the store does not have it; NotFound if the file of
// resolutions cannot be read; those of reading the store.
Result<Mesh> ExtractMesh(const Store& store, const WantedMesh& wanted);

// Whether the mesh is the whole original, and the store also has vertices that no triangle uses.
// Formats that hold only surfaces omit them.
bool HasUnused(const Store& store, const WantedMesh& wanted);

// The partitions that a mesh has of the original.
struct WantedPartitions
{
  std::vector<std::uint32_t> partitions; // shown as the original, ascending
  bool alone = false;                    // whether nothing else is in the mesh
};

// The partitions that the options select; none for a level. Errors: as above.
Result<WantedPartitions> PartitionsOf(const Store& store, const WantedMesh& wanted);

}
