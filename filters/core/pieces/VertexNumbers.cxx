// SPDX-License-Identifier: BSD-3-Clause
// Numbering from the top down: see VertexNumbers.h.
#include "filters/core/pieces/VertexNumbers.h"

#include "filters/core/RadixSort.h"
#include "filters/core/SortTriangles.h"
#include "filters/core/pieces/LeafOrder.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace kdstream
{
namespace
{

// The clusters of a level, parent by parent, siblings by place.
struct Siblings
{
  std::vector<VertexId> clusters;
  std::vector<VertexId> begin; // one entry a parent, and the end

  std::span<VertexId> Of(std::size_t parent)
  {
    return { this->clusters.data() + this->begin[parent],
      this->clusters.data() + this->begin[parent + 1] };
  }
};

// Whether cluster a comes before b: ordered by place, then by lowest original vertex.
bool IsBefore(const ClusterParents& level, VertexId a, VertexId b)
{
  return level.positions[a] != level.positions[b] ? level.positions[a] < level.positions[b]
                                                  : level.lowest[a] < level.lowest[b];
}

Siblings GroupSiblings(const ClusterParents& level, std::size_t parents, const Execution& execution)
{
  constexpr std::size_t grain = 1 << 12; // parents
  Siblings siblings;
  // Shifted by one parent: at first where each parent's next cluster goes; in the end, where each
  // parent's clusters begin.
  std::vector<VertexId> next(parents + 2, 0);
  for (const VertexId parent : level.parents)
  {
    ++next[parent + std::size_t{ 2 }];
  }
  std::partial_sum(next.begin(), next.end(), next.begin());
  siblings.clusters.resize(level.parents.size());
  for (std::size_t i = 0; i < level.parents.size(); ++i)
  {
    siblings.clusters[next[level.parents[i] + std::size_t{ 1 }]++] = static_cast<VertexId>(i);
  }
  next.pop_back();
  siblings.begin = std::move(next);
  execution.parallelFor(parents, grain,
    [&](std::size_t begin, std::size_t end)
    {
      for (std::size_t parent = begin; parent < end; ++parent)
      {
        const std::span<VertexId> some = siblings.Of(parent);
        std::sort(
          some.begin(), some.end(), [&](VertexId a, VertexId b) { return IsBefore(level, a, b); });
      }
    });
  return siblings;
}

// The partition of each cluster, where clusters are ordered by partition.
std::vector<VertexId> PartitionsOf(
  std::span<const VertexId> counts, std::span<const VertexId> partitionBegin)
{
  std::vector<VertexId> partitions(counts.size());
  VertexId partition = 0, vertices = partitionBegin.front();
  for (std::size_t cluster = 0; cluster < counts.size(); ++cluster)
  {
    while (partition + 2 < partitionBegin.size() && vertices >= partitionBegin[partition + 1])
    {
      ++partition;
    }
    partitions[cluster] = partition;
    vertices += counts[cluster];
  }
  return partitions;
}

template <class T>
std::vector<T> Permute(std::span<const T> values, const std::vector<VertexId>& order)
{
  std::vector<T> permuted(order.size());
  for (std::size_t i = 0; i < order.size(); ++i)
  {
    permuted[i] = values[order[i]];
  }
  return permuted;
}

Attribute Permute(const Attribute& values, const std::vector<VertexId>& order)
{
  Attribute permuted{ values.Info(), {} };
  permuted.values.reserve(order.size() * values.TupleSize());
  for (const VertexId tuple : order)
  {
    permuted.Append(values, tuple);
  }
  return permuted;
}

}

std::vector<VertexId> OrderByKey(std::span<const VertexId> keys)
{
  std::vector<std::uint64_t> sorted(keys.size());
  for (std::size_t i = 0; i < keys.size(); ++i)
  {
    sorted[i] = std::uint64_t{ keys[i] } << 32 | i;
  }
  SortByUpperHalf(sorted);
  std::vector<VertexId> order(keys.size());
  std::transform(sorted.begin(), sorted.end(), order.begin(),
    [](std::uint64_t entry) { return static_cast<VertexId>(entry); });
  return order;
}

std::vector<VertexId> FirstOfStitch(const ClusterParents& level, std::span<const VertexId> counts,
  std::span<const VertexId> partitionBegin)
{
  const std::vector<VertexId> partitions = PartitionsOf(counts, partitionBegin);
  std::vector<VertexId> order(counts.size());
  std::iota(order.begin(), order.end(), VertexId{ 0 });
  std::sort(order.begin(), order.end(),
    [&](VertexId a, VertexId b) {
      return partitions[a] != partitions[b] ? partitions[a] < partitions[b] : IsBefore(level, a, b);
    });
  std::vector<VertexId> first(order.size());
  VertexId next = partitionBegin.front();
  for (const VertexId cluster : order)
  {
    first[cluster] = next;
    next += counts[cluster];
  }
  return first;
}

void LowerFirst(std::span<const VertexId> parents, std::span<const VertexId> first,
  std::span<VertexId> firstOfParents)
{
  for (std::size_t i = 0; i < parents.size(); ++i)
  {
    VertexId& lowest = firstOfParents[parents[i]];
    lowest = std::min(lowest, first[i]);
  }
}

std::vector<ChildNode> ChildNodesOfParents(const VertexTree& tree, unsigned depth,
  std::span<const VertexId> first, std::span<const VertexId> parents)
{
  std::vector<ChildNode> childNodes;
  childNodes.reserve(parents.size());
  for (std::size_t i = 0; i < parents.size(); ++i)
  {
    const std::uint32_t partition = tree.PartitionOf(first[i]);
    childNodes.push_back(
      { parents[i], PieceOfPartition(Resolution::Level(depth), partition, tree.depths).node });
  }
  std::sort(childNodes.begin(), childNodes.end());
  childNodes.erase(std::unique(childNodes.begin(), childNodes.end()), childNodes.end());
  return childNodes;
}

std::vector<std::vector<VertexId>> FirstOfCoarseClusters(std::span<const ClusterParents> levels,
  std::span<const VertexId> counts, std::span<const VertexId> partitionBegin)
{
  std::vector<std::vector<VertexId>> first(levels.size());
  first.back() = FirstOfStitch(levels.back(), counts, partitionBegin);
  for (std::size_t d = levels.size() - 1; d-- > 0;)
  {
    first[d].assign(levels[d].lowest.size(), noVertex);
    LowerFirst(levels[d + 1].parents, first[d + 1], first[d]);
  }
  return first;
}

std::vector<VertexId> FirstOfChildren(const ClusterParents& level, std::span<const VertexId> counts,
  std::span<const VertexId> firstOfParents, const Execution& execution)
{
  Siblings siblings = GroupSiblings(level, firstOfParents.size(), execution);
  std::vector<VertexId> first(level.lowest.size());
  for (std::size_t parent = 0; parent < firstOfParents.size(); ++parent)
  {
    VertexId next = firstOfParents[parent];
    for (const VertexId cluster : siblings.Of(parent))
    {
      first[cluster] = next;
      next += counts[cluster];
    }
  }
  return first;
}

std::vector<VertexId> OrderVertices(std::span<const VertexId> clusterOf,
  std::span<const VertexId> first, VertexId begin, std::span<const Vec3> points,
  const Execution& execution)
{
  constexpr std::size_t grain = 1 << 12; // clusters
  std::vector<VertexId> order(clusterOf.size() - static_cast<std::size_t>(std::count(
                                                   clusterOf.begin(), clusterOf.end(), noVertex)));
  std::vector<VertexId> next(first.begin(), first.end());
  for (std::size_t v = 0; v < clusterOf.size(); ++v)
  {
    if (clusterOf[v] != noVertex)
    {
      order[next[clusterOf[v]]++ - begin] = static_cast<VertexId>(v);
    }
  }
  if (points.empty())
  {
    return order;
  }
  execution.parallelFor(first.size(), grain,
    [&](std::size_t from, std::size_t to)
    {
      for (std::size_t cluster = from; cluster < to; ++cluster)
      {
        SortByPlace(
          { order.data() + (first[cluster] - begin), order.data() + (next[cluster] - begin) },
          points);
      }
    });
  return order;
}

OrderedLevel OrderLevel(ClusterLevel level, std::span<const VertexId> first,
  std::span<const VertexId> placesAbove, const Execution& execution)
{
  const std::vector<VertexId> order = OrderByKey(first);
  OrderedLevel ordered;
  ordered.places.resize(order.size());
  for (std::size_t i = 0; i < order.size(); ++i)
  {
    ordered.places[order[i]] = static_cast<VertexId>(i);
  }
  VertexTreeLevel& result = ordered.level;
  result.first = Permute(first, order);
  result.positions = Permute(std::span<const Vec3>(level.positions), order);
  result.geometricErrors = Permute(std::span<const double>(level.geometricErrors), order);
  for (const Attribute& attribute : level.attributes)
  {
    result.attributes.push_back(Permute(attribute, order));
  }
  if (!placesAbove.empty())
  {
    result.parents.resize(order.size());
    for (std::size_t i = 0; i < order.size(); ++i)
    {
      result.parents[i] = placesAbove[level.parents[order[i]]];
    }
  }
  result.triangles = std::move(level.triangles);
  execution.parallelFor(result.triangles.size(), 1 << 14,
    [&](std::size_t begin, std::size_t end)
    {
      for (std::size_t i = begin; i < end; ++i)
      {
        Triangle& t = result.triangles[i];
        t = RotateLowestFirst({ ordered.places[t[0]], ordered.places[t[1]], ordered.places[t[2]] });
      }
    });
  SortTriangles(result.triangles, order.size(), false, execution);
  return ordered;
}

void NumberPart(VertexTree& tree, std::span<const VertexId> numbers)
{
  tree.original = OrderByKey(numbers);
  tree.numbers = Permute(numbers, tree.original);
}

}
