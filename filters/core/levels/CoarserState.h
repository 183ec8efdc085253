// SPDX-License-Identifier: BSD-3-Clause
// The last step of a round from one level to the next coarser one, after it is decided which
// clusters merge (Merging.h): makes the new clusters, their places, sums and parents. Only for the
// makers of levels (CollapseRound, CollapseLevels), block by block.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/levels/CollapseState.h"
#include "filters/core/levels/Merging.h"

#include <vector>

namespace kdstream
{

// The own clusters of the coarser level, without triangles: one for each cluster that remains, by
// (cell of the coarser depth, lowest original vertex), summed over their children in order.
// parents: for each own cluster of `below` its place among them. O(c log c).
CollapseState MakeCoarser(const CollapseState& below, const Merging& merging,
  const CollapseSpace& space, Representative representative, std::vector<VertexId>& parents,
  const Execution& execution);

}
