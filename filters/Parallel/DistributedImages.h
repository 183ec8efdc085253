// SPDX-License-Identifier: BSD-3-Clause
// Makes the triangles of a level whose blocks are on several ranks: the images of the triangles of
// the finer level, or of the mesh. Only for DistributedLevels.cxx.
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

// The triangles of the finer level, or of the mesh; each rank has those of its blocks.
struct FinerTriangles
{
  // Appends the triangles of one of this rank's blocks. Their corners are indices of entries in
  // `map`.
  std::function<Status(std::size_t block, std::vector<Triangle>&)> load;
  // VertexId: cluster of the level. Entries of other ranks have been fetched.
  const SpillFile& map;
  std::span<const VertexId> begin; // index in `map` of the first entry of each block, and the end
  unsigned blockDepth;
};

// Writes the triangles of this rank's blocks of a level; for levels by clusters (links is not null)
// also the links. A triangle whose block is on another rank is sent there, in one round for each
// block of the finer level. Returns the number of triangles of the level on all ranks. Memory: one
// block, and `memory` / 8 for received triangles. Errors: InputOutput; those of MpiGroup.
Result<std::uint64_t> WriteDistributedImages(MpiGroup& group, SpillFolder& folder,
  const FinerTriangles& finer, std::uint64_t memory, LevelFile& level, LevelLinks* links);

// Finds the clusters of other ranks that triangles and links of this rank's blocks use
// (level.foreign), and fetches them with their tuples. links: as above. Errors: as above.
Status FetchForeignClusters(
  MpiGroup& group, std::size_t tupleBytes, LevelFile& level, const LevelLinks* links);

}
