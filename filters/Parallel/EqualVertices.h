// SPDX-License-Identifier: BSD-3-Clause
// Finds equal vertices of several ranks: the search of step "weld" of a parallel build.
#pragma once

#include "filters/Parallel/MpiGroup.h"
#include "filters/core/Execution.h"
#include "filters/core/Result.h"
#include "filters/core/Types.h"
#include "filters/outofcore/files/SpillFile.h"
#include "filters/outofcore/mesh/ExternalWeld.h"

#include <cstdint>

namespace kdstream
{

// A vertex that is removed, and the lowest vertex that equals it.
struct WeldedVertex
{
  VertexId vertex, lowest;
};

// The equal vertices that a rank has found, in no order.
struct WeldedVertexFile
{
  SpillFile file; // WeldedVertex
  std::uint64_t count = 0;
};

// Every vertex is sent to the rank given by the hash of its bytes, and put into a bucket there;
// each bucket is processed separately. share: this rank's vertices, numbered from `first` on;
// allVertices: number on all ranks. Memory: `memory` and the bytes of a round. Errors: InputOutput;
// Cancelled; those of MpiGroup.
Result<WeldedVertexFile> FindEqualVertices(MpiGroup& group, SpillFolder& folder,
  const VertexFiles& share, VertexId first, std::uint64_t allVertices, std::uint64_t memory,
  const Execution& execution);

}
