// SPDX-License-Identifier: BSD-3-Clause
// Counting of edges: see EdgeCount.h.
#include "filters/core/EdgeCount.h"

#include "filters/core/MixBits.h"
#include "filters/core/TriangleBuckets.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <vector>

namespace kdstream
{
namespace
{

using Counts = std::function<bool(VertexId)>;

// For each vertex, the hashes of the numbers at the other ends of its edges are added up, with the
// sign of the edge's direction. The sum is 0 if every edge is used equally often in both
// directions.
std::uint64_t Hash(VertexId v)
{
  return MixBits(v + std::uint64_t{ 1 }); // 0 would count as no edge
}

struct DirectedEdge
{
  VertexId low, high;
  int direction;
};

// Collects the edges whose lower end is a vertex of [first, first + sums.size()) that counts and
// has unbalanced edges. touching: the numbers of all triangles that touch these vertices.
void CollectUnbalanced(std::span<const Triangle> triangles, std::span<const std::uint32_t> touching,
  VertexId first, std::vector<std::uint64_t>& sums, std::vector<DirectedEdge>& edges,
  const Counts& counts)
{
  const auto isOwn = [&](VertexId v) { return v >= first && v - first < sums.size(); };
  for (const std::uint32_t t : touching)
  {
    const Triangle& triangle = triangles[t];
    if (IsDegenerate(triangle))
    {
      continue;
    }
    const std::array<std::uint64_t, 3> hashed{ Hash(triangle[0]), Hash(triangle[1]),
      Hash(triangle[2]) };
    for (std::size_t k = 0; k < 3; ++k)
    {
      if (isOwn(triangle[k]))
      {
        sums[triangle[k] - first] += hashed[(k + 1) % 3] - hashed[(k + 2) % 3];
      }
    }
  }
  edges.clear();
  for (std::size_t i = 0; counts && i < sums.size(); ++i)
  {
    // A vertex that does not count may have triangles that are not in this mesh.
    sums[i] = counts(static_cast<VertexId>(first + i)) ? sums[i] : 0;
  }
  if (std::all_of(sums.begin(), sums.end(), [](std::uint64_t sum) { return sum == 0; }))
  {
    return;
  }
  for (const std::uint32_t t : touching)
  {
    const Triangle& triangle = triangles[t];
    for (std::size_t k = 0; k < 3 && !IsDegenerate(triangle); ++k)
    {
      const VertexId from = triangle[k], to = triangle[(k + 1) % 3], low = std::min(from, to);
      if (isOwn(low) && sums[low - first] != 0)
      {
        edges.push_back({ low, std::max(from, to), from < to ? 1 : -1 });
      }
    }
  }
}

// Counts the edges that are used more than once, but not equally often in both directions.
std::size_t CountUneven(std::vector<DirectedEdge>& edges)
{
  std::sort(edges.begin(), edges.end(),
    [](const DirectedEdge& x, const DirectedEdge& y)
    { return x.low != y.low ? x.low < y.low : x.high < y.high; });
  std::size_t count = 0;
  for (std::size_t i = 0; i < edges.size();)
  {
    std::size_t j = i;
    int sum = 0;
    for (; j < edges.size() && edges[j].low == edges[i].low && edges[j].high == edges[i].high; ++j)
    {
      sum += edges[j].direction;
    }
    count += j - i > 1 && sum != 0;
    i = j;
  }
  return count;
}

}

std::size_t CountInconsistentEdges(std::span<const Triangle> triangles, std::size_t vertices,
  const Execution& execution, const Counts& counts)
{
  constexpr std::size_t block =
    1 << 12; // vertices: an edge is counted in the block of its lower end
  const std::size_t blocks = (vertices + block - 1) / block;
  const TriangleBuckets buckets = BucketTriangles(
    triangles, blocks, [](VertexId v) { return v / block; }, execution);
  std::vector<std::size_t> uneven(blocks, 0);
  execution.parallelFor(blocks, 1,
    [&](std::size_t begin, std::size_t end)
    {
      std::vector<std::uint64_t> sums;
      std::vector<DirectedEdge> edges;
      for (std::size_t b = begin; b < end; ++b)
      {
        sums.assign(std::min(block, vertices - b * block), 0);
        CollectUnbalanced(
          triangles, buckets.Of(b), static_cast<VertexId>(b * block), sums, edges, counts);
        uneven[b] = CountUneven(edges);
      }
    });
  return std::accumulate(uneven.begin(), uneven.end(), std::size_t{ 0 });
}

}
