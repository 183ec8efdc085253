// Which of a piece's numbers each vertex of the walk has. Layout: doc/formats.md, "Numbers".
//
// Own vertices are numbered so that clusters are runs of near places (DESIGN section 4), and inside
// a finest cluster by place. So their numbers fall into *groups*, runs of strictly ascending (x, y,
// z): a vertex tells its group, mostly that of a neighbour, and a group's vertices are sorted
// again. Ghosts tell their keys, mostly near those of a neighbour, and are numbered in their order.
#pragma once

#include "filters/codec/PieceContexts.h"
#include "filters/codec/TriangleWalk.h"
#include "filters/core/Piece.h"

#include <algorithm>
#include <span>
#include <vector>

namespace kdstream
{

// Sorts; few items by insertion, many by heap. Smaller than std::sort, which the page pays for.
template <class Item, class IsBefore>
void SortFew(Item* items, std::size_t count, const IsBefore& isBefore)
{
  constexpr std::size_t few = 16;
  if (count <= few)
  {
    for (std::size_t i = 1; i < count; ++i)
    {
      const Item moved = items[i];
      std::size_t place = i;
      for (; place > 0 && isBefore(moved, items[place - 1]); --place)
      {
        items[place] = items[place - 1];
      }
      items[place] = moved;
    }
    return;
  }
  // Puts items into heap order from the middle down, then takes the last out one by one.
  for (std::size_t left = count / 2, size = count; size > 1;)
  {
    if (left > 0)
    {
      --left;
    }
    else
    {
      std::swap(items[0], items[--size]);
    }
    for (std::size_t parent = left, child = 0; (child = 2 * parent + 1) < size; parent = child)
    {
      child += child + 1 < size && isBefore(items[child], items[child + 1]);
      if (!isBefore(items[parent], items[child]))
      {
        break;
      }
      std::swap(items[parent], items[child]);
    }
  }
}

// Counts, each to the sum of it and those before.
inline void SumUp(std::vector<std::uint32_t>& counts)
{
  std::uint32_t sum = 0;
  for (std::uint32_t& count : counts)
  {
    sum += count;
    count = sum;
  }
}

// The vertices of the walk, those without triangles behind it.
struct NumberedVertices
{
  std::span<const WalkVertex> vertices;
  std::span<const Vec3> positions;
  std::size_t own = 0; // of all vertices
  std::vector<std::uint32_t>
    isolated;                    // numbers of own vertices that no triangle touches, ascending
  std::vector<VertexId> numbers; // of each vertex; a reader fills it
};

// A sum modulo 2^64: differences from a file may be anything.
constexpr std::int64_t Wrapped(std::int64_t value, std::int64_t difference)
{
  return static_cast<std::int64_t>(
    static_cast<std::uint64_t>(value) + static_cast<std::uint64_t>(difference));
}

// Own vertices: codes the group of each, and finds their numbers.
template <class Coder>
bool CodeGroups(Coder& coder, NumberedVertices& numbered)
{
  const auto& vertices = numbered.vertices;
  constexpr std::uint32_t none = noVertex;
  std::vector<std::uint32_t> groups(vertices.size(), none);
  std::vector<std::uint32_t> byNumber(numbered.own, noVertex); // vertices of the walk
  if constexpr (!Coder::reading)
  {
    for (std::uint32_t v = 0; v < vertices.size(); ++v)
    {
      if (vertices[v].own)
      {
        byNumber[numbered.numbers[v]] = v;
      }
    }
    std::uint32_t group = 0;
    std::uint32_t before = noVertex;
    for (const std::uint32_t v : byNumber)
    {
      group += before != noVertex && !(numbered.positions[before] < numbered.positions[v]);
      groups[v] = group;
      before = v;
    }
  }
  std::int64_t last = 0, highest = -1;
  std::vector<std::uint32_t> begin(numbered.own + 2); // of group g at g + 1
  for (std::size_t v = 0; v < vertices.size(); ++v)
  {
    if (!vertices[v].own)
    {
      continue;
    }
    std::array<std::uint32_t, 3> near{};
    for (std::size_t k = 0; k < 3; ++k)
    {
      near[k] = v == 0 || vertices[v].gate[k] == v ? none : groups[vertices[v].gate[k]];
    }
    const std::size_t context = contexts::groupOf + (near[0] == near[1] ? 1U : 0U) +
                                (near[1] == near[2] ? 2U : 0U) + (near[0] == near[2] ? 4U : 0U);
    unsigned which = 3;
    for (unsigned k = 3; !Coder::reading && k-- > 0;)
    {
      which = near[k] == groups[v] ? k : which;
    }
    which = coder.Symbol(context, which);
    if (which < 3)
    {
      last = near[which];
    }
    else
    {
      std::int64_t reference = last;
      for (std::size_t k = 3; k-- > 0;)
      {
        reference = near[k] != none ? near[k] : reference;
      }
      last = Wrapped(
        reference, coder.Signed(contexts::groupDifference, std::int64_t{ groups[v] } - reference));
    }
    if (last < 0 || last >= std::int64_t(numbered.own))
    {
      return false;
    }
    groups[v] = static_cast<std::uint32_t>(last);
    highest = std::max(highest, last);
    ++begin[static_cast<std::size_t>(last) + 2];
  }
  if constexpr (Coder::reading)
  {
    // By group, then each group by place.
    SumUp(begin);
    for (std::uint32_t v = 0; v < vertices.size(); ++v)
    {
      if (vertices[v].own)
      {
        byNumber[begin[static_cast<std::size_t>(groups[v]) + 1]++] = v;
      }
    }
    const auto isBefore = [&](std::uint32_t v, std::uint32_t w)
    {
      return numbered.positions[v] != numbered.positions[w]
               ? numbered.positions[v] < numbered.positions[w]
               : v < w;
    };
    for (std::size_t g = 0; g < static_cast<std::size_t>(highest + 1); ++g)
    {
      SortFew(byNumber.data() + begin[g], begin[g + 1] - begin[g], isBefore);
    }
    for (std::size_t i = 0; i < numbered.own; ++i)
    {
      numbered.numbers[byNumber[i]] = static_cast<VertexId>(i);
    }
  }
  return true;
}

// Codes the keys of ghosts. keys: of the piece's vertices; a reader fills those of the ghosts, and
// finds their numbers.
template <class Coder>
bool CodeGhosts(Coder& coder, NumberedVertices& numbered, std::span<VertexKey> keys)
{
  const auto& vertices = numbered.vertices;
  std::vector<VertexKey> walkKeys(vertices.size());
  VertexKey last = 0;
  for (std::uint32_t v = 0; v < vertices.size(); ++v)
  {
    if (vertices[v].own)
    {
      continue;
    }
    VertexKey key = 0, reference = last;
    for (std::size_t k = 3; k-- > 0;)
    {
      const std::uint32_t near = vertices[v].gate[k];
      reference = near < v && !vertices[near].own ? walkKeys[near] : reference;
    }
    if constexpr (!Coder::reading)
    {
      key = keys[numbered.numbers[v]];
    }
    const std::int64_t partitionBefore = PartitionOfKey(reference);
    const std::int64_t indexBefore = IndexOfKey(reference);
    std::int64_t partition = PartitionOfKey(key), index = IndexOfKey(key);
    const bool same = coder.Symbol(contexts::samePartition, partition == partitionBefore) != 0;
    if (same)
    {
      partition = partitionBefore;
      index = Wrapped(indexBefore, coder.Signed(contexts::ghostIndex, index - indexBefore));
    }
    else
    {
      partition = Wrapped(
        partitionBefore, coder.Signed(contexts::ghostPartition, partition - partitionBefore));
      index = static_cast<std::int64_t>(
        coder.Number(contexts::ghostOtherIndex, static_cast<std::uint64_t>(index)));
    }
    if (((static_cast<std::uint64_t>(partition) | static_cast<std::uint64_t>(index)) >> 32) != 0)
    {
      return false;
    }
    last = MakeKey(static_cast<std::uint32_t>(partition), static_cast<std::uint32_t>(index));
    walkKeys[v] = last;
  }
  if constexpr (Coder::reading)
  {
    // Two of one key get one number here, and CheckPiece refuses them.
    const auto sorted = keys.subspan(numbered.own);
    for (std::size_t v = 0, i = 0; v < vertices.size(); ++v)
    {
      if (!vertices[v].own)
      {
        sorted[i++] = walkKeys[v];
      }
    }
    std::sort(sorted.data(), sorted.data() + sorted.size());
    for (std::size_t v = 0; v < vertices.size(); ++v)
    {
      if (!vertices[v].own)
      {
        numbered.numbers[v] = static_cast<VertexId>(
          std::lower_bound(keys.begin() + std::ptrdiff_t(numbered.own), keys.end(), walkKeys[v]) -
          keys.begin());
      }
    }
  }
  return true;
}

}
