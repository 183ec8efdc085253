// SPDX-License-Identifier: BSD-3-Clause
// The last step of a round from one level to the next coarser one: once it is decided which
// clusters merge (Merging.h), makes the new clusters, their places, sums and parents. For the
// makers of levels alone (CollapseRound, CollapseLevels), block by block.
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
