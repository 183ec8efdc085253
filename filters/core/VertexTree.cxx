// Numbering of the vertex tree and counting of edges: see VertexTree.h.
//   1. Depth-first ranks of all clusters from level 0 down, children by lowest original vertex.
//   2. Original vertices in that order, those of a finest cluster by id; then partition by
//   partition.
//   3. Every level in the order of its clusters' lowest numbered vertices.
#include "filters/core/VertexTree.h"

#include <algorithm>
#include <numeric>

namespace kdstream
{
namespace
{

// Stable counting sort of `items` by key(item) < keys.
template <class Key>
std::vector<VertexId> SortByKey(const std::vector<VertexId>& items, std::size_t keys,
  const Key& key, std::vector<VertexId>* begin = nullptr)
{
  std::vector<VertexId> next(keys + 1, 0);
  for (const VertexId item : items)
  {
    ++next[key(item) + 1];
  }
  std::partial_sum(next.begin(), next.end(), next.begin());
  if (begin)
  {
    *begin = next;
  }
  std::vector<VertexId> sorted(items.size());
  for (const VertexId item : items)
  {
    sorted[next[key(item)]++] = item;
  }
  return sorted;
}

// Depth-first ranks of the clusters of one level, given those of the level above.
std::vector<VertexId> RankLevel(
  const ClusterLevel& level, const std::vector<VertexId>& ranksAbove, bool coarsest)
{
  std::vector<VertexId> order(level.lowest.size());
  std::iota(order.begin(), order.end(), VertexId{ 0 });
  const auto byLowest = [&](VertexId a, VertexId b) { return level.lowest[a] < level.lowest[b]; };
  if (coarsest)
  {
    std::sort(order.begin(), order.end(), byLowest);
  }
  else
  {
    std::vector<VertexId> begin;
    order = SortByKey(
      order, ranksAbove.size(), [&](VertexId c) { return ranksAbove[level.parents[c]]; }, &begin);
    for (std::size_t above = 0; above < ranksAbove.size(); ++above)
    {
      std::sort(order.data() + begin[above], order.data() + begin[above + 1], byLowest);
    }
  }
  std::vector<VertexId> ranks(order.size());
  for (std::size_t i = 0; i < order.size(); ++i)
  {
    ranks[order[i]] = static_cast<VertexId>(i);
  }
  return ranks;
}

template <class T>
std::vector<T> Permute(const std::vector<T>& values, const std::vector<VertexId>& order)
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
  permuted.values.reserve(values.values.size());
  for (const VertexId tuple : order)
  {
    permuted.Append(values, tuple);
  }
  return permuted;
}

// Moves a level into the order of its clusters' first numbered vertices. rankAbove: new places one
// level up, or empty. Returns the new place of each cluster.
std::vector<VertexId> OrderLevel(ClusterLevel&& level, const std::vector<VertexId>& first,
  const std::vector<VertexId>& placesAbove, VertexTreeLevel& ordered, const Execution& execution)
{
  std::vector<std::uint64_t> sorted(first.size()); // (first vertex, cluster)
  for (std::size_t i = 0; i < first.size(); ++i)
  {
    sorted[i] = std::uint64_t{ first[i] } << 32 | i;
  }
  std::sort(sorted.begin(), sorted.end());
  std::vector<VertexId> order(first.size());
  std::transform(sorted.begin(), sorted.end(), order.begin(),
    [](std::uint64_t entry) { return static_cast<VertexId>(entry); });
  std::vector<VertexId> places(order.size());
  for (std::size_t i = 0; i < order.size(); ++i)
  {
    places[order[i]] = static_cast<VertexId>(i);
  }
  ordered.first = Permute(first, order);
  ordered.positions = Permute(level.positions, order);
  ordered.deviations = Permute(level.deviations, order);
  for (const Attribute& attribute : level.attributes)
  {
    ordered.attributes.push_back(Permute(attribute, order));
  }
  if (!placesAbove.empty())
  {
    ordered.parents.resize(order.size());
    for (std::size_t i = 0; i < order.size(); ++i)
    {
      ordered.parents[i] = placesAbove[level.parents[order[i]]];
    }
  }
  ordered.triangles = std::move(level.triangles);
  execution.parallelFor(ordered.triangles.size(), 1 << 14,
    [&](std::size_t begin, std::size_t end)
    {
      for (std::size_t i = begin; i < end; ++i)
      {
        Triangle& t = ordered.triangles[i];
        t = RotateLowestFirst({ places[t[0]], places[t[1]], places[t[2]] });
      }
    });
  SortTriangles(ordered.triangles, order.size(), false, execution);
  return places;
}

// For each cluster of each level its lowest numbered vertex.
std::vector<std::vector<VertexId>> FirstVertices(
  const ClusterLevels& levels, const std::vector<VertexId>& original)
{
  std::vector<std::vector<VertexId>> first(levels.levels.size());
  first.back().assign(levels.levels.back().lowest.size(), noVertex);
  for (std::size_t i = 0; i < original.size(); ++i)
  {
    VertexId& lowest = first.back()[levels.finest[original[i]]];
    lowest = std::min(lowest, static_cast<VertexId>(i));
  }
  for (std::size_t d = levels.levels.size() - 1; d-- > 0;)
  {
    first[d].assign(levels.levels[d].lowest.size(), noVertex);
    for (std::size_t i = 0; i < first[d + 1].size(); ++i)
    {
      VertexId& lowest = first[d][levels.levels[d + 1].parents[i]];
      lowest = std::min(lowest, first[d + 1][i]);
    }
  }
  return first;
}

}

std::uint32_t VertexTree::PartitionOf(VertexId numbered) const
{
  const auto above =
    std::upper_bound(this->partitionBegin.begin(), this->partitionBegin.end(), numbered);
  return static_cast<std::uint32_t>(above - this->partitionBegin.begin()) - 1;
}

VertexKey VertexTree::KeyOf(VertexId numbered) const
{
  const std::uint32_t partition = this->PartitionOf(numbered);
  return MakeKey(partition, numbered - this->partitionBegin[partition]);
}

VertexId VertexTree::ClusterAt(unsigned depth, VertexId numbered) const
{
  const std::vector<VertexId>& first = this->levels[depth].first;
  return static_cast<VertexId>(
           std::upper_bound(first.begin(), first.end(), numbered) - first.begin()) -
         1;
}

VertexTree NumberVertices(const KdTree& tree, ClusterLevels levels, const Execution& execution)
{
  VertexTree numbered;
  numbered.depths = tree.depths;
  if (levels.levels.empty())
  {
    numbered.original = tree.order;
    numbered.partitionBegin = tree.cellBegin;
    return numbered;
  }

  std::vector<VertexId> ranks;
  for (std::size_t d = 0; d < levels.levels.size(); ++d)
  {
    ranks = RankLevel(levels.levels[d], ranks, d == 0);
  }
  std::vector<VertexId> vertices(tree.order.size());
  std::iota(vertices.begin(), vertices.end(), VertexId{ 0 });
  vertices = SortByKey(vertices, ranks.size(), [&](VertexId v) { return ranks[levels.finest[v]]; });
  const std::vector<std::uint32_t> partition = CellOfVertex(tree, tree.depths.partition);
  numbered.original = SortByKey(
    vertices, std::size_t{ 1 } << tree.depths.partition, [&](VertexId v) { return partition[v]; },
    &numbered.partitionBegin);

  const std::vector<std::vector<VertexId>> first = FirstVertices(levels, numbered.original);
  numbered.levels.resize(levels.levels.size());
  std::vector<VertexId> places;
  for (std::size_t d = 0; d < levels.levels.size(); ++d)
  {
    places =
      OrderLevel(std::move(levels.levels[d]), first[d], places, numbered.levels[d], execution);
  }
  return numbered;
}

namespace
{

// How unevenly the edges around a vertex are used: of each directed edge from or to it the other
// end's number, scattered. 0 where every edge is used as often in one direction as in the other.
std::uint64_t Scatter(VertexId v)
{
  std::uint64_t x = (v + std::uint64_t{ 1 }) * 0x9E3779B97F4A7C15U;
  x = (x ^ (x >> 32)) * 0xD6E8FEB86659FD93U;
  return x ^ (x >> 32);
}

struct DirectedEdge
{
  VertexId low, high;
  int direction;
};

bool IsDegenerate(const Triangle& t)
{
  return t[0] == t[1] || t[1] == t[2] || t[2] == t[0];
}

// The edges whose lower end is one of the vertices [first, first + sums.size()) and has not all of
// its edges in balance. `triangles`: all that touch these vertices.
void CollectUnbalanced(std::span<const Triangle> triangles, std::span<const std::uint32_t> touching,
  VertexId first, std::vector<std::uint64_t>& sums, std::vector<DirectedEdge>& edges)
{
  const auto isOwn = [&](VertexId v) { return v >= first && v - first < sums.size(); };
  for (const std::uint32_t t : touching)
  {
    const Triangle& triangle = triangles[t];
    for (std::size_t k = 0; k < 3 && !IsDegenerate(triangle); ++k)
    {
      if (isOwn(triangle[k]))
      {
        sums[triangle[k] - first] +=
          Scatter(triangle[(k + 1) % 3]) - Scatter(triangle[(k + 2) % 3]);
      }
    }
  }
  edges.clear();
  if (std::all_of(sums.begin(), sums.end(), [](std::uint64_t sum) { return sum == 0; }))
  {
    return;
  }
  for (const std::uint32_t t : touching)
  {
    const Triangle& triangle = triangles[t];
    for (std::size_t k = 0; k < 3 && !IsDegenerate(triangle); ++k)
    {
      const VertexId from = triangle[k], to = triangle[(k + 1) % 3], low = std::min(from, to);
      if (isOwn(low) && sums[low - first] != 0)
      {
        edges.push_back({ low, std::max(from, to), from < to ? 1 : -1 });
      }
    }
  }
}

// Edges that are used more than once, and not equally often in both directions.
std::size_t CountUneven(std::vector<DirectedEdge>& edges)
{
  std::sort(edges.begin(), edges.end(),
    [](const DirectedEdge& x, const DirectedEdge& y)
    { return x.low != y.low ? x.low < y.low : x.high < y.high; });
  std::size_t count = 0;
  for (std::size_t i = 0; i < edges.size();)
  {
    std::size_t j = i;
    int sum = 0;
    for (; j < edges.size() && edges[j].low == edges[i].low && edges[j].high == edges[i].high; ++j)
    {
      sum += edges[j].direction;
    }
    count += j - i > 1 && sum != 0;
    i = j;
  }
  return count;
}

}

std::size_t CountInconsistentEdges(
  std::span<const Triangle> triangles, std::size_t vertices, const Execution& execution)
{
  constexpr std::size_t block =
    1 << 12; // vertices: an edge is counted in the block of its lower end
  const std::size_t blocks = (vertices + block - 1) / block;
  const TriangleBuckets buckets = BucketTriangles(
    triangles, blocks, [](VertexId v) { return v / block; }, execution);
  std::vector<std::size_t> counts(blocks, 0);
  execution.parallelFor(blocks, 1,
    [&](std::size_t begin, std::size_t end)
    {
      std::vector<std::uint64_t> sums;
      std::vector<DirectedEdge> edges;
      for (std::size_t b = begin; b < end; ++b)
      {
        sums.assign(std::min(block, vertices - b * block), 0);
        CollectUnbalanced(triangles, buckets.Of(b), static_cast<VertexId>(b * block), sums, edges);
        counts[b] = CountUneven(edges);
      }
    });
  return std::accumulate(counts.begin(), counts.end(), std::size_t{ 0 });
}

}
