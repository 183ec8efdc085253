// SPDX-License-Identifier: BSD-3-Clause
// What happens to the files of a level after each rank has made its clusters: the clusters are
// numbered over all ranks, and moved to other ranks. Only for DistributedLevels.cxx.
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

// Collective: all ranks call it together. Errors of all functions: InputOutput; MpiGroup's.
class DistributedLevelFiles
{
public:
  // Keeps references.
  DistributedLevelFiles(
    MpiGroup& group, SpillFolder& folder, const LevelArrays& arrays, bool byClusters);

  // The elements of this rank's blocks of a level or of the mesh. begin: the first element of each
  // block, and the end.
  CellRange RangeHere(std::span<const VertexId> begin, unsigned depth) const;

  // Numbers the clusters of a level that all ranks have made in the blocks of the finer level. The
  // clusters move down in the files, and so do the entries of `map` in `mapped`. Returns the area
  // of all.
  Status Settle(LevelFile& level, LevelStates& states, SpillFile& map, const CellRange& mapped);
  // Blocks of a smaller depth: clusters move to the ranks that have these.
  Status MakeBlocks(LevelFile& level, LevelStates& states, unsigned blockDepth);
  // Moves a level to rank 0 as far as it is needed whole: clusters, parents (if any), triangles.
  // states, links: those of the coarsest level so far, which has no parents; they are moved, too.
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
  const std::size_t SumBytes; // of a cluster's sums of attributes
};

}
