// SPDX-License-Identifier: BSD-3-Clause
// One round of collapses in parts: see CollapseRound.h.
//   1. Make lists of merges (PartLists). A sample of the parts collapses as far as any part may
//      have to, which gives an estimate of the threshold; the other parts collapse only a little
//      beyond it.
//   2. Find one threshold for all lists: it decides how many merges of each list are taken
//      (MergeThreshold).
//   3. Blocks exchange where their clusters go.
//   4. Nodes that would hold too many clusters take more merges; if these are not enough, their
//      clusters are grouped by cells.
//   5. Make the blocks of the coarser level.
#include "filters/core/levels/CollapseRound.h"

#include "filters/core/levels/CoarserState.h"
#include "filters/core/levels/ForEachLoaded.h"
#include "filters/core/tree/PieceDepth.h"

#include <algorithm>
#include <iterator>
#include <numeric>
#include <span>

namespace kdstream
{
namespace
{

constexpr std::size_t sampled = 8;    // one part of this number estimates the threshold
constexpr double beyond = 1.5;        // the others collapse up to this multiple of the estimate
constexpr std::size_t mostExtra = 32; // clusters of coarse levels; measured
// Levels coarser than S are made in parts if they are this level or finer. A coarser one is also
// made in parts if the level below has more clusters than usual, because edges cannot collapse
// (thousands of small bodies, triangle soups): it may not fit in memory. These numbers are
// constants instead of depending on the memory limit, because the store must not depend on that.
constexpr unsigned firstInParts = 16;
constexpr std::size_t mostCollapsedFreely = (1 << firstInParts) + (1 << (firstInParts - 2));
// Surfaces have two triangles for each cluster. Of further triangles, this number takes as much
// memory as a cluster (measured).
constexpr std::size_t trianglesOfCluster = 10;

}

unsigned PartDepthOf(const TreeDepths& depths, unsigned depth)
{
  return depth >= depths.stitch ? depths.partition : PieceDepth(Resolution::Level(depth), depths);
}

bool CollapsesInParts(
  const TreeDepths& depths, unsigned depth, std::size_t clusters, std::size_t triangles)
{
  const std::size_t beyondSurface = triangles - std::min(triangles, 2 * clusters);
  return depth >= depths.stitch || depth >= firstInParts ||
         clusters + beyondSurface / trianglesOfCluster > mostCollapsedFreely;
}

std::size_t SurfaceWanted(unsigned depth)
{
  const std::size_t all = std::size_t{ 1 } << depth;
  return all + std::min(all, mostExtra);
}

CollapseRound::CollapseRound(LevelBlocks& blocks, const TreeDepths& depths, unsigned depth,
  const CollapseSpace& space, Representative representative, bool byComponents,
  const Execution& execution, const std::function<Status(double)>& report)
  : Blocks(blocks)
  , Depths(depths)
  , Depth(depth)
  , Space(space)
  , How(representative)
  , ByComponents(byComponents)
  , Exec(execution)
  , Report(report)
  , Lists(blocks, space, std::size_t{ 1 } << PartDepthOf(depths, depth),
      depths.finest - PartDepthOf(depths, depth),
      SurfaceWanted(depth) >> PartDepthOf(depths, depth), execution)
  , Threshold(blocks, this->Lists, SurfaceWanted(depth))
{
}

Status CollapseRound::Run()
{
  KDSTREAM_TRY(this->MakeLists());
  KDSTREAM_TRY(this->Threshold.Take(this->ReportFrom(0.7, 0.7)));
  KDSTREAM_TRY(this->KeepTargets());
  if (this->AnyMayOverflow())
  {
    KDSTREAM_TRY(this->EmptyNodes());
  }
  return this->Finish();
}

// A progress function for a step that takes the progress of the whole from `from` to `to`.
std::function<Status(double)> CollapseRound::ReportFrom(double from, double to) const
{
  return [this, from, to](double done) { return this->Report(from + (to - from) * done); };
}

// The nodes of the level's pieces. Each node is in one block, and has the same number of
// consecutive parts.
std::size_t CollapseRound::NodeCount() const
{
  return std::size_t{ 1 } << PieceDepth(Resolution::Level(this->Depth), this->Depths);
}

Status CollapseRound::MakeLists()
{
  if (this->Lists.Count() < 4 * sampled)
  {
    return this->Lists.Make([](std::size_t) { return true; }, everyError, this->ReportFrom(0, 0.7));
  }
  KDSTREAM_TRY(this->Lists.Make(
    [](std::size_t part) { return part % sampled == 0; }, everyError, this->ReportFrom(0, 0.1)));
  const Result<double> estimate = this->Threshold.Estimate(sampled);
  KDSTREAM_TRY(estimate);
  return this->Lists.Make([](std::size_t part) { return part % sampled != 0; }, beyond * *estimate,
    this->ReportFrom(0.1, 0.7));
}

// Stores for each block where the taken merges put its clusters: neighbouring blocks need it.
Status CollapseRound::KeepTargets()
{
  if (this->Blocks.Count() == 1)
  {
    return {};
  }
  KDSTREAM_TRY(this->Lists.ForEachBlock(
    [&](std::size_t block, const std::vector<MergeList>& lists) -> Status
    {
      const std::size_t first = this->Lists.FirstOfBlock(block);
      std::size_t clusters = 0;
      for (std::size_t local = 0; local < lists.size(); ++local)
      {
        clusters += this->Lists.Of(first + local).clusters;
      }
      std::vector<VertexId> targets(clusters);
      std::iota(targets.begin(), targets.end(), VertexId{ 0 });
      for (std::size_t local = 0; local < lists.size(); ++local)
      {
        const std::size_t taken = this->Lists.Of(first + local).taken;
        ApplyMerges(std::span(lists[local].merges).first(taken), targets);
      }
      return this->Blocks.KeepTargets(block, TargetStage::Merged, targets);
    }));
  return this->Blocks.ShareTargets(TargetStage::Merged);
}

// Whether a node might hold too many clusters. Counts all that have no triangles, although some of
// them may still be grouped.
bool CollapseRound::MayOverflow(std::size_t node) const
{
  const std::size_t parts = this->Lists.Count() / this->NodeCount();
  std::size_t clusters = 0;
  for (std::size_t p = node * parts; p < (node + 1) * parts; ++p)
  {
    clusters += this->Lists.Of(p).clusters - this->Lists.Of(p).taken;
  }
  return clusters > MostOfNode(this->Depths, this->Depth);
}

bool CollapseRound::AnyMayOverflow() const
{
  std::size_t node = 0;
  while (node < this->NodeCount() && !this->MayOverflow(node))
  {
    ++node;
  }
  return node < this->NodeCount();
}

// Whether parts of a node have merges that are not taken, or not even found.
bool CollapseRound::HasMore(std::size_t node) const
{
  const std::size_t parts = this->Lists.Count() / this->NodeCount();
  const auto lists = std::span(this->Lists.All()).subspan(node * parts, parts);
  return std::any_of(lists.begin(), lists.end(),
    [](const ListSummary& list) { return !list.whole || list.taken < list.merges; });
}

// Whether a node of the block that might hold too many clusters can take more merges. A block
// without such a node need not be loaded: if edges cannot collapse, these are most blocks.
bool CollapseRound::MayTakeMore(std::size_t block) const
{
  const std::size_t nodes = this->NodeCount() / this->Blocks.Count();
  std::size_t node = block * nodes;
  while (node < (block + 1) * nodes && !(this->MayOverflow(node) && this->HasMore(node)))
  {
    ++node;
  }
  return node < (block + 1) * nodes;
}

Status CollapseRound::EmptyNodes()
{
  KDSTREAM_TRY(this->TakeMoreWhereFull());
  return this->GroupFullNodes();
}

// Nodes that would hold too many clusters get a higher threshold of their own.
Status CollapseRound::TakeMoreWhereFull()
{
  std::uint64_t blocksWithMore = 0;
  const BlockRange here = this->Blocks.Here();
  for (std::size_t block = here.begin; block < here.end; ++block)
  {
    if (!this->MayTakeMore(block))
    {
      continue;
    }
    const Result<Merging> merging = this->MergingOf(block);
    KDSTREAM_TRY(merging);
    const Result<bool> taken = this->TakeMore(block, merging->ExcessOfNodes());
    KDSTREAM_TRY(taken);
    blocksWithMore += *taken ? 1 : 0;
  }
  KDSTREAM_TRY(this->Blocks.Sum(std::span(&blocksWithMore, 1)));
  if (blocksWithMore > 0)
  {
    KDSTREAM_TRY(this->Lists.Share());
    KDSTREAM_TRY(this->KeepTargets());
  }
  return {};
}

// excess: the number of clusters by which each node is too full; 0 outside the block. Takes this
// number of further merges in the node, if there are any. Returns whether any were taken.
Result<bool> CollapseRound::TakeMore(std::size_t block, const std::vector<std::size_t>& excess)
{
  const std::size_t parts = this->Lists.Count() / excess.size();
  bool any = false;
  for (std::size_t node = 0; node < excess.size(); ++node)
  {
    if (excess[node] == 0)
    {
      continue;
    }
    const std::size_t begin = node * parts, end = (node + 1) * parts;
    KDSTREAM_TRY(this->Lists.MakeInBlock(
      block,
      [&](std::size_t part) { return part >= begin && part < end && !this->Lists.Of(part).whole; },
      everyError));
    std::size_t left = 0;
    for (std::size_t p = begin; p < end; ++p)
    {
      left += this->Lists.Of(p).merges - this->Lists.Of(p).taken;
    }
    if (left > 0)
    {
      KDSTREAM_TRY(this->TakeMoreOfNode(block, begin, end, std::min(left, excess[node])));
      any = true;
    }
  }
  return any;
}

// Takes the cheapest `count` remaining merges of the parts [begin, end), which are in the block.
Status CollapseRound::TakeMoreOfNode(
  std::size_t block, std::size_t begin, std::size_t end, std::size_t count)
{
  const Result<std::vector<MergeList>*> lists = this->Blocks.Lists(block);
  KDSTREAM_TRY(lists);
  const auto mergesOf = [&](std::size_t part) -> const std::vector<Merge>&
  { return (**lists)[part - this->Lists.FirstOfBlock(block)].merges; };
  Result<CheapestErrors> cheapest = FindCheapest(
    [&](const auto& visit) -> Status
    {
      for (std::size_t p = begin; p < end; ++p)
      {
        for (const Merge& merge : std::span(mergesOf(p)).subspan(this->Lists.Of(p).taken))
        {
          visit(merge.error);
        }
      }
      return {};
    },
    count);
  KDSTREAM_TRY(cheapest);
  for (std::size_t p = begin; p < end; ++p)
  {
    std::size_t& taken = this->Lists.Of(p).taken;
    taken += cheapest->Take(mergesOf(p), taken, ErrorOf);
  }
  return {};
}

// Groups by cells the clusters of nodes that still hold too many.
Status CollapseRound::GroupFullNodes()
{
  // For each node 1 if it is full; the last entry is 1 if any node is full. Integers, so that ranks
  // can add them.
  std::vector<std::uint64_t> full(this->NodeCount() + 1, 0);
  KDSTREAM_TRY(this->ForEachBlockHere(
    [&](std::size_t block) -> Status
    {
      Result<Merging> merging = this->MergingOf(block);
      KDSTREAM_TRY(merging);
      const std::vector<std::uint8_t> fullHere = FullNodes(merging->ExcessOfNodes());
      if (!fullHere.empty())
      {
        merging->GroupNodes(fullHere, this->ByComponents);
        std::transform(fullHere.begin(), fullHere.end(), full.begin(), full.begin(),
          [](std::uint8_t filled, std::uint64_t all) { return all + filled; });
        full.back() = 1;
      }
      return this->Blocks.KeepTargets(block, TargetStage::Grouped, merging->Targets());
    }));
  KDSTREAM_TRY(this->Blocks.ShareTargets(TargetStage::Grouped));
  KDSTREAM_TRY(this->Blocks.Sum(full));
  this->Full.clear();
  if (full.back() > 0)
  {
    std::transform(full.begin(), full.end() - 1, std::back_inserter(this->Full),
      [](std::uint64_t count) { return static_cast<std::uint8_t>(count > 0 ? 1 : 0); });
  }
  return {};
}

// Applies the taken merges of a block. Groups the clusters that have lost their triangles.
Result<Merging> CollapseRound::MergingOf(std::size_t block)
{
  const Result<const CollapseState*> state = this->Blocks.Load(block);
  KDSTREAM_TRY(state);
  const Result<std::vector<MergeList>*> lists = this->Blocks.Lists(block);
  KDSTREAM_TRY(lists);
  const Result<std::vector<VertexId>> ghosts = this->Blocks.GhostTargets(TargetStage::Merged);
  KDSTREAM_TRY(ghosts);
  this->Lists.FreeAllBut(block);
  Merging merging(**state, this->Depths, this->Depth);
  const std::size_t first = this->Lists.FirstOfBlock(block);
  for (std::size_t local = 0; local < this->Lists.CountOfBlock(); ++local)
  {
    const std::size_t taken = this->Lists.Of(first + local).taken;
    merging.Apply(std::span((**lists)[local].merges).first(taken));
  }
  merging.SetGhosts(*ghosts);
  merging.GroupLoose();
  return merging;
}

Status CollapseRound::Finish()
{
  return this->ForEachBlockHere(
    [&](std::size_t block) -> Status
    {
      KDSTREAM_TRY(this->FinishBlock(block));
      return this->Report(0.7 + 0.3 * double(block + 1) / double(this->Blocks.Count()));
    });
}

// Loads each block of this process and calls use(block) while the next block is being loaded.
Status CollapseRound::ForEachBlockHere(const std::function<Status(std::size_t)>& use)
{
  const BlockRange here = this->Blocks.Here();
  std::vector<std::size_t> blocks(here.end - here.begin);
  std::iota(blocks.begin(), blocks.end(), here.begin);
  return ForEachLoaded(this->Blocks, blocks, use, this->Exec);
}

Status CollapseRound::FinishBlock(std::size_t block)
{
  Result<Merging> merging = this->MergingOf(block);
  KDSTREAM_TRY(merging);
  if (!this->Full.empty())
  {
    merging->GroupNodes(this->Full, this->ByComponents);
    const Result<std::vector<VertexId>> ghosts = this->Blocks.GhostTargets(TargetStage::Grouped);
    KDSTREAM_TRY(ghosts);
    merging->SetGhosts(*ghosts);
    merging->GroupLoose(); // clusters that have lost their last triangles
  }
  const Result<const CollapseState*> state = this->Blocks.Load(block);
  KDSTREAM_TRY(state);
  std::vector<VertexId> parents;
  CollapseState coarser =
    MakeCoarser(**state, *merging, this->Space, this->How, parents, this->Exec);
  return this->Blocks.KeepCoarser(block, std::move(coarser), std::move(parents));
}

}
