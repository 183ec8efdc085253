// SPDX-License-Identifier: BSD-3-Clause
#include "filters/core/SortTriangles.h"

namespace kdstream
{

void SortTriangles(
  std::vector<Triangle>& triangles, std::size_t vertices, bool unique, const Execution& execution)
{
  // First vertices are sorted into blocks that are small enough for the cache. Each chunk of
  // triangles is counted separately; the counts of the chunks before it say where its triangles go.
  constexpr std::size_t block = 1 << 10, chunk = std::size_t{ 1 } << 16;
  const std::size_t blocks = vertices / block + 1;
  const std::size_t step = std::max(chunk, 2 * blocks);
  const std::size_t chunks = (triangles.size() + step - 1) / step;
  std::vector<std::uint32_t> counts(chunks * blocks, 0);
  const auto forEach = [&](const auto& visit)
  {
    execution.parallelFor(chunks, 1,
      [&](std::size_t begin, std::size_t end)
      {
        for (std::size_t c = begin; c < end; ++c)
        {
          for (std::size_t i = c * step; i < std::min(triangles.size(), (c + 1) * step); ++i)
          {
            const std::size_t b = triangles[i][0] / block;
            visit(triangles[i], b, counts[c * blocks + b]);
          }
        }
      });
  };
  forEach([](const Triangle&, std::size_t, std::uint32_t& count) { ++count; });
  std::vector<std::size_t> blockBegin(blocks + 1, 0);
  for (std::size_t b = 0; b < blocks; ++b)
  {
    std::size_t size = 0;
    for (std::size_t c = 0; c < chunks; ++c)
    {
      size += std::exchange(counts[c * blocks + b], static_cast<std::uint32_t>(size));
    }
    blockBegin[b + 1] = blockBegin[b] + size;
  }
  std::vector<Triangle> scattered(triangles.size());
  forEach([&](const Triangle& triangle, std::size_t b, std::uint32_t& next)
    { scattered[blockBegin[b] + next++] = triangle; });
  std::vector<std::size_t> kept(blocks, 0);
  execution.parallelFor(blocks, 16,
    [&](std::size_t begin, std::size_t end)
    {
      std::vector<std::uint32_t> next;
      for (std::size_t b = begin; b < end; ++b)
      {
        const std::size_t size = blockBegin[b + 1] - blockBegin[b];
        const std::span<Triangle> sorted(triangles.data() + blockBegin[b], size);
        SortByTriangle(std::span<const Triangle>(scattered.data() + blockBegin[b], size),
          static_cast<VertexId>(b * block), block, sorted, next);
        kept[b] = unique ? static_cast<std::size_t>(
                             std::unique(sorted.begin(), sorted.end()) - sorted.begin())
                         : size;
      }
    });
  std::size_t size = 0;
  for (std::size_t b = 0; b < blocks; ++b)
  {
    if (size < blockBegin[b])
    {
      std::copy_n(triangles.begin() + static_cast<std::ptrdiff_t>(blockBegin[b]), kept[b],
        triangles.begin() + static_cast<std::ptrdiff_t>(size));
    }
    size += kept[b];
  }
  triangles.resize(size);
}

}
