// SPDX-License-Identifier: BSD-3-Clause
// Finds which edges of a piece's triangles are the two sides of the same edge of the mesh: the walk
// crosses these edges (TriangleWalk.h).
#pragma once

#include "filters/core/Types.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace kdstream
{

// Half-edge k of triangle t runs from its corner k to the next one, and has the number 4 t + k.
constexpr std::uint32_t NextHalfEdge(std::uint32_t halfEdge)
{
  return (halfEdge & 3) == 2 ? halfEdge - 2 : halfEdge + 1;
}
inline VertexId StartOfHalfEdge(std::span<const Triangle> triangles, std::uint32_t halfEdge)
{
  return triangles[halfEdge / 4][halfEdge & 3];
}

// Pairs each half-edge, in the order of their numbers, with the first unpaired one that runs the
// other way. Returns for each half-edge the number of its partner, or noVertex. Edges of degenerate
// triangles have no partner. O(triangles + vertices).
std::vector<std::uint32_t> PairEdges(std::span<const Triangle> triangles, std::size_t vertices);

}
