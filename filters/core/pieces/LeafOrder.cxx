// SPDX-License-Identifier: BSD-3-Clause
#include "filters/core/pieces/LeafOrder.h"

#include <algorithm>

namespace kdstream
{

void SortByPlace(std::span<VertexId> vertices, std::span<const Vec3> points)
{
  // All numbers differ, so no stable sort is needed.
  std::sort(vertices.begin(), vertices.end(),
    [&](VertexId a, VertexId b) { return points[a] != points[b] ? points[a] < points[b] : a < b; });
}

void OrderLeaves(VertexTree& tree, std::span<const Vec3> points, const Execution& execution)
{
  if (tree.levels.empty())
  {
    return;
  }
  constexpr std::size_t grain = 1 << 12; // clusters
  const std::vector<VertexId>& first = tree.levels.back().first;
  execution.parallelFor(first.size(), grain,
    [&](std::size_t begin, std::size_t end)
    {
      for (std::size_t cluster = begin; cluster < end; ++cluster)
      {
        const std::size_t last =
          cluster + 1 < first.size() ? first[cluster + 1] : tree.original.size();
        SortByPlace({ tree.original.data() + first[cluster], tree.original.data() + last }, points);
      }
    });
}

}
