// SPDX-License-Identifier: BSD-3-Clause
// Counts the edges at which a mesh is not consistently oriented; a build warns of them.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/Types.h"

#include <cstddef>
#include <functional>
#include <span>

namespace kdstream
{

// Counts the edges that more than one triangle uses, but not equally often in both directions. At
// these edges the input is inconsistently oriented or non-manifold, and doc/design.md#no-cracks
// does not hold. counts(v): whether to count the edges whose lower-numbered end is v; if the
// function is empty, all edges count. Several threads may call it. It lets a mesh be counted in
// parts that number their vertices in the same order. The sum is right if every vertex counts in
// exactly one part, and that part has all triangles at the vertex. O(t log t), in parallel over
// vertices.
std::size_t CountInconsistentEdges(std::span<const Triangle> triangles, std::size_t vertices,
  const Execution& execution = {}, const std::function<bool(VertexId)>& counts = {});

}
