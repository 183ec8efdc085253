#include "filters/core/LeafOrder.h"

#include <algorithm>

namespace kdstream
{

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
        // Those in one place are in order of their numbers, which are unlike: no stable sort
        // needed.
        std::sort(tree.original.begin() + std::ptrdiff_t(first[cluster]),
          tree.original.begin() + std::ptrdiff_t(last),
          [&](VertexId a, VertexId b)
          { return points[a] != points[b] ? points[a] < points[b] : a < b; });
      }
    });
}

}
