// SPDX-License-Identifier: BSD-3-Clause
#include "filters/core/levels/MergeThreshold.h"

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

namespace kdstream
{

Result<double> MergeThreshold::Estimate(std::size_t stride)
{
  const Result<CheapestErrors> cheapest =
    this->FindCheapestOf(stride, this->CountToTake(stride) + 1);
  KDSTREAM_TRY(cheapest);
  return cheapest->error;
}

// A list can leave out merges that cost more than its last one. If the last one is not above the
// threshold, lists are completed, and the threshold is found again.
Status MergeThreshold::Take(const std::function<Status(double)>& report)
{
  std::size_t count = this->CountToTake(1);
  if (count == 0)
  {
    return {};
  }
  Result<CheapestErrors> cheapest = this->FindCheapestOf(1, count);
  KDSTREAM_TRY(cheapest);
  const bool complete = std::all_of(this->Lists.All().begin(), this->Lists.All().end(),
    [&](const ListSummary& list) { return list.whole || list.last > cheapest->error; });
  if (!complete)
  {
    KDSTREAM_TRY(this->Lists.Make(
      [&](std::size_t part) { return !this->Lists.Of(part).whole; }, everyError, report));
    count = this->CountToTake(1);
    if (count == 0)
    {
      return {};
    }
    cheapest = this->FindCheapestOf(1, count);
    KDSTREAM_TRY(cheapest);
  }
  KDSTREAM_TRY(this->LeaveTies(*cheapest));
  KDSTREAM_TRY(this->Lists.ForEachBlock(
    [&](std::size_t block, std::vector<MergeList>& lists) -> Status
    {
      for (std::size_t local = 0; local < lists.size(); ++local)
      {
        this->Lists.Of(this->Lists.FirstOfBlock(block) + local).taken =
          cheapest->Take(lists[local].merges, 0, ErrorOf);
      }
      return {};
    }));
  return this->Lists.Share();
}

// The number of merges of the parts 0, stride … that leave the wanted number of clusters. A part
// that is stuck with more clusters than its share keeps them, and other parts do not compensate for
// it.
std::size_t MergeThreshold::CountToTake(std::size_t stride) const
{
  const std::size_t share = this->Surface / this->Lists.Count();
  std::size_t now = 0, wanted = this->Surface / stride;
  for (std::size_t p = 0; p < this->Lists.Count(); p += stride)
  {
    const ListSummary& list = this->Lists.Of(p);
    now += list.own;
    const std::size_t least = list.own - std::min(list.own, list.merges);
    wanted += list.stuck && least > share ? least - share : 0;
  }
  return now - std::min(now, wanted);
}

// The cheapest `count` merges of the parts 0, stride …; all if there are fewer.
Result<CheapestErrors> MergeThreshold::FindCheapestOf(std::size_t stride, std::size_t count)
{
  std::size_t all = 0;
  for (std::size_t p = 0; p < this->Lists.Count(); p += stride)
  {
    all += this->Lists.Of(p).merges;
  }
  if (count > all)
  {
    return CheapestErrors{ everyError, 0 };
  }
  const auto forEachError = [&](const auto& visit) -> Status
  {
    return this->Lists.ForEachBlock(
      [&](std::size_t block, const std::vector<MergeList>& lists) -> Status
      {
        for (std::size_t local = 0; local < lists.size(); ++local)
        {
          if ((this->Lists.FirstOfBlock(block) + local) % stride == 0)
          {
            for (const Merge& merge : lists[local].merges)
            {
              visit(merge.error);
            }
          }
        }
        return {};
      });
  };
  return FindCheapest(
    forEachError, count, [&](std::span<std::uint64_t> bins) { return this->Blocks.Sum(bins); });
}

// Merges whose error equals the threshold are taken in the order of the parts. So ties in parts of
// earlier processes are left to those processes.
Status MergeThreshold::LeaveTies(CheapestErrors& cheapest)
{
  if (this->Blocks.Alone())
  {
    return {};
  }
  std::vector<std::uint64_t> ties(this->Blocks.Count(), 0);
  KDSTREAM_TRY(this->Lists.ForEachBlock(
    [&](std::size_t block, const std::vector<MergeList>& lists) -> Status
    {
      for (const MergeList& list : lists)
      {
        ties[block] += static_cast<std::uint64_t>(std::count_if(list.merges.begin(),
          list.merges.end(), [&](const Merge& merge) { return merge.error == cheapest.error; }));
      }
      return {};
    }));
  KDSTREAM_TRY(this->Blocks.Sum(ties));
  for (std::size_t block = 0; block < this->Blocks.Here().begin; ++block)
  {
    cheapest.ties -= std::min(cheapest.ties, ties[block]);
  }
  return {};
}

}
