// SPDX-License-Identifier: BSD-3-Clause
// In how many different places the vertices of all ranks are: what the grid of a parallel build
// merges.
#pragma once

#include "filters/Parallel/MpiGroup.h"
#include "filters/core/Result.h"
#include "filters/core/Types.h"
#include "filters/outofcore/mesh/ExternalWeld.h"

#include <cstdint>
#include <functional>

namespace kdstream
{

// Joins what is equal of all ranks' places, -0.0 and 0.0 being equal, and counts what is left: by
// 64 bits of a hash, as CountPlacesExternally (PlaceCount.h). vertices: of this rank; allVertices:
// of all. placeOf: the place of a point, itself if it is empty. Memory: `memory` and what a round
// carries. Errors: InputOutput; MpiGroup's.
Result<std::uint64_t> CountPlacesCollectively(MpiGroup& group, SpillFolder& folder,
  const VertexFiles& vertices, std::uint64_t allVertices,
  const std::function<Vec3(const Vec3&)>& placeOf, std::uint64_t memory);

}
