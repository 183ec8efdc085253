// One round of collapses in parts: from a level in blocks to the next coarser one. For the makers
// of levels alone.
//
// Every part (a partition, or below S a node of the coarser level's pieces) collapses alone, with
// the clusters of other parts fixed, and leaves a list of its merges; one threshold cuts all lists.
// Blocks tell each other nothing but that threshold and where their clusters go: the result does
// not depend on how many there are.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/levels/LevelBlocks.h"
#include "filters/core/levels/MergeSelection.h"
#include "filters/core/levels/Merging.h"
#include "filters/core/levels/PartCollapse.h"
#include "filters/core/tree/KdTree.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

namespace kdstream
{

// Whether the level `depth` is made in parts: down to S, and below S while levels are large. finer:
// clusters of the level below it.
bool CollapsesInParts(const TreeDepths& depths, unsigned depth, std::size_t finer);

// Clusters with triangles that level `depth` is to have: some more than 2^depth where they are few,
// or limbs are lost. Those without triangles come on top of them.
std::size_t SurfaceWanted(unsigned depth);

class CollapseRound
{
public:
  // Makes level `depth` from the blocks of the one below it. report(done): progress, 0-1. Keeps
  // references to all. REQUIRES: CollapsesInParts; blocks no smaller than parts.
  CollapseRound(LevelBlocks& blocks, const TreeDepths& depths, unsigned depth,
    const CollapseSpace& space, Representative representative, bool sheets,
    const Execution& execution, const std::function<Status(double)>& report);

  // Errors: those of the blocks and of report. Three passes over the blocks, up to four more where
  // nodes would hold too much.
  Status Run();

private:
  // What is known of all lists while they are not in memory.
  struct Summary
  {
    std::uint32_t clusters = 0; // of the part, those without triangles too
    std::uint32_t own = 0, merges = 0;
    bool made = false, stuck = false, whole = false;
    double last = 0; // error
    std::size_t taken = 0;
  };
  using PartFilter = std::function<bool(std::size_t part)>;

  std::size_t PartsOfBlock() const { return this->Summaries.size() / this->Blocks.Count(); }
  std::size_t Share() const;
  Status Collapse(const PartFilter& wanted, double enough, double from, double to);
  Status ForEachLoaded(
    std::span<const std::size_t> blocks, const std::function<Status(std::size_t)>& use);
  Status CollapseBlock(std::size_t block, const PartFilter& wanted, double enough);
  void Summarize(std::size_t part, const MergeList& list);
  std::size_t ToTake(std::size_t stride) const;
  Result<CheapestErrors> CheapestOf(std::size_t stride, std::size_t count);
  Status TakeUntil();
  Status LeaveTies(CheapestErrors& cheapest);
  Status ShareSummaries();
  Status KeepTargets();
  bool MayOverflow() const;
  Result<bool> TakeMore(std::size_t block, const std::vector<std::size_t>& excess);
  Status EmptyNodes();
  Result<Merging> MergingOf(std::size_t block);
  Status Finish();
  Status FinishBlock(std::size_t block);

  LevelBlocks& Blocks;
  const TreeDepths& Depths;
  unsigned Depth;
  unsigned PartDepth;
  const CollapseSpace& Space;
  Representative How;
  bool Sheets;
  const Execution& Exec;
  const std::function<Status(double)>& Report;
  std::vector<Summary> Summaries; // of all parts
  std::vector<std::uint8_t> Full; // nodes to be grouped by cells; empty = none
  std::size_t LoadedBlock = 0;
  std::optional<PartCollapse> Engine; // of the block loaded last
};

}
