// SPDX-License-Identifier: BSD-3-Clause
// A block of the next coarser level from a block of a level and what merges in it. For the makers
// of levels alone.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/levels/CollapseState.h"
#include "filters/core/levels/Merging.h"

#include <vector>

namespace kdstream
{

// The own clusters, without triangles: those that stand, by (cell of the coarser depth, lowest
// original vertex), added up over their children in order. parents: for each own cluster of `below`
// its place among them. O(c log c).
CollapseState MakeCoarser(const CollapseState& below, const Merging& merging,
  const CollapseSpace& space, Representative representative, std::vector<VertexId>& parents,
  const Execution& execution);

}
