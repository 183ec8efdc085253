// SPDX-License-Identifier: BSD-3-Clause
// The last step of a round from one level to the next coarser one, when it is decided which
// clusters merge (Merging.h): makes the new clusters, with positions, sums and parents. Only for
// the makers of levels (CollapseRound, CollapseLevels), block by block.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/levels/CollapseState.h"
#include "filters/core/levels/Merging.h"

#include <vector>

namespace kdstream
{

// Makes the own clusters of the coarser level, without triangles: one for each cluster that
// remains, ordered by (cell of the coarser depth, lowest original vertex). Sums go over children in
// their order. parents: for each own cluster of `below` the place of its parent in the result. O(c
// log c).
CollapseState MakeCoarser(const CollapseState& below, const Merging& merging,
  const CollapseSpace& space, Representative representative, std::vector<VertexId>& parents,
  const Execution& execution);

}
