// SPDX-License-Identifier: BSD-3-Clause
// The largest extent of a mesh: one rule for all trees, clusterings and stores.
#pragma once

#include "filters/core/Result.h"
#include "filters/core/Types.h"

namespace kdstream
{

// The longest side of a mesh's box, in model units: 2^127, about 1.7e38. Up to this size no number
// overflows while levels are made, so an enlarged mesh gets the same levels, enlarged:
//   - geometric errors are stored as floats, at most the box's diagonal: sqrt(3) × 2^127 is below
//     the greatest float, 2^128;
//   - the check whether a collapse turns a normal compares squares of products of areas
//     (MergedStar): eighth powers of lengths, at most 9 × 2^(8 × 127) = 2^1019.2, and doubles reach
//     2^1024;
//   - the minimum of a quadric (Quadric.h) takes the third power of its weight, an area, times a
//     length. A weight is at most 10 × 2^254 a triangle, for its area and its boundary edges: up to
//     2^41 triangles, each as long as the box, can come together in one cluster.
inline constexpr double mostExtent = 0x1p127;

// Errors: InvalidInput, naming the axis, if a side is longer than mostExtent.
Status CheckExtent(const Box& box);

}
