// SPDX-License-Identifier: BSD-3-Clause
// Changes the files of a level after each rank has made its clusters: numbers the clusters over all
// ranks, and moves them to other ranks. Only for DistributedLevels.cxx.
#pragma once

#include "filters/Parallel/MpiGroup.h"
#include "filters/core/Result.h"
#include "filters/core/tree/KdTree.h"
#include "filters/outofcore/files/SpillFile.h"
#include "filters/outofcore/levels/LevelFile.h"
#include "filters/outofcore/levels/LevelLinks.h"
#include "filters/outofcore/levels/LevelStates.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace kdstream
{

// All ranks call each function together. Errors of all functions: InputOutput; those of MpiGroup.
class DistributedLevelFiles
{
public:
  // Keeps references to the arguments.
  DistributedLevelFiles(
    MpiGroup& group, SpillFolder& folder, const LevelArrays& arrays, bool byClusters);

  // The range of the elements of this rank's blocks, in a level or in the mesh. begin: the first
  // element of each block, and the end.
  CellRange RangeHere(std::span<const VertexId> begin, unsigned depth) const;

  // Numbers the clusters of a level over all ranks without gaps, after each rank has made the
  // clusters in its own blocks of the finer level. Moves clusters down in the files, and changes
  // the entries `mapped` of `map` to the new numbers. Sets states.area to the area of all clusters.
  Status Settle(LevelFile& level, LevelStates& states, SpillFile& map, const CellRange& mapped);
  // Changes to blocks of a smaller depth: clusters move to the ranks that have these blocks.
  Status MakeBlocks(LevelFile& level, LevelStates& states, unsigned blockDepth);
  // Moves a level to rank 0: clusters, parents (if any), and triangles. If the level has no
  // parents, it is the coarsest so far; then `states` and `links` must be its own, and move too.
  Status MoveToFirst(LevelFile& level, LevelStates& states, LevelLinks& links);

private:
  // A file with an element for each cluster of a level.
  struct ClusterFile
  {
    SpillFile* file;
    std::size_t elementBytes;
  };

  std::vector<ClusterFile> FilesOf(LevelFile& level, LevelStates& states) const;
  Status CountClusters(LevelFile& level);
  Status AddUpArea(LevelStates& states, const CellRange& own);
  Status ListToFirst(const LevelFile& level, SpillFile& file, std::vector<std::uint64_t>& begin);
  Status SendToFirst(
    SpillFile& file, std::uint64_t from, std::uint64_t size, std::vector<std::uint64_t> places);

  MpiGroup& Group;
  SpillFolder& Folder;
  const LevelArrays& Arrays;
  const bool ByClusters;
  const std::size_t SumBytes; // of a cluster's attribute sums
};

}
