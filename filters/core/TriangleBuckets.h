// SPDX-License-Identifier: BSD-3-Clause
// Finds which triangles touch which cell: step "faces" of the pipeline picture, from which later
// steps start.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/Types.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace kdstream
{

// For each bucket the triangles that touch one of its vertices, ascending (but see GatherMesh). A
// triangle is in one to three buckets.
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

// Sorts triangles into the buckets of their vertices: bucketOf(v) < buckets for every vertex v;
// several threads may call it. The result does not depend on the number of threads. O(triangles +
// buckets); memory 4 bytes an entry, and temporarily at most 1 byte a triangle and 4 a bucket.
template <class BucketOf>
TriangleBuckets BucketTriangles(std::span<const Triangle> triangles, std::size_t buckets,
  const BucketOf& bucketOf, const Execution& execution = {})
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
  // Counts each chunk of triangles separately. The counts of all chunks before a chunk say where
  // its triangles go.
  const std::size_t chunk = std::max(std::size_t{ 1 } << 17, 4 * buckets);
  const std::size_t chunks = (triangles.size() + chunk - 1) / chunk;
  std::vector<std::uint32_t> counts(chunks * buckets, 0);
  const auto forEachChunk = [&](const auto& body)
  {
    execution.parallelFor(chunks, 1,
      [&](std::size_t begin, std::size_t end)
      {
        for (std::size_t c = begin; c < end; ++c)
        {
          body(c * chunk, std::min(triangles.size(), (c + 1) * chunk), &counts[c * buckets]);
        }
      });
  };
  forEachChunk(
    [&](std::size_t begin, std::size_t end, std::uint32_t* count)
    {
      for (std::size_t i = begin; i < end; ++i)
      {
        visit(triangles[i], [&](std::size_t bucket) { ++count[bucket]; });
      }
    });
  TriangleBuckets result;
  result.begin.assign(buckets + 1, 0);
  for (std::size_t bucket = 0; bucket < buckets; ++bucket)
  {
    std::size_t size = 0;
    for (std::size_t c = 0; c < chunks; ++c)
    {
      const std::uint32_t own = counts[c * buckets + bucket];
      counts[c * buckets + bucket] = static_cast<std::uint32_t>(size);
      size += own;
    }
    result.begin[bucket + 1] = result.begin[bucket] + size;
  }
  result.triangles.resize(result.begin[buckets]);
  forEachChunk(
    [&](std::size_t begin, std::size_t end, std::uint32_t* next)
    {
      for (std::size_t i = begin; i < end; ++i)
      {
        visit(triangles[i],
          [&](std::size_t bucket) {
            result.triangles[result.begin[bucket] + next[bucket]++] = static_cast<std::uint32_t>(i);
          });
      }
    });
  return result;
}

}
