// SPDX-License-Identifier: BSD-3-Clause
// Step "weld" of a parallel build: equal vertices become one, even if different ranks have read
// them. For DistributedBuilder.
#pragma once

#include "filters/Parallel/MpiGroup.h"
#include "filters/core/Execution.h"
#include "filters/outofcore/mesh/ExternalWeld.h"

#include <cstdint>
#include <vector>

namespace kdstream
{

// A rank's share of the vertices, those that it has read and that stay. Their numbers follow each
// other from rank to rank, in the file's order.
struct DistributedVertices
{
  std::vector<VertexId> readBegin; // of each rank the first number in the file, and the end
  std::vector<VertexId> begin;     // of each rank the first number now, and the end
  VertexFiles kept;                // the vertices that stay
  SpillFile numberOf; // VertexId: of each vertex that was read here the number now; closed where
                      // all have the file's numbers
  std::uint64_t welded = 0; // how many went, of all ranks

  VertexId Count() const { return this->begin.back(); }
};

// Joins equal vertices as WeldVertices does (Weld.h), if `weld` is set, and numbers the vertices.
// 1. Every vertex goes to the rank of its bytes' hash (28 bytes and its tuples). That rank finds
//    the lowest number of equal ones.
// 2. That rank reports each joined vertex to the rank that has read it (8 bytes), which asks for
//    the new number (4 bytes there and back).
//
// Memory: `memory` and the bytes of a round. Errors: LimitExceeded for more than 2^32 - 2 vertices;
// InvalidInput for none; InputOutput; Cancelled; MpiGroup's.
Result<DistributedVertices> WeldCollectively(MpiGroup& group, SpillFolder& folder,
  VertexFiles share, bool weld, std::uint64_t memory, const Execution& execution);

}
