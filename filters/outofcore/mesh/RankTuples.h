// SPDX-License-Identifier: BSD-3-Clause
// Puts the tuples of vertex attributes into the order of the tree, out of core: step "faces" of
// building.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/Result.h"
#include "filters/outofcore/files/SpillFile.h"
#include "filters/outofcore/mesh/VertexMap.h"

#include <cstddef>
#include <cstdint>

namespace kdstream
{

// Returns a file of the tuples in the order of ranks, so that those of a block are one interval.
// tuples: tupleBytes for each vertex, by id (VertexFiles). ranks: from RankVertices. If the ranks
// fit in half of the memory, this takes one pass over the tuples. Otherwise the tuples are also
// written and read once, as buckets of ranks. Peak memory: `memory` and a few blocks. Disk: a copy
// of the tuples, and while it runs another one with the ranks. Errors: InputOutput; Cancelled.
// REQUIRES: tupleBytes > 0.
Result<SpillFile> SortTuplesByRank(SpillFolder& folder, const SpillFile& tuples,
  std::size_t tupleBytes, const VertexMap& ranks, std::uint64_t memory,
  const Execution& execution = {});

}
