// SPDX-License-Identifier: BSD-3-Clause
// Makes a coarser level by clusters from a level in files, block by block. Only for the levels out
// of core.
#pragma once

#include "filters/core/levels/ClusterRound.h"
#include "filters/core/levels/LevelBlocks.h"
#include "filters/outofcore/levels/LevelLinks.h"
#include "filters/outofcore/levels/LevelStates.h"

#include <functional>

namespace kdstream
{

// A level from which the next coarser one is made.
struct LinkedLevel
{
  LevelFile& level; // its file of parents is filled in
  const LevelStates& states;
  const LevelLinks& links;
  BlockRange here; // the blocks to process
};

// Appends the clusters of level `depth` to `coarser`, in blocks of the same depth as those of
// `below`, and writes the number of each cluster's parent into the file of parents of `below`. The
// caller makes the triangles and links. report: called after each block with the progress, 0 … 1.
// Memory: one block without ghosts, about 520 bytes a cluster. Errors: InputOutput; those of
// report. REQUIRES: blocks are not deeper than `depth`.
Status MakeCoarserClustersInFiles(SpillFolder& folder, const LinkedLevel& below, unsigned depth,
  const LevelArrays& arrays, const ClusterRules& rules, LevelWriter& coarser,
  const Execution& execution, const std::function<Status(double)>& report);

}
