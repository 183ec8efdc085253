// Which triangles touch which cell: the join that most later steps start from.
#pragma once

#include "filters/core/Types.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace kdstream
{

// For each bucket the triangles that touch one of its vertices, ascending; a triangle is in one to
// three buckets.
struct TriangleBuckets
{
  std::vector<std::size_t> begin; // one entry a bucket, and the end
  std::vector<std::uint32_t> triangles;

  std::span<const std::uint32_t> Of(std::size_t bucket) const
  {
    return { this->triangles.data() + this->begin[bucket],
      this->triangles.data() + this->begin[bucket + 1] };
  }
};

// Sorts triangles into the buckets of their vertices: bucketOf(v) < buckets for every vertex v.
// O(triangles); memory 4 bytes an entry.
template <class BucketOf>
TriangleBuckets BucketTriangles(
  std::span<const Triangle> triangles, std::size_t buckets, const BucketOf& bucketOf)
{
  const auto visit = [&](const Triangle& t, const auto& add)
  {
    const std::size_t a = bucketOf(t[0]), b = bucketOf(t[1]), c = bucketOf(t[2]);
    add(a);
    if (b != a)
    {
      add(b);
    }
    if (c != a && c != b)
    {
      add(c);
    }
  };
  TriangleBuckets result;
  result.begin.assign(buckets + 1, 0);
  for (const Triangle& t : triangles)
  {
    visit(t, [&](std::size_t bucket) { ++result.begin[bucket + 1]; });
  }
  for (std::size_t i = 0; i < buckets; ++i)
  {
    result.begin[i + 1] += result.begin[i];
  }
  result.triangles.resize(result.begin[buckets]);
  std::vector<std::size_t> next(result.begin.begin(), result.begin.end() - 1);
  for (std::size_t i = 0; i < triangles.size(); ++i)
  {
    visit(triangles[i], [&](std::size_t bucket)
      { result.triangles[next[bucket]++] = static_cast<std::uint32_t>(i); });
  }
  return result;
}

}
