// SPDX-License-Identifier: BSD-3-Clause
// Levels by clustering: see ClusterLevels.h.
//   1. The finest level: FinestClusters.h.
//   2. The pairs of clusters that only collapsed triangles link.
//   3. Each coarser level in the same way from the level below it: ClusterRound.h.
#include "filters/core/levels/ClusterLevels.h"

#include "filters/core/levels/ClusterRound.h"
#include "filters/core/levels/FinestClusters.h"

#include <algorithm>

namespace kdstream
{

Result<ClusterLevels> BuildClusterLevels(std::span<const Vec3> points,
  std::span<const Triangle> triangles, const KdTree& tree,
  const TriangleBuckets& partitionTriangles, const ClusterOptions& options,
  const Execution& execution)
{
  const ClusterRules rules{ options, tree.depths.finest, CentreOf(tree.boxes[1]) };
  Result<FinestClusters> finest = BuildFinestClusters(
    { points, triangles, tree, partitionTriangles, rules.origin, options.ids }, options, execution);
  KDSTREAM_TRY(finest);
  CollapseState state;
  state.level = std::move(finest->level);
  state.level.triangles = ImageInPartitions(
    triangles, partitionTriangles, finest->clusterOf, finest->partitionBegin, execution);
  state.clusters = std::move(finest->clusters);
  state.cellOf = std::move(finest->cellOf);
  state.ownEnd = static_cast<VertexId>(state.clusters.size());
  Result<std::vector<ClusterLevel>> levels = BuildCoarserClusterLevels(std::move(state),
    ImageOfLinks(triangles, finest->coincident, finest->clusterOf), rules.finest, rules, execution);
  KDSTREAM_TRY(levels);
  return ClusterLevels{ std::move(finest->clusterOf), std::move(*levels) };
}

std::vector<Triangle> ImageInPartitions(std::span<const Triangle> triangles,
  const TriangleBuckets& buckets, std::span<const VertexId> map, std::span<const VertexId> mapBegin,
  const Execution& execution)
{
  // A triangle of the image is made in the partition of its lowest vertex; partitions follow each
  // other in the list.
  const std::size_t partitions = buckets.begin.size() - 1;
  std::vector<std::vector<Triangle>> images(partitions);
  execution.parallelFor(partitions, 1,
    [&](std::size_t begin, std::size_t end)
    {
      std::vector<Triangle> image;
      std::vector<std::uint32_t> next;
      for (std::size_t p = begin; p < end; ++p)
      {
        image.clear();
        for (const std::uint32_t t : buckets.Of(p))
        {
          const Triangle mapped{ map[triangles[t][0]], map[triangles[t][1]], map[triangles[t][2]] };
          const VertexId lowest = std::min({ mapped[0], mapped[1], mapped[2] });
          if (mapped[0] != mapped[1] && mapped[1] != mapped[2] && mapped[2] != mapped[0] &&
              lowest >= mapBegin[p] && lowest < mapBegin[p + 1])
          {
            image.push_back(RotateLowestFirst(mapped));
          }
        }
        std::vector<Triangle>& sorted = images[p];
        sorted.resize(image.size());
        SortByTriangle(std::span<const Triangle>(image), mapBegin[p], mapBegin[p + 1] - mapBegin[p],
          std::span(sorted), next);
        sorted.erase(std::unique(sorted.begin(), sorted.end()), sorted.end());
        sorted.shrink_to_fit();
      }
    });
  std::size_t size = 0;
  for (const std::vector<Triangle>& image : images)
  {
    size += image.size();
  }
  std::vector<Triangle> all;
  all.reserve(size);
  for (std::vector<Triangle>& image : images)
  {
    all.insert(all.end(), image.begin(), image.end());
    image = {};
  }
  return all;
}

std::vector<Triangle> ImageOfTriangles(
  std::span<const Triangle> triangles, std::span<const VertexId> map, const Execution& execution)
{
  // Each chunk maps its own triangles; then all are sorted.
  constexpr std::size_t chunk = std::size_t{ 1 } << 16;
  const std::size_t chunks = (triangles.size() + chunk - 1) / chunk;
  std::vector<std::vector<Triangle>> images(chunks);
  std::vector<VertexId> highest(chunks, 0);
  execution.parallelFor(chunks, 1,
    [&](std::size_t begin, std::size_t end)
    {
      for (std::size_t i = begin; i < end; ++i)
      {
        for (const Triangle& t :
          triangles.subspan(i * chunk, std::min(chunk, triangles.size() - i * chunk)))
        {
          const Triangle mapped{ map[t[0]], map[t[1]], map[t[2]] };
          if (mapped[0] != mapped[1] && mapped[1] != mapped[2] && mapped[2] != mapped[0])
          {
            images[i].push_back(RotateLowestFirst(mapped));
            highest[i] = std::max(highest[i], images[i].back()[0]);
          }
        }
      }
    });
  std::vector<Triangle> all;
  for (std::vector<Triangle>& image : images)
  {
    all.insert(all.end(), image.begin(), image.end());
    image = {};
  }
  const VertexId most = chunks == 0 ? 0 : *std::max_element(highest.begin(), highest.end());
  SortTriangles(all, std::size_t{ most } + 1, true, execution);
  return all;
}

}
