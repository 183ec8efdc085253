// SPDX-License-Identifier: BSD-3-Clause
// Gathering of a mesh: see GatherMesh.h.
//   1. Renumber the vertices, partition by partition; move points and their arrays accordingly.
//   2. Replace corners by new numbers; sort triangles by the partition of the lowest corner, by
//      counting.
//   3. Make the buckets; within a bucket triangles keep their order.
#include "filters/core/tree/GatherMesh.h"

#include <algorithm>
#include <cstring>

namespace kdstream
{
namespace
{

constexpr std::size_t gatherGrain = 1 << 14;

// Calls visit(i) for 0 … count - 1, on any threads.
template <class Visit>
void ForEach(std::size_t count, std::size_t least, const Execution& execution, const Visit& visit)
{
  execution.parallelFor(count, least,
    [&](std::size_t begin, std::size_t end)
    {
      for (std::size_t i = begin; i < end; ++i)
      {
        visit(i);
      }
    });
}

// Reorders the tuples: the new i-th one is the old tuple from[i].
void MoveTuples(Attribute& array, std::span<const std::uint32_t> from, const Execution& execution)
{
  const std::size_t bytes = array.TupleSize();
  std::vector<std::uint8_t> moved(array.values.size());
  ForEach(from.size(), gatherGrain, execution,
    [&](std::size_t i)
    { std::memcpy(moved.data() + i * bytes, array.values.data() + from[i] * bytes, bytes); });
  array.values = std::move(moved);
}

class Gatherer
{
public:
  Gatherer(Mesh& mesh, KdTree& tree, const Execution& execution)
    : Input(mesh)
    , Tree(tree)
    , Exec(execution)
    , Partitions(std::size_t{ 1 } << tree.depths.partition)
    , Scale(double(this->Partitions) / double(std::max<std::size_t>(1, tree.order.size())))
  {
    const std::size_t cells = std::size_t{ 1 } << (tree.depths.finest - tree.depths.partition);
    for (std::size_t p = 0; p <= this->Partitions; ++p)
    {
      this->Begin.push_back(tree.cellBegin[p * cells]);
    }
  }

  GatheredMesh Gather()
  {
    this->MapCorners(this->NumberVertices());
    this->MoveArrays(AttributeAssociation::Point, this->Output.ids);
    const std::vector<std::uint32_t> before = this->SortTriangles();
    this->MoveArrays(AttributeAssociation::Cell, before);
    this->Output.buckets = BucketTriangles(
      this->Input.triangles, this->Partitions, [&](VertexId v) { return this->PartitionOf(v); },
      this->Exec);
    this->OrderBuckets(before);
    return std::move(this->Output);
  }

private:
  // The partition of a vertex with a new number. O(1), because sizes of partitions differ by at
  // most one.
  std::size_t PartitionOf(VertexId v) const
  {
    std::size_t p = std::min(static_cast<std::size_t>(v * this->Scale), this->Partitions - 1);
    while (this->Begin[p] > v)
    {
      --p;
    }
    while (this->Begin[p + 1] <= v)
    {
      ++p;
    }
    return p;
  }

  // Step 1. Returns the new number of each vertex.
  std::vector<VertexId> NumberVertices()
  {
    std::vector<VertexId>& ids = this->Output.ids;
    ids.resize(this->Tree.order.size());
    std::vector<VertexId> number(ids.size());
    this->Exec.parallelFor(this->Partitions, 1,
      [&](std::size_t begin, std::size_t end)
      {
        std::vector<std::uint64_t> entries; // id, place in the order of the leaves
        for (std::size_t p = begin; p < end; ++p)
        {
          entries.clear();
          for (VertexId i = this->Begin[p]; i < this->Begin[p + 1]; ++i)
          {
            entries.push_back(std::uint64_t{ this->Tree.order[i] } << 32 | i);
          }
          std::sort(entries.begin(), entries.end());
          VertexId next = this->Begin[p];
          for (const std::uint64_t entry : entries)
          {
            ids[next] = static_cast<VertexId>(entry >> 32);
            number[ids[next]] = next;
            this->Tree.order[static_cast<VertexId>(entry)] = next++;
          }
        }
      });
    std::vector<Vec3> points(ids.size());
    ForEach(points.size(), gatherGrain, this->Exec,
      [&](std::size_t i) { points[i] = this->Input.points[ids[i]]; });
    this->Input.points = std::move(points);
    return number;
  }

  void MapCorners(const std::vector<VertexId>& number)
  {
    ForEach(this->Input.triangles.size(), gatherGrain, this->Exec,
      [&](std::size_t i)
      {
        for (VertexId& corner : this->Input.triangles[i])
        {
          corner = number[corner];
        }
      });
  }

  void MoveArrays(AttributeAssociation association, std::span<const std::uint32_t> from)
  {
    for (Attribute& array : this->Input.attributes)
    {
      if (array.association == association)
      {
        MoveTuples(array, from, this->Exec);
      }
    }
  }

  // Step 2. Returns the old place of each triangle. Counts each chunk separately; the counts of all
  // chunks before a chunk say where its triangles go.
  std::vector<std::uint32_t> SortTriangles()
  {
    std::vector<Triangle>& triangles = this->Input.triangles;
    const std::size_t chunk = std::max(std::size_t{ 1 } << 17, 4 * this->Partitions);
    const std::size_t chunks = (triangles.size() + chunk - 1) / chunk;
    std::vector<std::uint32_t> next(chunks * this->Partitions, 0);
    const auto forEachInChunk = [&](const auto& visit)
    {
      ForEach(chunks, 1, this->Exec,
        [&](std::size_t c)
        {
          for (std::size_t t = c * chunk; t < std::min(triangles.size(), (c + 1) * chunk); ++t)
          {
            const Triangle& corners = triangles[t];
            const VertexId lowest = std::min({ corners[0], corners[1], corners[2] });
            visit(t, next[c * this->Partitions + this->PartitionOf(lowest)]);
          }
        });
    };
    forEachInChunk([](std::size_t, std::uint32_t& count) { ++count; });
    std::uint32_t sum = 0;
    for (std::size_t p = 0; p < this->Partitions; ++p)
    {
      for (std::size_t c = 0; c < chunks; ++c)
      {
        std::uint32_t& count = next[c * this->Partitions + p];
        sum += std::exchange(count, sum);
      }
      this->OwnEnd.push_back(sum);
    }
    std::vector<Triangle> sorted(triangles.size());
    std::vector<std::uint32_t> before(triangles.size());
    forEachInChunk(
      [&](std::size_t t, std::uint32_t& place)
      {
        sorted[place] = triangles[t];
        before[place++] = static_cast<std::uint32_t>(t);
      });
    triangles = std::move(sorted);
    return before;
  }

  // Step 3. A bucket first has the triangles that lower partitions own, then the partition's own
  // ones, which are already in order. before: the old place of each triangle.
  void OrderBuckets(std::span<const std::uint32_t> before)
  {
    TriangleBuckets& buckets = this->Output.buckets;
    const auto earlier = [&](std::uint32_t a, std::uint32_t b) { return before[a] < before[b]; };
    ForEach(this->Partitions, 1, this->Exec,
      [&](std::size_t p)
      {
        std::uint32_t* const begin = buckets.triangles.data() + buckets.begin[p];
        std::uint32_t* const end = buckets.triangles.data() + buckets.begin[p + 1];
        const std::uint32_t ownBegin = p == 0 ? 0 : this->OwnEnd[p - 1];
        std::uint32_t* const own = std::lower_bound(begin, end, ownBegin);
        std::sort(begin, own, earlier);
        std::inplace_merge(begin, own, end, earlier);
      });
  }

  Mesh& Input;
  KdTree& Tree;
  const Execution& Exec;
  std::size_t Partitions;
  double Scale;                // partitions a vertex
  std::vector<VertexId> Begin; // of each partition, and the end
  // For each partition the number of triangles that it or a lower partition owns.
  std::vector<std::uint32_t> OwnEnd;
  GatheredMesh Output;
};

}

bool IsScattered(std::span<const Triangle> triangles, std::span<const std::uint32_t> partitionOf)
{
  constexpr std::size_t samples = 4096;
  // Whether most of `count` elements are in another partition than the next element.
  const auto mostlyJumps = [&](std::size_t count, const auto& partition)
  {
    if (count < 2 * samples)
    {
      return false; // everything is in the cache
    }
    std::size_t jumps = 0;
    for (std::size_t s = 0; s < samples; ++s)
    {
      const std::size_t i = (count - 2) / samples * s;
      jumps += partition(i) != partition(i + 1);
    }
    return jumps > samples / 2;
  };
  return mostlyJumps(
           triangles.size(), [&](std::size_t t) { return partitionOf[triangles[t][0]]; }) ||
         mostlyJumps(partitionOf.size(), [&](std::size_t v) { return partitionOf[v]; });
}

GatheredMesh GatherMesh(Mesh& mesh, KdTree& tree, const Execution& execution)
{
  return Gatherer(mesh, tree, execution).Gather();
}

}
