// SPDX-License-Identifier: BSD-3-Clause
// Counting of the edges at which a mesh is not consistently oriented: what a build warns of.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/Types.h"

#include <cstddef>
#include <functional>
#include <span>

namespace kdstream
{

// Edges that more than one triangle uses, and not equally often in both directions: where the input
// is not consistently oriented or not manifold, doc/design.md#no-cracks does not hold.
// counts: whether edges count whose end with the lower number is this vertex; all, if it is empty.
// Called by several threads. With it a mesh can be counted in parts that number their vertices in
// the same order: the parts' counts add up where every vertex counts in one part, and that has all
// triangles which touch it. O(t log t) over vertices in parallel.
std::size_t CountInconsistentEdges(std::span<const Triangle> triangles, std::size_t vertices,
  const Execution& execution = {}, const std::function<bool(VertexId)>& counts = {});

}
