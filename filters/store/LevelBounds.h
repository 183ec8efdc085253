// SPDX-License-Identifier: BSD-3-Clause
// An upper bound of the original's distance from each level: step "store" of the pipeline picture.
// Only for StoreWriter.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/Result.h"
#include "filters/model/ModelDescription.h"

#include <cstdint>
#include <functional>
#include <vector>

namespace kdstream
{

// For each level, an upper bound of the distance from any point of the original's surface to the
// level's surface, in model units. A level's surface is its decoded triangles, or its vertices if
// it has no triangles. So parts of the original for which a level has no triangle count too.
//
// model: the store's description after all pieces were written. read: returns the blob of a piece;
// several threads may call it at the same time.
//
// If the search finishes, the bound is a little above the true maximum. The number of boxes and
// triangles that the search visits is limited in proportion to the original's triangles. If the
// limit is reached, the bound is larger by up to the radius of a ball around some triangles. The
// figures are the same for any number of threads.
//
// No bound is below four times the distance between vertices spread over half the surface of the
// model's box. A smaller bound for a smooth surface would need a search for each vertex and level.
//
// wholeVertices: a level with more vertices is searched piece by piece, only around each partition.
// Complexity: O(vertices levels); decodes every piece once, rarely more often. Memory: a batch of
// partitions, a piece of each large level, and all small levels. Errors: those of `read` and
// DecodePiece; Cancelled.
Result<std::vector<double>> BoundLevels(const ModelDescription& model,
  const std::function<Result<std::vector<std::uint8_t>>(PieceId)>& read,
  const Execution& execution = {}, std::uint64_t wholeVertices = std::uint64_t{ 1 } << 16);

}
