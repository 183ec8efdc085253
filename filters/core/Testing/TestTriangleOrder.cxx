// SPDX-License-Identifier: BSD-3-Clause
// Sorting triangles, and sorting them into buckets; their ghosts; their image, partition by
// partition.
#include "filters/core/GhostCorners.h"
#include "filters/core/RadixSort.h"
#include "filters/core/SortTriangles.h"
#include "filters/core/TriangleBuckets.h"
#include "filters/core/levels/ClusterLevels.h"
#include "filters/program/TbbExecution.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>
#include <set>
#include <utility>

namespace kdstream
{
namespace
{

// Random triangles, including degenerate and duplicate ones; vertex 7 is in many of them.
std::vector<Triangle> AnyTriangles(std::size_t count, VertexId vertices, unsigned seed)
{
  std::mt19937 generator(seed);
  std::vector<Triangle> triangles;
  for (std::size_t i = 0; i < count; ++i)
  {
    const auto any = [&]() { return static_cast<VertexId>(generator() % vertices); };
    triangles.push_back({ any(), any(), i % 5 == 0 ? VertexId{ 7 } % vertices : any() });
    if (i % 11 == 0)
    {
      triangles.push_back(triangles[generator() % triangles.size()]);
    }
  }
  return triangles;
}

TEST(RotateLowestFirst, IsTheSmallestRotation)
{
  for (VertexId i = 0; i < 27; ++i)
  {
    const Triangle t{ i % 3, i / 3 % 3, i / 9 };
    const Triangle left{ t[1], t[2], t[0] }, right{ t[2], t[0], t[1] };
    EXPECT_EQ(RotateLowestFirst(t), std::min({ t, left, right })) << i;
  }
}

TEST(SortTriangles, SortsAsByComparing)
{
  for (const VertexId vertices : { 1U, 8U, 1023U, 1024U, 1025U, 50000U })
  {
    std::vector<Triangle> triangles = AnyTriangles(200000, vertices, vertices);
    std::transform(triangles.begin(), triangles.end(), triangles.begin(), RotateLowestFirst);
    std::vector<Triangle> expected = triangles;
    std::sort(expected.begin(), expected.end());
    for (const bool unique : { false, true })
    {
      if (unique)
      {
        expected.erase(std::unique(expected.begin(), expected.end()), expected.end());
      }
      for (const unsigned threads : { 1U, 3U })
      {
        std::vector<Triangle> sorted = triangles;
        SortTriangles(sorted, vertices, unique, MakeTbbExecution(threads));
        EXPECT_TRUE(sorted == expected) << vertices << " " << unique;
      }
    }
  }
  std::vector<Triangle> none;
  SortTriangles(none, 0, true);
  EXPECT_TRUE(none.empty());
}

TEST(SortByUpperHalf, KeepsTheOrderOfEqualOnes)
{
  std::mt19937_64 random(5);
  for (const std::size_t count : { 0U, 1U, 100U, 5000U, 70000U })
  {
    for (const unsigned bits : { 0U, 4U, 11U, 12U, 24U, 32U })
    {
      std::vector<std::uint64_t> entries(count);
      for (std::uint64_t& entry : entries)
      {
        entry = (bits == 0 ? 7 : random() >> (64 - bits)) << 32 | random() >> 32;
      }
      std::vector<std::uint64_t> expected = entries;
      std::stable_sort(expected.begin(), expected.end(),
        [](std::uint64_t a, std::uint64_t b) { return a >> 32 < b >> 32; });
      SortByUpperHalf(entries);
      EXPECT_EQ(entries, expected) << count << " of " << bits << " bits";
    }
  }
}

TEST(GhostCorners, AreThoseOutsideTheInterval)
{
  constexpr VertexId vertices = 3000;
  for (const std::size_t count : { 0U, 20U, 5000U })
  {
    for (const auto& [first, end] :
      { std::pair<VertexId, VertexId>{ 1000, 1400 }, { 0, vertices }, { 5, 5 }, { 0, 10 } })
    {
      std::vector<Triangle> triangles = AnyTriangles(count, vertices, 3);
      std::set<VertexId> outside;
      for (const Triangle& t : triangles)
      {
        std::copy_if(t.begin(), t.end(), std::inserter(outside, outside.end()),
          [&, first = first, end = end](VertexId v) { return v < first || v >= end; });
      }
      const GhostCorners ghosts(triangles, first, end);
      const std::vector<VertexId> found = ghosts.Vertices();
      EXPECT_EQ(found, std::vector<VertexId>(outside.begin(), outside.end()));
      std::vector<Triangle> replaced = triangles;
      ghosts.ReplaceIn(
        replaced, [&](std::size_t place) { return vertices + static_cast<VertexId>(place); });
      for (std::size_t t = 0; t < triangles.size(); ++t)
      {
        for (std::size_t k = 0; k < 3; ++k)
        {
          const VertexId v = replaced[t][k];
          ASSERT_EQ(v < vertices ? v : found[v - vertices], triangles[t][k]);
          ASSERT_EQ(v >= vertices, outside.contains(triangles[t][k]));
        }
      }
    }
  }
}

// The buckets of vertices: neighbouring ids are in the same bucket, or all in different ones.
std::vector<std::uint32_t> BucketsOf(VertexId vertices, std::uint32_t buckets, bool neighbours)
{
  std::vector<std::uint32_t> bucketOf(vertices);
  for (VertexId v = 0; v < vertices; ++v)
  {
    bucketOf[v] = neighbours ? v / (vertices / buckets + 1) : v % buckets;
  }
  return bucketOf;
}

TEST(BucketTriangles, HoldsEveryTriangleWhereItTouches)
{
  constexpr std::uint32_t buckets = 33;
  const std::vector<Triangle> triangles = AnyTriangles(400000, 5000, 1); // several chunks
  const std::vector<std::uint32_t> bucketOf = BucketsOf(5000, buckets, false);
  std::vector<std::vector<std::uint32_t>> expected(buckets);
  for (std::uint32_t t = 0; t < triangles.size(); ++t)
  {
    for (const std::uint32_t b : std::set<std::uint32_t>{
           bucketOf[triangles[t][0]], bucketOf[triangles[t][1]], bucketOf[triangles[t][2]] })
    {
      expected[b].push_back(t);
    }
  }
  for (const unsigned threads : { 1U, 3U })
  {
    const TriangleBuckets made = BucketTriangles(
      triangles, buckets, [&](VertexId v) { return bucketOf[v]; }, MakeTbbExecution(threads));
    for (std::uint32_t b = 0; b < buckets; ++b)
    {
      EXPECT_TRUE(
        std::equal(expected[b].begin(), expected[b].end(), made.Of(b).begin(), made.Of(b).end()))
        << b;
    }
  }
}

TEST(ImageInPartitions, IsTheImageOfAll)
{
  constexpr std::uint32_t partitions = 16;
  constexpr VertexId vertices = 3000;
  const std::vector<Triangle> triangles = AnyTriangles(20000, vertices, 3);
  const std::vector<std::uint32_t> partitionOf = BucketsOf(vertices, partitions, true);
  const TriangleBuckets buckets =
    BucketTriangles(triangles, partitions, [&](VertexId v) { return partitionOf[v]; });
  // Up to seven consecutive vertices of one partition become one. The new numbers of a partition's
  // vertices are an interval.
  std::vector<VertexId> map(vertices), mapBegin{ 0 };
  for (VertexId v = 0, next = 0; v < vertices; ++v)
  {
    next += v > 0 && (v % 7 == 0 || partitionOf[v] != partitionOf[v - 1]);
    map[v] = next;
    if (v + 1 == vertices || partitionOf[v + 1] != partitionOf[v])
    {
      mapBegin.push_back(next + 1);
    }
  }
  ASSERT_EQ(mapBegin.size(), partitions + 1);
  const std::vector<Triangle> expected = ImageOfTriangles(triangles, map);
  EXPECT_TRUE(ImageInPartitions(triangles, buckets, map, mapBegin) == expected);
  EXPECT_TRUE(
    ImageInPartitions(triangles, buckets, map, mapBegin, MakeTbbExecution(3)) == expected);
  std::set<Triangle> image;
  for (const Triangle& t : triangles)
  {
    if (map[t[0]] != map[t[1]] && map[t[1]] != map[t[2]] && map[t[2]] != map[t[0]])
    {
      image.insert(RotateLowestFirst({ map[t[0]], map[t[1]], map[t[2]] }));
    }
  }
  EXPECT_TRUE(std::equal(image.begin(), image.end(), expected.begin(), expected.end()));
}

}
}
