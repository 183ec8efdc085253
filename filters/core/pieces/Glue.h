// SPDX-License-Identifier: BSD-3-Clause
// Glues partitions back together: the original mesh, or a region of it, from its pieces
// (doc/design.md#nothing-lost).
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/Result.h"
#include "filters/core/pieces/Piece.h"

#include <span>

namespace kdstream
{

// The mesh of some partitions of the original. Points: the partitions' own vertices, in the order
// given, then the ghosts that no given partition owns. Triangles: each one once, including
// degenerate and duplicate triangles of the input; each is taken from the lowest given partition
// that owns one of its vertices. Gluing all partitions gives the original mesh. The drawing rule is
// different: it drops duplicates. The arrays are glued too, with a tuple for each of these vertices
// or triangles. O(size log partitions + ghosts log ghosts). Errors: InvalidArgument if a piece is
// not of the original, or is given twice; InvalidInput if a ghost names a vertex that its partition
// does not have, or if partitions have different arrays; Cancelled. Reports the step "glue".
Result<Mesh> GluePartitions(
  std::span<const Piece> partitions, ScalarType scalarType, const Execution& execution = {});

}
