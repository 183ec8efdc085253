// SPDX-License-Identifier: BSD-3-Clause
// The triangles of a level whose blocks lie on several ranks: the images of those of the finer
// level, or of the mesh. Only for DistributedLevels.cxx.
#pragma once

#include "filters/Parallel/MpiGroup.h"
#include "filters/core/Result.h"
#include "filters/core/Types.h"
#include "filters/outofcore/levels/LevelFile.h"
#include "filters/outofcore/levels/LevelLinks.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace kdstream
{

// The triangles of the finer level, or of the mesh, on the rank that has their block.
struct FinerTriangles
{
  // Appends those of a block that is here; their corners are places in `map`.
  std::function<Status(std::size_t block, std::vector<Triangle>&)> load;
  // VertexId: cluster of the level; clusters of other ranks are filled in.
  const SpillFile& map;
  std::span<const VertexId> begin; // place of each block in it, and the end
  unsigned blockDepth;
};

// Writes the triangles of this rank's blocks of a level; for levels by clusters (links is not null)
// also the links. A triangle whose block lies on another rank is sent there, in one round for each
// block of the finer level. Returns the number of triangles of the level on all ranks. Memory: a
// block, and `memory` / 8 for what is received. Errors: InputOutput; MpiGroup's.
Result<std::uint64_t> WriteDistributedImages(MpiGroup& group, SpillFolder& folder,
  const FinerTriangles& finer, std::uint64_t memory, LevelFile& level, LevelLinks* links);

// Finds the clusters of other ranks that the blocks here use in triangles and links
// (level.foreign), and fetches them with their tuples. links: as above. Errors: as above.
Status FetchForeignClusters(
  MpiGroup& group, std::size_t tupleBytes, LevelFile& level, const LevelLinks* links);

}
