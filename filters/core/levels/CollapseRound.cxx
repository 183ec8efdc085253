// One round of collapses in parts: see CollapseRound.h.
//   1. Lists: some parts collapse as far as any may have to; their threshold is close to that of
//      all, and the others go a little beyond it.
//   2. Threshold: how many merges of each list are taken.
//   3. Targets: blocks tell each other where their clusters go.
//   4. Nodes that would hold too much take more merges, and what is left there is grouped by cells.
//   5. The blocks of the coarser level.
#include "filters/core/levels/CollapseRound.h"

#include "filters/core/levels/CoarserState.h"
#include "filters/core/tree/PieceDepth.h"

#include <algorithm>
#include <limits>
#include <numeric>

namespace kdstream
{
namespace
{

constexpr std::size_t sampled = 8;    // every so many parts tell where the threshold is
constexpr double beyond = 1.5;        // how far the others go above it
constexpr std::size_t mostExtra = 32; // clusters of coarse levels; measured
// Levels below S are made in parts from this one on, and where there are more clusters than such a
// level has, since no edge can collapse (thousands of small bodies): they may be too large for the
// memory. Numbers of their own, not the limit: what is stored must not depend on that.
constexpr unsigned firstInParts = 16;
constexpr std::size_t mostCollapsedFreely = (1 << firstInParts) + (1 << (firstInParts - 2));
constexpr double everything = std::numeric_limits<double>::infinity();

double ErrorOf(const Merge& merge)
{
  return merge.error;
}

}

bool CollapsesInParts(const TreeDepths& depths, unsigned depth, std::size_t finer)
{
  return depth >= depths.stitch || depth >= firstInParts || finer > mostCollapsedFreely;
}

std::size_t SurfaceWanted(unsigned depth)
{
  const std::size_t all = std::size_t{ 1 } << depth;
  return all + std::min(all, mostExtra);
}

CollapseRound::CollapseRound(LevelBlocks& blocks, const TreeDepths& depths, unsigned depth,
  const CollapseSpace& space, Representative representative, bool sheets,
  const Execution& execution, const std::function<Status(double)>& report)
  : Blocks(blocks)
  , Depths(depths)
  , Depth(depth)
  , PartDepth(
      depth >= depths.stitch ? depths.partition : PieceDepth(Resolution::Level(depth), depths))
  , Space(space)
  , How(representative)
  , Sheets(sheets)
  , Exec(execution)
  , Report(report)
  , Summaries(std::size_t{ 1 } << this->PartDepth)
{
}

Status CollapseRound::Run()
{
  const std::size_t stride = this->Summaries.size() < 4 * sampled ? 1 : sampled;
  Status status = this->Collapse(
    [&](std::size_t part) { return part % stride == 0; }, everything, 0, stride == 1 ? 0.7 : 0.1);
  if (status && stride > 1)
  {
    const std::size_t count = this->ToTake(stride) + 1;
    const Result<CheapestErrors> cheapest = this->CheapestOf(stride, count);
    KDSTREAM_TRY(cheapest);
    status = this->Collapse(
      [&](std::size_t part) { return part % stride != 0; }, beyond * cheapest->error, 0.1, 0.7);
  }
  if (status)
  {
    status = this->TakeUntil();
  }
  if (status)
  {
    status = this->KeepTargets();
  }
  if (status && this->MayOverflow())
  {
    status = this->EmptyNodes();
  }
  return status ? this->Finish() : status;
}

std::size_t CollapseRound::Share() const
{
  return SurfaceWanted(this->Depth) / this->Summaries.size();
}

// Makes the lists of the parts wanted; progress goes from `from` to `to`.
Status CollapseRound::Collapse(const PartFilter& wanted, double enough, double from, double to)
{
  const std::size_t parts = this->PartsOfBlock();
  std::vector<std::size_t> blocks;
  const BlockRange here = this->Blocks.Here();
  for (std::size_t block = here.begin; block < here.end; ++block)
  {
    std::size_t part = block * parts;
    while (part < (block + 1) * parts && !wanted(part))
    {
      ++part;
    }
    if (part < (block + 1) * parts)
    {
      blocks.push_back(block);
    }
  }
  if (this->Engine && !blocks.empty() && this->LoadedBlock == blocks.back())
  {
    std::reverse(blocks.begin(), blocks.end()); // which is in memory already
  }
  std::size_t done = 0;
  const Status status = this->ForEachLoaded(blocks,
    [&](std::size_t block)
    {
      const Status collapsed = this->CollapseBlock(block, wanted, enough);
      return collapsed ? this->Report(from + (to - from) * double(++done) / double(blocks.size()))
                       : collapsed;
    });
  return status ? this->ShareSummaries() : status;
}

// use(block) for each of these blocks, which are loaded one after the other, the next while one is
// used.
Status CollapseRound::ForEachLoaded(
  std::span<const std::size_t> blocks, const std::function<Status(std::size_t)>& use)
{
  for (std::size_t i = 0; i < blocks.size(); ++i)
  {
    Status status;
    KDSTREAM_TRY(this->Blocks.Load(blocks[i]));
    this->Exec.parallelFor(i + 1 < blocks.size() ? 2 : 1, 1,
      [&](std::size_t begin, std::size_t end)
      {
        for (std::size_t which = begin; which < end; ++which)
        {
          if (which == 0)
          {
            status = use(blocks[i]);
          }
          else
          {
            this->Blocks.LoadAhead(blocks[i + 1]);
          }
        }
      });
    KDSTREAM_TRY(status);
  }
  return {};
}

Status CollapseRound::ShareSummaries()
{
  return this->Blocks.ShareParts(std::as_writable_bytes(std::span(this->Summaries)));
}

Status CollapseRound::CollapseBlock(std::size_t block, const PartFilter& wanted, double enough)
{
  const std::size_t first = block * this->PartsOfBlock();
  std::vector<std::size_t> parts;
  bool made = false;
  for (std::size_t local = 0; local < this->PartsOfBlock(); ++local)
  {
    made |= this->Summaries[first + local].made;
    if (wanted(first + local))
    {
      parts.push_back(local);
    }
  }
  if (parts.empty())
  {
    return {};
  }
  const Result<const CollapseState*> state = this->Blocks.Load(block);
  KDSTREAM_TRY(state);
  if (!this->Engine || this->LoadedBlock != block)
  {
    this->Engine.reset();
    this->Engine.emplace(**state, this->Space,
      BlockParts{ this->Depths.finest - this->PartDepth, first, this->PartsOfBlock() },
      this->Share(), this->Blocks.AreaPerCluster(), this->Exec);
    this->LoadedBlock = block;
  }
  std::vector<MergeList> lists(this->PartsOfBlock());
  if (made)
  {
    const Result<std::vector<MergeList>*> before = this->Blocks.Lists(block);
    KDSTREAM_TRY(before);
    lists = std::move(**before);
  }
  this->Engine->Collapse(parts, enough, lists);
  for (const std::size_t local : parts)
  {
    this->Summarize(first + local, lists[local]);
  }
  return this->Blocks.KeepLists(block, std::move(lists));
}

void CollapseRound::Summarize(std::size_t part, const MergeList& list)
{
  Summary& summary = this->Summaries[part];
  const std::size_t local = part - this->LoadedBlock * this->PartsOfBlock();
  summary.clusters = this->Engine->ClustersOf(local);
  summary.own = list.own;
  summary.merges = static_cast<std::uint32_t>(list.merges.size());
  summary.made = true;
  summary.stuck = list.stuck;
  summary.whole = list.whole;
  summary.last = list.merges.empty() ? -1 : list.merges.back().error;
}

// How many merges of the parts 0, stride … leave what is wanted of them. Parts that are stuck with
// more than their share are not made up for by others.
std::size_t CollapseRound::ToTake(std::size_t stride) const
{
  std::size_t now = 0, wanted = SurfaceWanted(this->Depth) / stride;
  const std::size_t share = this->Share();
  for (std::size_t p = 0; p < this->Summaries.size(); p += stride)
  {
    const Summary& summary = this->Summaries[p];
    now += summary.own;
    const std::size_t least = summary.own - std::min(summary.own, summary.merges);
    wanted += summary.stuck && least > share ? least - share : 0;
  }
  return now - std::min(now, wanted);
}

// The cheapest `count` merges of the parts 0, stride …; everything where there are fewer.
Result<CheapestErrors> CollapseRound::CheapestOf(std::size_t stride, std::size_t count)
{
  std::size_t all = 0;
  for (std::size_t p = 0; p < this->Summaries.size(); p += stride)
  {
    all += this->Summaries[p].merges;
  }
  if (count > all)
  {
    return CheapestErrors{ everything, 0 };
  }
  return FindCheapest(
    [&](const auto& visit) -> Status
    {
      const BlockRange here = this->Blocks.Here();
      for (std::size_t block = here.begin; block < here.end; ++block)
      {
        const Result<std::vector<MergeList>*> lists = this->Blocks.Lists(block);
        KDSTREAM_TRY(lists);
        for (std::size_t local = 0; local < this->PartsOfBlock(); ++local)
        {
          const bool counts = (block * this->PartsOfBlock() + local) % stride == 0;
          for (const Merge& merge : (**lists)[local].merges)
          {
            if (counts)
            {
              visit(merge.error);
            }
          }
        }
      }
      return {};
    },
    count, [&](std::span<std::uint64_t> bins) { return this->Blocks.Sum(bins); });
}

// Takes the cheapest merges of all parts until as many clusters with triangles are left as are
// wanted. What was left out of a list costs more than its last merge: where the threshold is above
// one of these the lists are completed.
Status CollapseRound::TakeUntil()
{
  std::size_t count = this->ToTake(1);
  if (count == 0)
  {
    return {};
  }
  Result<CheapestErrors> cheapest = this->CheapestOf(1, count);
  KDSTREAM_TRY(cheapest);
  const bool complete = std::all_of(this->Summaries.begin(), this->Summaries.end(),
    [&](const Summary& summary) { return summary.whole || summary.last > cheapest->error; });
  if (!complete)
  {
    const Status status = this->Collapse(
      [&](std::size_t part) { return !this->Summaries[part].whole; }, everything, 0.7, 0.7);
    count = this->ToTake(1);
    if (!status || count == 0)
    {
      return status;
    }
    cheapest = this->CheapestOf(1, count);
    KDSTREAM_TRY(cheapest);
  }
  KDSTREAM_TRY(this->LeaveTies(*cheapest));
  const BlockRange here = this->Blocks.Here();
  for (std::size_t block = here.begin; block < here.end; ++block)
  {
    const Result<std::vector<MergeList>*> lists = this->Blocks.Lists(block);
    KDSTREAM_TRY(lists);
    for (std::size_t local = 0; local < this->PartsOfBlock(); ++local)
    {
      this->Summaries[block * this->PartsOfBlock() + local].taken =
        cheapest->Take((**lists)[local].merges, 0, ErrorOf);
    }
  }
  return this->ShareSummaries();
}

// Ties go to the parts in their order: those of other processes' parts come before ours.
Status CollapseRound::LeaveTies(CheapestErrors& cheapest)
{
  if (this->Blocks.Alone())
  {
    return {};
  }
  const BlockRange here = this->Blocks.Here();
  std::vector<std::uint64_t> ties(this->Blocks.Count(), 0);
  for (std::size_t block = here.begin; block < here.end; ++block)
  {
    const Result<std::vector<MergeList>*> lists = this->Blocks.Lists(block);
    KDSTREAM_TRY(lists);
    for (const MergeList& list : **lists)
    {
      ties[block] += static_cast<std::uint64_t>(std::count_if(list.merges.begin(),
        list.merges.end(), [&](const Merge& merge) { return merge.error == cheapest.error; }));
    }
  }
  const Status status = this->Blocks.Sum(ties);
  for (std::size_t block = 0; block < here.begin; ++block)
  {
    cheapest.ties -= std::min(cheapest.ties, ties[block]);
  }
  return status;
}

// Where clusters go by the merges that are taken, for the neighbours of each block.
Status CollapseRound::KeepTargets()
{
  if (this->Blocks.Count() == 1)
  {
    return {};
  }
  const BlockRange here = this->Blocks.Here();
  for (std::size_t block = here.begin; block < here.end; ++block)
  {
    const Result<std::vector<MergeList>*> lists = this->Blocks.Lists(block);
    KDSTREAM_TRY(lists);
    const std::size_t first = block * this->PartsOfBlock();
    std::size_t clusters = 0;
    for (std::size_t local = 0; local < this->PartsOfBlock(); ++local)
    {
      clusters += this->Summaries[first + local].clusters;
    }
    std::vector<VertexId> targets(clusters);
    std::iota(targets.begin(), targets.end(), VertexId{ 0 });
    for (std::size_t local = 0; local < this->PartsOfBlock(); ++local)
    {
      ApplyMerges(
        std::span((**lists)[local].merges).first(this->Summaries[first + local].taken), targets);
    }
    KDSTREAM_TRY(this->Blocks.KeepTargets(block, TargetStage::Merged, targets));
  }
  return this->Blocks.ShareTargets(TargetStage::Merged);
}

// Whether a node might be the home of too many clusters: those without triangles, which may be
// grouped still, are all counted. Nodes of pieces lie in one block, parts below S in one of them.
bool CollapseRound::MayOverflow() const
{
  const std::size_t nodes = std::size_t{ 1 }
                            << PieceDepth(Resolution::Level(this->Depth), this->Depths);
  const std::size_t parts = this->Summaries.size() / nodes;
  for (std::size_t node = 0; node < nodes; ++node)
  {
    std::size_t clusters = 0;
    for (std::size_t p = node * parts; p < (node + 1) * parts; ++p)
    {
      clusters += this->Summaries[p].clusters - this->Summaries[p].taken;
    }
    if (clusters > MostOfNode(this->Depths, this->Depth))
    {
      return true;
    }
  }
  return false;
}

// Of the block's nodes with excess: takes that many more merges there, if there are any.
Result<bool> CollapseRound::TakeMore(std::size_t block, const std::vector<std::size_t>& excess)
{
  const std::size_t parts = this->Summaries.size() / excess.size();
  bool more = false;
  for (std::size_t node = 0; node < excess.size(); ++node)
  {
    if (excess[node] == 0)
    {
      continue;
    }
    const std::size_t begin = node * parts, end = (node + 1) * parts;
    Status status = this->CollapseBlock(
      block,
      [&](std::size_t part) { return part >= begin && part < end && !this->Summaries[part].whole; },
      everything);
    const Result<std::vector<MergeList>*> lists = this->Blocks.Lists(block);
    if (!status || !lists)
    {
      return status ? lists.GetError() : status.GetError();
    }
    const MergeList* const own = (*lists)->data() - block * this->PartsOfBlock();
    std::size_t left = 0;
    for (std::size_t p = begin; p < end; ++p)
    {
      left += this->Summaries[p].merges - this->Summaries[p].taken;
    }
    if (left == 0)
    {
      continue;
    }
    Result<CheapestErrors> cheapest = FindCheapest(
      [&](const auto& visit) -> Status
      {
        for (std::size_t p = begin; p < end; ++p)
        {
          for (std::size_t i = this->Summaries[p].taken; i < own[p].merges.size(); ++i)
          {
            visit(own[p].merges[i].error);
          }
        }
        return {};
      },
      std::min(left, excess[node]));
    for (std::size_t p = begin; p < end; ++p)
    {
      Summary& summary = this->Summaries[p];
      summary.taken += cheapest->Take(own[p].merges, summary.taken, ErrorOf);
    }
    more = true;
  }
  return more;
}

// Nodes that would hold too much have a larger threshold of their own; where that does not do it
// their clusters are grouped by cells.
Status CollapseRound::EmptyNodes()
{
  std::uint64_t more = 0;
  const BlockRange here = this->Blocks.Here();
  for (std::size_t block = here.begin; block < here.end; ++block)
  {
    const Result<Merging> merging = this->MergingOf(block);
    const Result<bool> taken =
      merging ? this->TakeMore(block, merging->ExcessOfNodes()) : merging.GetError();
    KDSTREAM_TRY(taken);
    more += *taken ? 1 : 0;
  }
  Status shared = this->Blocks.Sum(std::span(&more, 1));
  if (shared && more > 0)
  {
    shared = this->ShareSummaries();
    shared = shared ? this->KeepTargets() : shared;
  }
  KDSTREAM_TRY(shared);
  // Of each node; one more says that there is one.
  std::vector<std::uint64_t> full(
    (std::size_t{ 1 } << PieceDepth(Resolution::Level(this->Depth), this->Depths)) + 1, 0);
  for (std::size_t block = here.begin; block < here.end; ++block)
  {
    Result<Merging> merging = this->MergingOf(block);
    KDSTREAM_TRY(merging);
    const std::vector<std::uint8_t> fullHere = FullNodes(merging->ExcessOfNodes());
    if (!fullHere.empty())
    {
      merging->GroupNodes(fullHere, this->Sheets);
      std::transform(fullHere.begin(), fullHere.end(), full.begin(), full.begin(),
        [](std::uint8_t filled, std::uint64_t all) { return all + filled; });
      full.back() = 1;
    }
    if (Status status = this->Blocks.KeepTargets(block, TargetStage::Grouped, merging->Targets());
        !status)
    {
      return status;
    }
  }
  Status status = this->Blocks.ShareTargets(TargetStage::Grouped);
  status = status ? this->Blocks.Sum(full) : status;
  this->Full.clear();
  if (full.back() > 0)
  {
    std::transform(full.begin(), full.end() - 1, std::back_inserter(this->Full),
      [](std::uint64_t count) { return static_cast<std::uint8_t>(count > 0 ? 1 : 0); });
  }
  return status;
}

// What merges in a block; clusters that have lost their triangles are grouped.
Result<Merging> CollapseRound::MergingOf(std::size_t block)
{
  const Result<const CollapseState*> state = this->Blocks.Load(block);
  const Result<std::vector<MergeList>*> lists =
    state ? this->Blocks.Lists(block) : Result<std::vector<MergeList>*>(state.GetError());
  const Result<std::vector<VertexId>> ghosts = lists
                                                 ? this->Blocks.GhostTargets(TargetStage::Merged)
                                                 : Result<std::vector<VertexId>>(lists.GetError());
  KDSTREAM_TRY(ghosts);
  if (this->LoadedBlock != block)
  {
    this->Engine.reset();
  }
  Merging merging(**state, this->Depths, this->Depth);
  for (std::size_t local = 0; local < this->PartsOfBlock(); ++local)
  {
    const Summary& summary = this->Summaries[block * this->PartsOfBlock() + local];
    merging.Apply(std::span((**lists)[local].merges).first(summary.taken));
  }
  merging.SetGhosts(*ghosts);
  merging.GroupLoose();
  return merging;
}

Status CollapseRound::Finish()
{
  const BlockRange here = this->Blocks.Here();
  std::vector<std::size_t> blocks(here.end - here.begin);
  std::iota(blocks.begin(), blocks.end(), here.begin);
  return this->ForEachLoaded(blocks,
    [&](std::size_t block)
    {
      const Status finished = this->FinishBlock(block);
      return finished ? this->Report(0.7 + 0.3 * double(block + 1) / double(this->Blocks.Count()))
                      : finished;
    });
}

Status CollapseRound::FinishBlock(std::size_t block)
{
  Result<Merging> merging = this->MergingOf(block);
  KDSTREAM_TRY(merging);
  if (!this->Full.empty())
  {
    merging->GroupNodes(this->Full, this->Sheets);
    const Result<std::vector<VertexId>> ghosts = this->Blocks.GhostTargets(TargetStage::Grouped);
    KDSTREAM_TRY(ghosts);
    merging->SetGhosts(*ghosts);
    merging->GroupLoose(); // what has lost its last triangles by that
  }
  const Result<const CollapseState*> state = this->Blocks.Load(block);
  KDSTREAM_TRY(state);
  std::vector<VertexId> parents;
  CollapseState coarser =
    MakeCoarser(**state, *merging, this->Space, this->How, parents, this->Exec);
  return this->Blocks.KeepCoarser(block, std::move(coarser), std::move(parents));
}

}
