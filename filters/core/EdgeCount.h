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

// Counts the edges that more than one triangle uses, and not equally often in both directions. At
// these edges the input is inconsistently oriented or non-manifold, and doc/design.md#no-cracks
// does not hold. counts: whether edges count whose lower-numbered end is this vertex; empty: all
// do. Called by several threads. So a mesh can be counted in parts that number their vertices in
// the same order: the sum is right if every vertex counts in exactly one part, which has all
// triangles at it. O(t log t) over vertices in parallel.
std::size_t CountInconsistentEdges(std::span<const Triangle> triangles, std::size_t vertices,
  const Execution& execution = {}, const std::function<bool(VertexId)>& counts = {});

}
