// SPDX-License-Identifier: BSD-3-Clause
// One threshold for the merge lists of all parts: decides which merges a round of collapses makes.
// Only for CollapseRound.
#pragma once

#include "filters/core/collapse/MergeSelection.h"
#include "filters/core/levels/LevelBlocks.h"
#include "filters/core/levels/PartLists.h"

#include <cstddef>
#include <functional>
#include <limits>

namespace kdstream
{

// Above the error of all merges.
inline constexpr double everyError = std::numeric_limits<double>::infinity();

inline double ErrorOf(const Merge& merge)
{
  return merge.error;
}

class MergeThreshold
{
public:
  // surface: the number of clusters with triangles that the coarser level should have. Keeps
  // references.
  MergeThreshold(LevelBlocks& blocks, PartLists& lists, std::size_t surface)
    : Blocks(blocks)
    , Lists(lists)
    , Surface(surface)
  {
  }

  // Estimates the threshold from a sample, the parts 0, stride, 2 stride …: the error of the last
  // merge that is needed.
  Result<double> Estimate(std::size_t stride);
  // Takes the cheapest merges of all parts, until only the wanted number of clusters with triangles
  // is left. Extends lists that end before the threshold. report: gets the progress of that.
  Status Take(const std::function<Status(double)>& report);

private:
  std::size_t CountToTake(std::size_t stride) const;
  Result<CheapestErrors> FindCheapestOf(std::size_t stride, std::size_t count);
  Status LeaveTies(CheapestErrors& cheapest);

  LevelBlocks& Blocks;
  PartLists& Lists;
  std::size_t Surface;
};

}
