// Numbers from the top down: see VertexNumbers.h.
#include "filters/core/VertexNumbers.h"

#include "filters/core/LeafOrder.h"
#include "filters/core/RadixSort.h"
#include "filters/core/SortTriangles.h"

#include <algorithm>
#include <numeric>

namespace kdstream
{
namespace
{

// Items sorted by a key < keys, stable, and where those of each key begin.
struct Groups
{
  std::vector<VertexId> items;
  std::vector<VertexId> begin; // one entry a key, and the end

  std::span<VertexId> Of(std::size_t key)
  {
    return { this->items.data() + this->begin[key], this->items.data() + this->begin[key + 1] };
  }
};

// item(i): the i-th of `count` items. By counting.
template <class Item, class Key>
Groups GroupByKey(std::size_t count, std::size_t keys, const Item& item, const Key& key)
{
  Groups groups;
  // Shifted by one key: where the next item goes, and in the end where the following key begins.
  std::vector<VertexId> next(keys + 2, 0);
  for (std::size_t i = 0; i < count; ++i)
  {
    ++next[key(item(i)) + 2];
  }
  std::partial_sum(next.begin(), next.end(), next.begin());
  groups.items.resize(count);
  for (std::size_t i = 0; i < count; ++i)
  {
    groups.items[next[key(item(i)) + 1]++] = item(i);
  }
  next.pop_back();
  groups.begin = std::move(next);
  return groups;
}

// The clusters of a level by parent's key, siblings by lowest original vertex.
template <class Key>
Groups GroupSiblings(
  const LevelLinks& level, std::size_t parents, const Key& keyOfParent, const Execution& execution)
{
  constexpr std::size_t grain = 1 << 12; // parents
  Groups groups = GroupByKey(
    level.lowest.size(), parents, [](std::size_t i) { return static_cast<VertexId>(i); },
    [&](VertexId cluster) { return keyOfParent(level.parents[cluster]); });
  execution.parallelFor(parents, grain,
    [&](std::size_t begin, std::size_t end)
    {
      for (std::size_t parent = begin; parent < end; ++parent)
      {
        const std::span<VertexId> siblings = groups.Of(parent);
        std::sort(siblings.begin(), siblings.end(),
          [&](VertexId a, VertexId b) { return level.lowest[a] < level.lowest[b]; });
      }
    });
  return groups;
}

// The clusters of one level depth-first, given the same of the level above; none for level 0.
std::vector<VertexId> OrderDepthFirst(
  const LevelLinks& level, const std::vector<VertexId>& above, bool coarsest)
{
  if (coarsest)
  {
    std::vector<VertexId> order(level.lowest.size());
    std::iota(order.begin(), order.end(), VertexId{ 0 });
    std::sort(order.begin(), order.end(),
      [&](VertexId a, VertexId b) { return level.lowest[a] < level.lowest[b]; });
    return order;
  }
  std::vector<VertexId> ranks(above.size());
  for (std::size_t i = 0; i < above.size(); ++i)
  {
    ranks[above[i]] = static_cast<VertexId>(i);
  }
  return GroupSiblings(level, ranks.size(), [&](VertexId parent) { return ranks[parent]; }, {})
    .items;
}

// The partition of each cluster, where clusters are ordered by partition.
std::vector<VertexId> PartitionsOf(
  std::span<const VertexId> counts, std::span<const VertexId> partitionBegin)
{
  std::vector<VertexId> partitions(counts.size());
  VertexId partition = 0, vertices = 0;
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

// 0 … keys.size() - 1 in the order of their keys, which are all unlike.
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

}

std::vector<std::vector<VertexId>> FirstOfCoarseClusters(std::span<const LevelLinks> levels,
  std::span<const VertexId> counts, std::span<const VertexId> partitionBegin)
{
  std::vector<VertexId> order;
  for (std::size_t d = 0; d < levels.size(); ++d)
  {
    order = OrderDepthFirst(levels[d], order, d == 0);
  }
  const std::vector<VertexId> partitions = PartitionsOf(counts, partitionBegin);
  order = GroupByKey(
    order.size(), partitionBegin.size() - 1, [&](std::size_t i) { return order[i]; },
    [&](VertexId cluster) {
      return partitions[cluster];
    }).items;

  std::vector<std::vector<VertexId>> first(levels.size());
  first.back().resize(order.size());
  VertexId next = 0;
  for (const VertexId cluster : order)
  {
    first.back()[cluster] = next;
    next += counts[cluster];
  }
  for (std::size_t d = levels.size() - 1; d-- > 0;)
  {
    first[d].assign(levels[d].lowest.size(), noVertex);
    for (std::size_t child = 0; child < first[d + 1].size(); ++child)
    {
      VertexId& lowest = first[d][levels[d + 1].parents[child]];
      lowest = std::min(lowest, first[d + 1][child]);
    }
  }
  return first;
}

std::vector<VertexId> FirstOfChildren(const LevelLinks& level, std::span<const VertexId> counts,
  std::span<const VertexId> firstOfParents, const Execution& execution)
{
  Groups siblings = GroupSiblings(
    level, firstOfParents.size(), [](VertexId parent) { return parent; }, execution);
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
  result.deviations = Permute(std::span<const double>(level.deviations), order);
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
