#include "filters/core/TriangleBuckets.h"

namespace kdstream
{

bool AreScattered(std::span<const Triangle> triangles, std::span<const std::uint32_t> bucketOf)
{
  constexpr std::size_t samples = 4096;
  if (triangles.size() < 2 * samples)
  {
    return false; // all of them are in the cache
  }
  std::size_t jumps = 0;
  for (std::size_t i = 0; i < samples; ++i)
  {
    const std::size_t t = (triangles.size() - 2) / samples * i;
    jumps += bucketOf[triangles[t][0]] != bucketOf[triangles[t + 1][0]];
  }
  return jumps > samples / 2;
}

void GatherTriangles(std::vector<Triangle>& triangles, TriangleBuckets& buckets,
  std::span<const std::uint32_t> bucketOf, const Execution& execution)
{
  const std::size_t count = buckets.begin.size() - 1;
  const auto forEachBucket = [&](const auto& visit)
  {
    execution.parallelFor(count, 1,
      [&](std::size_t begin, std::size_t end)
      {
        for (std::size_t b = begin; b < end; ++b)
        {
          visit(b, std::span(buckets.triangles)
                     .subspan(buckets.begin[b], buckets.begin[b + 1] - buckets.begin[b]));
        }
      });
  };
  const auto owns = [&](std::size_t b, std::uint32_t t)
  {
    const Triangle& triangle = triangles[t];
    return std::min({ bucketOf[triangle[0]], bucketOf[triangle[1]], bucketOf[triangle[2]] }) == b;
  };
  std::vector<std::size_t> ownBegin(count + 1, 0);
  forEachBucket(
    [&](std::size_t b, std::span<std::uint32_t> entries)
    {
      ownBegin[b + 1] = static_cast<std::size_t>(
        std::count_if(entries.begin(), entries.end(), [&](std::uint32_t t) { return owns(b, t); }));
    });
  for (std::size_t b = 0; b < count; ++b)
  {
    ownBegin[b + 1] += ownBegin[b];
  }
  std::vector<Triangle> gathered(triangles.size());
  std::vector<std::uint32_t> number(triangles.size()); // the new one of each
  forEachBucket(
    [&](std::size_t b, std::span<std::uint32_t> entries)
    {
      std::size_t next = ownBegin[b];
      for (const std::uint32_t t : entries)
      {
        if (owns(b, t))
        {
          number[t] = static_cast<std::uint32_t>(next);
          gathered[next++] = triangles[t];
        }
      }
    });
  triangles = std::move(gathered);
  forEachBucket(
    [&](std::size_t, std::span<std::uint32_t> entries)
    {
      for (std::uint32_t& t : entries)
      {
        t = number[t];
      }
    });
}

}
