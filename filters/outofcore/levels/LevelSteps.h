// SPDX-License-Identifier: BSD-3-Clause
// The steps of making levels out of core that are the same whoever has the blocks: one process
// (ExternalLevels.h) or several (filters/Parallel). Only for the makers of levels.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/levels/ClusterRound.h"
#include "filters/core/levels/CollapseLevels.h"
#include "filters/core/levels/Levels.h"
#include "filters/outofcore/files/SpillFile.h"
#include "filters/outofcore/levels/FileClusterRound.h"
#include "filters/outofcore/levels/FileLevelBlocks.h"
#include "filters/outofcore/levels/LevelFile.h"
#include "filters/outofcore/levels/LevelLinks.h"
#include "filters/outofcore/levels/LevelStates.h"
#include "filters/outofcore/mesh/MeshBlocks.h"

#include <vector>

namespace kdstream
{

// Errors of all steps: InputOutput; Cancelled.
class LevelSteps
{
public:
  // Keeps references. REQUIRES: the mesh's counts and attributes are known.
  LevelSteps(const MeshBlocks& mesh, const LevelOptions& options, const Execution& execution);

  bool ByClusters() const { return this->Clusters; }
  const LevelArrays& Arrays() const { return this->LevelsArrays; }
  // Whether vertices in one place have to be linked where they are in different cells: known when
  // all finest blocks are built. Those in one cell are in one cluster, and their links vanish.
  bool LinksCoincident() const { return this->Clusters && this->MayCoincide; }

  // The blocks of a level: at most as deep as `most`, but so large that a round to the next coarser
  // level has that level's nodes in one of them.
  unsigned BlockDepthOf(unsigned level, unsigned most) const;
  // Whether the level coarser than this one, the coarsest so far, is made in files. states: of it.
  bool IsCoarserInFiles(const LevelFile& level, const LevelStates& states) const;

  // Appends the finest clusters of a block of the mesh, the first of which is number firstCluster,
  // and writes the cluster of each of its vertices, by rank.
  Status BuildFinestBlock(
    const TreeBlock& block, VertexId firstCluster, SpillFile& clusterOfRank, LevelWriter& writer);

  // Moves the clusters of a level's blocks that are here where its triangles face the wrong way
  // (FoldOverRepair.h): those of other blocks must be where they were at first. REQUIRES: the
  // level's triangles are written. Not by clusters.
  Status RepairFoldOvers(
    SpillFolder& folder, LevelFile& level, LevelStates& states, const BlockRange& here) const;

  // The clusters of level `depth` by a round of collapses.
  Status Collapse(FileLevelBlocks& blocks, unsigned depth) const;
  // The same by clusters: MakeCoarserClustersInFiles.
  Status Join(
    SpillFolder& folder, const LinkedLevel& below, unsigned depth, LevelWriter& writer) const;

  // All levels coarser than `level`, the last one in files, [depth], in memory; its parents are
  // filled. states: of that level; given up early, to save their files' room. links: none where the
  // levels are not by clusters.
  Result<std::vector<ClusterLevel>> BuildCoarse(
    SpillFolder& folder, LevelFile& level, LevelStates states, const LevelLinks& links) const;

  // What is done of the finest level, or of a coarser one: 0 … 1.
  Status ReportFinest(double done) const;
  Status ReportLevel(unsigned depth, double done) const;

private:
  LevelOptions OptionsFor(const TreeBlock& block);
  Result<std::vector<ClusterLevel>> MakeCoarse(SpillFolder& folder, CollapseState&& state,
    const LevelFile& level, const LevelLinks& links) const;

  const MeshBlocks& Mesh;
  const LevelOptions& Options;
  const Execution& Exec;
  const CollapseSpace Space;
  const bool Clusters;
  const ClusterRules Rules;
  // Whether it matters that vertices are in one place. Of levels by clusters not without sheets,
  // and of a cloud: all of a cell are one cluster anyway.
  const bool JoinsCoincident;
  bool MayCoincide; // vertices may be in one place
  LevelArrays LevelsArrays;
};

}
