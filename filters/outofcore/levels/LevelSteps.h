// SPDX-License-Identifier: BSD-3-Clause
// The steps of making levels out of core that are the same whether one process has all blocks
// (ExternalLevels.h) or several share them (filters/Parallel). Only for the makers of levels.
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
  // Keeps references to the arguments. REQUIRES: the mesh's counts and attributes are known.
  LevelSteps(const MeshBlocks& mesh, const LevelOptions& options, const Execution& execution);

  bool ByClusters() const { return this->Clusters; }
  const LevelArrays& Arrays() const { return this->LevelsArrays; }
  // Whether vertices in the same place have to be linked if they are in different cells; known once
  // all finest blocks are built. Vertices of one cell are in one cluster, so they need no link.
  bool LinksCoincident() const { return this->Clusters && this->MayCoincide; }

  // The depth of the blocks of a level: at most `most`, and small enough that each node of the next
  // coarser level lies within one block.
  unsigned BlockDepthOf(unsigned level, unsigned most) const;
  // Whether the next coarser level is made in files. level: the coarsest so far; states: those of
  // that level.
  bool IsCoarserInFiles(const LevelFile& level, const LevelStates& states) const;

  // Appends the finest clusters of a block of the mesh, numbered from firstCluster on, and writes
  // the cluster of each vertex of the block, by rank.
  Status BuildFinestBlock(
    const TreeBlock& block, VertexId firstCluster, SpillFile& clusterOfRank, LevelWriter& writer);

  // Moves clusters in this process's blocks where triangles of the level face the wrong way
  // (FoldOverRepair.h). Clusters of other blocks must be at their original places. REQUIRES: the
  // level's triangles are written. Not for levels by clusters.
  Status RepairFoldOvers(
    SpillFolder& folder, LevelFile& level, LevelStates& states, const BlockRange& here) const;

  // Makes the clusters of level `depth` by a round of collapses.
  Status Collapse(FileLevelBlocks& blocks, unsigned depth) const;
  // Makes them by clusters of cells instead: MakeCoarserClustersInFiles.
  Status Join(
    SpillFolder& folder, const LinkedLevel& below, unsigned depth, LevelWriter& writer) const;

  // All levels coarser than `level`, which is the coarsest in files: [depth], in memory. Fills in
  // the parents of `level`. states: those of `level`; their files are removed early, to save disk
  // space. links: empty unless the levels are made by clusters.
  Result<std::vector<ClusterLevel>> BuildCoarse(
    SpillFolder& folder, LevelFile& level, LevelStates states, const LevelLinks& links) const;

  // Reports progress (0 … 1) of the finest level, or of a coarser one.
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
  // Whether it matters that vertices are in the same place. It does not for a cloud, nor for levels
  // by clusters without components: all vertices of a cell are then one cluster anyway.
  const bool JoinsCoincident;
  bool MayCoincide; // whether vertices may be in one place
  LevelArrays LevelsArrays;
};

}
