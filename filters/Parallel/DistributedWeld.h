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

// The vertices that a rank has read and that are not removed. Numbers are consecutive from rank to
// rank, in the order of the file.
struct DistributedVertices
{
  std::vector<VertexId> readBegin; // first number in the file of each rank, and the end
  std::vector<VertexId> begin;     // first new number of each rank, and the end
  VertexFiles kept;                // the vertices that stay
  // VertexId: new number of each vertex that this rank read. Closed if all keep the numbers of the
  // file.
  SpillFile numberOf;
  std::uint64_t welded = 0; // vertices removed on all ranks

  VertexId Count() const { return this->begin.back(); }
};

// If `weld` is set, joins equal vertices as WeldVertices does (Weld.h). Numbers the vertices in any
// case.
// 1. Every vertex is sent to the rank given by the hash of its bytes (28 bytes and its tuples).
//    That rank finds the lowest number of equal ones.
// 2. That rank reports each removed vertex to the rank that has read it (8 bytes), which asks for
//    the new number (4 bytes each way).
//
// Memory: `memory` and the bytes of a round. Errors: LimitExceeded for more than 2^32 - 2 vertices;
// InvalidInput for none; InputOutput; Cancelled; those of MpiGroup.
Result<DistributedVertices> WeldCollectively(MpiGroup& group, SpillFolder& folder,
  VertexFiles share, bool weld, std::uint64_t memory, const Execution& execution);

}
