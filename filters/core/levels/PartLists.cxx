// SPDX-License-Identifier: BSD-3-Clause
#include "filters/core/levels/PartLists.h"

#include "filters/core/levels/ForEachLoaded.h"

#include <algorithm>

namespace kdstream
{

PartLists::PartLists(LevelBlocks& blocks, const CollapseSpace& space, std::size_t parts,
  unsigned belowPart, std::size_t share, const Execution& execution)
  : Blocks(blocks)
  , Space(space)
  , BelowPart(belowPart)
  , SharePerPart(share)
  , Exec(execution)
  , Summaries(parts)
{
}

Status PartLists::Make(
  const PartFilter& wanted, double enough, const std::function<Status(double)>& report)
{
  std::vector<std::size_t> blocks = this->BlocksWith(wanted);
  if (this->Engine && !blocks.empty() && this->EngineBlock == blocks.back())
  {
    std::reverse(blocks.begin(), blocks.end()); // the last block is already in memory
  }
  std::size_t done = 0;
  KDSTREAM_TRY(ForEachLoaded(
    this->Blocks, blocks,
    [&](std::size_t block) -> Status
    {
      KDSTREAM_TRY(this->MakeInBlock(block, wanted, enough));
      return report(double(++done) / double(blocks.size()));
    },
    this->Exec));
  return this->Share();
}

// The blocks of this process that have a wanted part.
std::vector<std::size_t> PartLists::BlocksWith(const PartFilter& wanted) const
{
  std::vector<std::size_t> blocks;
  const BlockRange here = this->Blocks.Here();
  for (std::size_t block = here.begin; block < here.end; ++block)
  {
    std::size_t part = this->FirstOfBlock(block);
    const std::size_t end = this->FirstOfBlock(block + 1);
    while (part < end && !wanted(part))
    {
      ++part;
    }
    if (part < end)
    {
      blocks.push_back(block);
    }
  }
  return blocks;
}

Status PartLists::MakeInBlock(std::size_t block, const PartFilter& wanted, double enough)
{
  const std::size_t first = this->FirstOfBlock(block), count = this->CountOfBlock();
  std::vector<std::size_t> parts; // wanted parts, counted from the block's first one
  bool anyMade = false;
  for (std::size_t local = 0; local < count; ++local)
  {
    anyMade |= this->Summaries[first + local].made;
    if (wanted(first + local))
    {
      parts.push_back(local);
    }
  }
  if (parts.empty())
  {
    return {};
  }
  KDSTREAM_TRY(this->LoadEngine(block));
  std::vector<MergeList> lists(count);
  if (anyMade)
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

Status PartLists::LoadEngine(std::size_t block)
{
  const Result<const CollapseState*> state = this->Blocks.Load(block);
  KDSTREAM_TRY(state);
  if (!this->Engine || this->EngineBlock != block)
  {
    this->Engine.reset(); // before making the next one: two at once take twice the memory
    const BlockParts parts{ this->BelowPart, this->FirstOfBlock(block), this->CountOfBlock() };
    this->Engine.emplace(
      **state, this->Space, parts, this->SharePerPart, this->Blocks.AreaPerCluster(), this->Exec);
    this->EngineBlock = block;
  }
  return {};
}

void PartLists::Summarize(std::size_t part, const MergeList& list)
{
  ListSummary& summary = this->Summaries[part];
  summary.clusters = this->Engine->ClustersOf(part - this->FirstOfBlock(this->EngineBlock));
  summary.own = list.own;
  summary.merges = static_cast<std::uint32_t>(list.merges.size());
  summary.made = true;
  summary.stuck = list.stuck;
  summary.whole = list.whole;
  summary.last = list.merges.empty() ? -1 : list.merges.back().error;
}

Status PartLists::Share()
{
  return this->Blocks.ShareParts(std::as_writable_bytes(std::span(this->Summaries)));
}

Status PartLists::ForEachBlock(const UseLists& use)
{
  const BlockRange here = this->Blocks.Here();
  for (std::size_t block = here.begin; block < here.end; ++block)
  {
    const Result<std::vector<MergeList>*> lists = this->Blocks.Lists(block);
    KDSTREAM_TRY(lists);
    KDSTREAM_TRY(use(block, **lists));
  }
  return {};
}

void PartLists::FreeAllBut(std::size_t block)
{
  if (this->EngineBlock != block)
  {
    this->Engine.reset();
  }
}

}
