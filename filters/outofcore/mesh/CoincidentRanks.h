// SPDX-License-Identifier: BSD-3-Clause
// Finds vertices in the same place, in a mesh that does not fit in memory: step "levels" of
// building out of core.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/Types.h"
#include "filters/core/tree/PointRecord.h"
#include "filters/outofcore/files/SpillFile.h"

#include <cstdint>
#include <functional>

namespace kdstream
{

// Calls visit(a, b) for ranks a < b of vertices in the same place (-0.0 equals 0.0) with no third
// one between them in the order of the leaves. So the vertices of a place form a chain, as in core
// (FinestClusters.h). Calls come in any order. records: of a tree, `count` of them. One pass over
// the records; if the places do not fit in memory, the records are also written and read once. Peak
// memory: `memory` and two blocks, for any input. Errors: InputOutput; those of `visit`.
template <class Scalar>
Status ForEachCoincidentPair(SpillFolder& folder, const SpillFile& records, std::uint32_t count,
  std::uint64_t memory, const std::function<Status(VertexId, VertexId)>& visit);

extern template Status ForEachCoincidentPair<float>(SpillFolder&, const SpillFile&, std::uint32_t,
  std::uint64_t, const std::function<Status(VertexId, VertexId)>&);
extern template Status ForEachCoincidentPair<double>(SpillFolder&, const SpillFile&, std::uint32_t,
  std::uint64_t, const std::function<Status(VertexId, VertexId)>&);

}
