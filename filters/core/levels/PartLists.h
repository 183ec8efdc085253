// SPDX-License-Identifier: BSD-3-Clause
// The merge lists of all parts of a level, in a round of collapses. The lists themselves are with
// the level's blocks, in memory or in files. Here is what is known of each list, the same in every
// process. Only for CollapseRound.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/levels/LevelBlocks.h"
#include "filters/core/levels/PartCollapse.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

namespace kdstream
{

// What is known of a part's list.
struct ListSummary
{
  std::uint32_t clusters = 0;                      // of the part, including those without triangles
  std::uint32_t own = 0;                           // of the part, with triangles, at first
  std::uint32_t merges = 0;                        // in the list
  bool made = false, stuck = false, whole = false; // stuck, whole: as in MergeList
  double last = 0;       // error of the last merge; -1 where there is none
  std::size_t taken = 0; // how many merges, from the first, are made
};

class PartLists
{
public:
  // Called with the merge lists of a block's parts.
  using UseLists = std::function<Status(std::size_t block, std::vector<MergeList>& lists)>;
  using PartFilter = std::function<bool(std::size_t part)>;

  // parts: their number, a power of two, at least that of the blocks. belowPart: depths from a part
  // to the finest cells. share: the number of clusters with triangles that a part keeps on average.
  // Keeps references.
  PartLists(LevelBlocks& blocks, const CollapseSpace& space, std::size_t parts, unsigned belowPart,
    std::size_t share, const Execution& execution);

  std::size_t Count() const { return this->Summaries.size(); }
  std::size_t CountOfBlock() const { return this->Summaries.size() / this->Blocks.Count(); }
  std::size_t FirstOfBlock(std::size_t block) const { return block * this->CountOfBlock(); }
  ListSummary& Of(std::size_t part) { return this->Summaries[part]; }
  const ListSummary& Of(std::size_t part) const { return this->Summaries[part]; }
  const std::vector<ListSummary>& All() const { return this->Summaries; }

  // Makes the lists of the wanted parts in all blocks, and exchanges what is known of them. enough:
  // as PartCollapse::Collapse. report(done): progress, 0-1.
  Status Make(const PartFilter& wanted, double enough, const std::function<Status(double)>& report);
  // The same for only one block of this process. Does not exchange anything.
  Status MakeInBlock(std::size_t block, const PartFilter& wanted, double enough);
  // Exchanges what is known of the lists with other processes. Call it in all of them.
  Status Share();
  // Goes through the lists of this process, block by block.
  Status ForEachBlock(const UseLists& use);
  // Frees what was kept to make lists of another block.
  void FreeAllBut(std::size_t block);

private:
  std::vector<std::size_t> BlocksWith(const PartFilter& wanted) const;
  Status LoadEngine(std::size_t block);
  void Summarize(std::size_t part, const MergeList& list);

  LevelBlocks& Blocks;
  const CollapseSpace& Space;
  unsigned BelowPart;
  std::size_t SharePerPart;
  const Execution& Exec;
  std::vector<ListSummary> Summaries; // of all parts
  std::size_t EngineBlock = 0;
  std::optional<PartCollapse> Engine; // of the block that lists were made of last
};

}
