// SPDX-License-Identifier: BSD-3-Clause
// Puts the tuples of vertices' attributes into the order of the tree, out of core: step "faces" of
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

// tuples: tupleBytes for each vertex, by id (VertexFiles). Returns a file of the same tuples by
// rank, so that those of a block are one interval. ranks: RankVertices. If the ranks fit half of
// the memory: one pass over the tuples; else the tuples are written and read once more, as buckets
// of ranks. Peak memory: `memory` and a few blocks. Disk: a copy of the tuples, and another with
// the ranks while it runs. Errors: InputOutput; Cancelled. REQUIRES: tupleBytes > 0.
Result<SpillFile> SortTuplesByRank(SpillFolder& folder, const SpillFile& tuples,
  std::size_t tupleBytes, const VertexMap& ranks, std::uint64_t memory,
  const Execution& execution = {});

}
