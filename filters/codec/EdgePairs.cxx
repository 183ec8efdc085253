// SPDX-License-Identifier: BSD-3-Clause
#include "filters/codec/EdgePairs.h"

#include "filters/codec/TriangleWalk.h"

#include <algorithm>
#include <memory>

namespace kdstream
{

// 1. Sort the half-edges by their lower vertex: half-edges between the same two vertices are then
//    near each other.
// 2. Go through the half-edges of each lower vertex. A half-edge without a partner waits in the
//    list of its higher vertex; a half-edge in the other direction takes the first of that list.
std::vector<std::uint32_t> PairEdges(std::span<const Triangle> triangles, std::size_t vertices)
{
  constexpr std::uint32_t none = noVertex;
  std::vector<std::uint32_t> opposite(4 * triangles.size(), none);
  const auto forEachHalfEdge = [triangles](const auto& visit)
  {
    for (std::uint32_t t = 0; t < triangles.size(); ++t)
    {
      const Triangle& corners = triangles[t];
      if (!IsDegenerate(corners))
      {
        visit(4 * t, corners[0], corners[1]);
        visit(4 * t + 1, corners[1], corners[2]);
        visit(4 * t + 2, corners[2], corners[0]);
      }
    }
  };
  std::vector<std::uint32_t> begin(vertices + 2);
  forEachHalfEdge(
    [&](std::uint32_t, VertexId from, VertexId to) { ++begin[std::min(from, to) + 2]; });
  for (std::size_t v = 2; v < begin.size(); ++v)
  {
    begin[v] += begin[v - 1];
  }
  struct HalfEdge
  {
    std::uint32_t number;
    VertexId higher;
    bool upward;
  };
  const std::size_t count = begin.back();
  // Not initialized; neither are the arrays below.
  const std::unique_ptr<HalfEdge[]> sorted(new HalfEdge[count]);
  forEachHalfEdge(
    [&](std::uint32_t number, VertexId from, VertexId to) {
      sorted[begin[std::min(from, to) + 1]++] = { number, std::max(from, to), from < to };
    });

  // For each higher vertex, the list of waiting half-edges, in the order of their numbers. All
  // half-edges in a list run in the same direction.
  std::vector<std::uint32_t> first(vertices, none);
  const std::unique_ptr<std::uint32_t[]> last(new std::uint32_t[vertices]);
  const std::unique_ptr<std::uint32_t[]> next(new std::uint32_t[count]);
  for (std::size_t v = 0; v < vertices; ++v)
  {
    std::uint32_t waitingHere = 0;
    for (std::uint32_t i = begin[v]; i < begin[v + 1]; ++i)
    {
      const HalfEdge edge = sorted[i];
      std::uint32_t& waiting = first[edge.higher];
      if (waiting != none && sorted[waiting].upward != edge.upward)
      {
        opposite[edge.number] = sorted[waiting].number;
        opposite[sorted[waiting].number] = edge.number;
        waiting = next[waiting];
        --waitingHere;
        continue;
      }
      next[i] = none;
      (waiting == none ? waiting : next[last[edge.higher]]) = i;
      last[edge.higher] = i;
      ++waitingHere;
    }
    for (std::uint32_t i = begin[v]; waitingHere > 0 && i < begin[v + 1]; ++i)
    {
      first[sorted[i].higher] = none;
    }
  }
  return opposite;
}

}
