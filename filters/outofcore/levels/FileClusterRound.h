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

// A level that the next coarser one is made of.
struct LinkedLevel
{
  LevelFile& level; // its parents are filled
  const LevelStates& states;
  const LevelLinks& links;
  BlockRange here; // the blocks that are gone through
};

// Appends the clusters of level `depth` to `coarser`, in blocks of the same depth as those of
// `below`, and writes their numbers into below's file of parents. The caller makes the triangles
// and links. report: called after each block with the progress, 0 … 1. Memory: a block without
// ghosts, about 520 bytes a cluster. Errors: InputOutput; those of report. REQUIRES: blocks are not
// deeper than `depth`.
Status MakeCoarserClustersInFiles(SpillFolder& folder, const LinkedLevel& below, unsigned depth,
  const LevelArrays& arrays, const ClusterRules& rules, LevelWriter& coarser,
  const Execution& execution, const std::function<Status(double)>& report);

}
