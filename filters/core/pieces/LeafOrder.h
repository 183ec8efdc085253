// SPDX-License-Identifier: BSD-3-Clause
// The order of the original vertices inside a finest cluster: step "number" of the pipeline
// picture.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/pieces/VertexTree.h"

#include <span>

namespace kdstream
{

// Sorts vertices by place: ascending x, then y, then z. Vertices in the same place are sorted by
// their numbers, which must differ. points: of all vertices.
void SortByPlace(std::span<VertexId> vertices, std::span<const Vec3> points);

// Numbers the vertices of each cluster of the finest level by place (SortByPlace). The codec
// (filters/codec/PieceNumbering.h) sorts them again, so that their order costs no bytes. The
// intervals of clusters do not change. A tree without levels is not changed: its vertices keep
// their order by id. points: of the original mesh. O(n log n of the largest cluster); clusters in
// parallel.
void OrderLeaves(VertexTree& tree, std::span<const Vec3> points, const Execution& execution = {});

}
