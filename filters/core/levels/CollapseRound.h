// SPDX-License-Identifier: BSD-3-Clause
// One round of collapses in parts: from a level in blocks to the next coarser one. Only for the
// makers of levels.
//
// Every part (a partition; for levels coarser than S, a node of the coarser level's pieces)
// collapses by itself, with the clusters of other parts fixed, and makes a list of its merges; one
// threshold decides how much of every list is used. Blocks exchange only that threshold and the
// targets of their clusters, so the result does not depend on the number of blocks.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/levels/LevelBlocks.h"
#include "filters/core/levels/MergeThreshold.h"
#include "filters/core/levels/Merging.h"
#include "filters/core/levels/PartLists.h"
#include "filters/core/tree/KdTree.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

namespace kdstream
{

// Whether level `depth` is made in parts: from L to S always, coarser than S while levels are
// large. clusters, triangles: of the level below it.
bool CollapsesInParts(
  const TreeDepths& depths, unsigned depth, std::size_t clusters, std::size_t triangles);

// The number of clusters with triangles that level `depth` should have: more than 2^depth at small
// levels, because otherwise limbs are lost. Clusters without triangles come in addition.
std::size_t SurfaceWanted(unsigned depth);

// The depth of the parts in which the clusters of a level collapse.
unsigned PartDepthOf(const TreeDepths& depths, unsigned depth);

class CollapseRound
{
public:
  // Makes level `depth` from the blocks of the one below it. report(done): progress, 0-1. Keeps
  // references to all. REQUIRES: CollapsesInParts; blocks no smaller than parts.
  CollapseRound(LevelBlocks& blocks, const TreeDepths& depths, unsigned depth,
    const CollapseSpace& space, Representative representative, bool byComponents,
    const Execution& execution, const std::function<Status(double)>& report);

  // Errors: those of the blocks and of report. Makes three passes over the blocks, and up to four
  // more if nodes would hold too many clusters.
  Status Run();

private:
  Status MakeLists();
  Status KeepTargets();
  bool MayOverflow(std::size_t node) const;
  bool AnyMayOverflow() const;
  bool HasMore(std::size_t node) const;
  bool MayTakeMore(std::size_t block) const;
  Status EmptyNodes();
  Status TakeMoreWhereFull();
  Result<bool> TakeMore(std::size_t block, const std::vector<std::size_t>& excess);
  Status TakeMoreOfNode(std::size_t block, std::size_t begin, std::size_t end, std::size_t count);
  Status GroupFullNodes();
  Result<Merging> MergingOf(std::size_t block);
  Status Finish();
  Status FinishBlock(std::size_t block);
  Status ForEachBlockHere(const std::function<Status(std::size_t)>& use);
  std::size_t NodeCount() const;
  std::function<Status(double)> ReportFrom(double from, double to) const;

  LevelBlocks& Blocks;
  const TreeDepths& Depths;
  unsigned Depth;
  const CollapseSpace& Space;
  Representative How;
  bool ByComponents;
  const Execution& Exec;
  const std::function<Status(double)>& Report;
  PartLists Lists;
  MergeThreshold Threshold;
  std::vector<std::uint8_t>
    Full; // nodes whose clusters are grouped by cells; empty if there is none
};

}
