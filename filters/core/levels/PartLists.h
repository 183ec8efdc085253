// SPDX-License-Identifier: BSD-3-Clause
// The merge lists of all parts of a level, in a round of collapses. The lists themselves are kept
// with the level's blocks, in memory or in files. This class keeps a summary of each list, the same
// in every process. Only for CollapseRound.
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

// Summary of a part's list.
struct ListSummary
{
  std::uint32_t clusters = 0;                      // of the part, including those without triangles
  std::uint32_t own = 0;                           // of the part, with triangles, at first
  std::uint32_t merges = 0;                        // in the list
  bool made = false, stuck = false, whole = false; // stuck, whole: as in MergeList
  double last = 0;                                 // error of the last merge; -1 if there is none
  std::size_t taken = 0;                           // how many merges, from the first on, are made
};

class PartLists
{
public:
  // Called with the merge lists of a block's parts.
  using UseLists = std::function<Status(std::size_t block, std::vector<MergeList>& lists)>;
  using PartFilter = std::function<bool(std::size_t part)>;

  // parts: the number of parts, a power of two, at least the number of blocks. belowPart: depths
  // from a part to the finest cells. share: the number of clusters with triangles that a part keeps
  // on average. Keeps references.
  PartLists(LevelBlocks& blocks, const CollapseSpace& space, std::size_t parts, unsigned belowPart,
    std::size_t share, const Execution& execution);

  std::size_t Count() const { return this->Summaries.size(); }
  std::size_t CountOfBlock() const { return this->Summaries.size() / this->Blocks.Count(); }
  std::size_t FirstOfBlock(std::size_t block) const { return block * this->CountOfBlock(); }
  ListSummary& Of(std::size_t part) { return this->Summaries[part]; }
  const ListSummary& Of(std::size_t part) const { return this->Summaries[part]; }
  const std::vector<ListSummary>& All() const { return this->Summaries; }

  // Makes the lists of the wanted parts in all blocks, and exchanges their summaries. enough: as in
  // PartCollapse::Collapse. report(done): progress, 0-1.
  Status Make(const PartFilter& wanted, double enough, const std::function<Status(double)>& report);
  // The same for only one block of this process. Does not exchange anything.
  Status MakeInBlock(std::size_t block, const PartFilter& wanted, double enough);
  // Exchanges the summaries with other processes. All processes must call it.
  Status Share();
  // Goes through the lists of this process, block by block.
  Status ForEachBlock(const UseLists& use);
  // Frees the data kept for making lists, unless they are of this block.
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
  std::optional<PartCollapse> Engine; // of the block whose lists were made last
};

}
