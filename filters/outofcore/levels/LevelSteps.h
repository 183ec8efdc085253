// SPDX-License-Identifier: BSD-3-Clause
// The steps of making levels out of core that do not depend on who has the blocks: one process
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
  // Whether vertices in the same place have to be linked if they are in different cells: known when
  // all finest blocks are built. Vertices of one cell are in one cluster, so they need no link.
  bool LinksCoincident() const { return this->Clusters && this->MayCoincide; }

  // The depth of a level's blocks: at most `most`, and small enough that each node of the next
  // coarser level is in one block.
  unsigned BlockDepthOf(unsigned level, unsigned most) const;
  // Whether the next coarser level is made in files. level: the coarsest so far; states: its own.
  bool IsCoarserInFiles(const LevelFile& level, const LevelStates& states) const;

  // Appends the finest clusters of a block of the mesh, beginning with number firstCluster, and
  // writes the cluster of each of its vertices, by rank.
  Status BuildFinestBlock(
    const TreeBlock& block, VertexId firstCluster, SpillFile& clusterOfRank, LevelWriter& writer);

  // Moves clusters of this process's blocks of a level where its triangles face the wrong way
  // (FoldOverRepair.h). Clusters of other blocks must be at their original places. REQUIRES: the
  // level's triangles are written. Not for levels by clusters.
  Status RepairFoldOvers(
    SpillFolder& folder, LevelFile& level, LevelStates& states, const BlockRange& here) const;

  // The clusters of level `depth` by a round of collapses.
  Status Collapse(FileLevelBlocks& blocks, unsigned depth) const;
  // The same by clusters: MakeCoarserClustersInFiles.
  Status Join(
    SpillFolder& folder, const LinkedLevel& below, unsigned depth, LevelWriter& writer) const;

  // All levels coarser than `level`, which is the coarsest in files: [depth], in memory. Fills in
  // the parents of `level`. states: of that level; removed early, to save disk space. links: none
  // unless the levels are by clusters.
  Result<std::vector<ClusterLevel>> BuildCoarse(
    SpillFolder& folder, LevelFile& level, LevelStates states, const LevelLinks& links) const;

  // Reports progress of the finest level, or of a coarser one: 0 … 1.
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
  // Whether it matters that vertices are in the same place. It does not for a cloud, and for levels
  // by clusters without components, since all vertices of a cell are then one cluster anyway.
  const bool JoinsCoincident;
  bool MayCoincide; // vertices may be in one place
  LevelArrays LevelsArrays;
};

}
