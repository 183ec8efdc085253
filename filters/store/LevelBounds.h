// SPDX-License-Identifier: BSD-3-Clause
// How far the original is from each level at most: step "store" of the pipeline picture. For
// StoreWriter alone.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/Result.h"
#include "filters/model/ModelDescription.h"

#include <cstdint>
#include <functional>
#include <vector>

namespace kdstream
{

// Of each level an upper bound of the distance of every point of the original's surface from the
// level's surface, in model units. A level's surface is its triangles as they are decoded; of a
// level without triangles, its vertices. So parts of the original that have no triangle in a level
// count.
//
// model: what a store says of its model once all pieces are written. read: the blob of a piece; any
// number of threads may call it, several at once.
//
// Where the search ends in time, the bound is a little above the true maximum. Else it is above by
// as much as the radius of a ball around some triangles: the search visits a number of boxes and
// triangles of the level that grows with the triangles of the original, and no more. The figures
// are the same for any number of threads.
//
// No bound is below four times the distance between vertices that are spread over half the surface
// of the model's box: to tell less of a smooth surface takes a search for each vertex and level.
//
// wholeVertices: a level with more is searched piece by piece, around each partition alone.
// Complexity: O(vertices levels); decodes every piece once, rarely more often. Memory: a batch of
// partitions, a piece of each large level, and all of the small ones.
// Errors: those of `read` and DecodePiece; Cancelled.
Result<std::vector<double>> BoundLevels(const ModelDescription& model,
  const std::function<Result<std::vector<std::uint8_t>>(PieceId)>& read,
  const Execution& execution = {}, std::uint64_t wholeVertices = std::uint64_t{ 1 } << 16);

}
