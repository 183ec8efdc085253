// SPDX-License-Identifier: BSD-3-Clause
// Counts the distinct places of the vertices of all ranks. From this follows how many vertices the
// grid of a parallel build merges.
#pragma once

#include "filters/Parallel/MpiGroup.h"
#include "filters/core/Result.h"
#include "filters/core/Types.h"
#include "filters/outofcore/mesh/ExternalWeld.h"

#include <cstdint>
#include <functional>

namespace kdstream
{

// Counts the distinct places of the vertices of all ranks (-0.0 and 0.0 are equal), by a 64-bit
// hash, as CountPlacesExternally does (PlaceCount.h). vertices: of this rank; allVertices: of all
// ranks. placeOf: maps a point to its place; empty: the point itself. Memory: `memory` and the
// bytes of a round. Errors: InputOutput; those of MpiGroup.
Result<std::uint64_t> CountPlacesCollectively(MpiGroup& group, SpillFolder& folder,
  const VertexFiles& vertices, std::uint64_t allVertices,
  const std::function<Vec3(const Vec3&)>& placeOf, std::uint64_t memory);

}
