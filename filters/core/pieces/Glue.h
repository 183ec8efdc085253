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

// The mesh of some partitions of the original: their own vertices, in the order given, then the
// ghosts that no given partition owns; every triangle once, degenerate and duplicate ones of the
// input too. A triangle is taken from the lowest given partition that owns one of its vertices.
// Gluing all partitions gives the original mesh. This is not the drawing rule, which would drop
// duplicates. The arrays are glued, too: a tuple for each of these vertices and triangles. O(size
// log partitions + ghosts log ghosts). Errors: InvalidArgument for a piece that is not of the
// original or given twice; InvalidInput where a ghost names a vertex that its partition does not
// have, or where partitions have different arrays; Cancelled. Reports the step "glue".
Result<Mesh> GluePartitions(
  std::span<const Piece> partitions, ScalarType scalarType, const Execution& execution = {});

}
