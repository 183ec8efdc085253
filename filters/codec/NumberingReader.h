// SPDX-License-Identifier: BSD-3-Clause
// Reads the number in the piece that each vertex of the walk has (PieceNumbering.h).
#pragma once

#include "filters/codec/PieceNumbering.h"
#include "filters/codec/Sorting.h"
#include "filters/codec/SymbolCoder.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace kdstream
{

// A sum modulo 2^64: differences from a file can have any value.
constexpr std::int64_t WrappedSum(std::int64_t value, std::int64_t difference)
{
  return static_cast<std::int64_t>(
    static_cast<std::uint64_t>(value) + static_cast<std::uint64_t>(difference));
}

// Reads the groups of own vertices, one after the other in the order of the walk.
class GroupReader
{
public:
  // own: the number of own vertices.
  GroupReader(const SymbolReader& symbols, std::span<const WalkVertex> vertices, std::size_t own)
    : Symbols(symbols)
    , Vertices(vertices)
    , Own(own)
    , Groups(vertices.size(), noVertex)
  {
  }

  // Reads the group of own vertex v. Returns false if it is not a group.
  KDSTREAM_IN_LOOPS bool Read(std::size_t v)
  {
    std::uint32_t* groups = this->Groups.data();
    const GateGroups near(this->Vertices[v], groups);
    const unsigned which = this->Symbols.Choice(near.Context());
    // An array instead of branches, because the choice can hardly be predicted.
    const std::array<std::uint32_t, 4> choices{ near.first, near.second, near.third, noVertex };
    std::uint32_t group = choices[which & 3];
    if (which >= otherGroup)
    {
      const std::int64_t sum =
        WrappedSum(near.Reference(this->Last), this->Symbols.Signed(contexts::groupDifference));
      group = sum >= 0 && sum < std::int64_t(noVertex) ? static_cast<std::uint32_t>(sum) : noVertex;
    }
    groups[v] = this->Last = group;
    return group < this->Own;
  }

  // The group of each vertex, or noVertex for ghosts.
  const std::vector<std::uint32_t>& All() const { return this->Groups; }
  // The position after the symbols that were read.
  const SymbolCursor& Position() const { return this->Symbols; }

private:
  SymbolCursor Symbols;
  std::span<const WalkVertex> Vertices;
  std::size_t Own;
  std::vector<std::uint32_t> Groups;
  std::uint32_t Last = 0;
};

// Numbers the vertices that have a group: by group, then by place, then by the order of the walk.
// sortKeyOf(v): ascends with (x, y, z), and may be equal for different places; isBefore(v, w):
// compares all three, then the walk's numbers. REQUIRES: groups are below `own`. numbers: gets the
// numbers of own vertices.
template <class SortKeyOf, class IsBefore>
void NumberByGroup(std::span<const std::uint32_t> groups, std::size_t own,
  const SortKeyOf& sortKeyOf, const IsBefore& isBefore, std::span<VertexId> numbers)
{
  // 1. Sort the vertices by group, by counting. Group g begins at begin[g + 1] at first, and at
  //    begin[g] after all vertices were put in.
  std::vector<std::uint32_t> begin(own + 2);
  for (const std::uint32_t group : groups)
  {
    begin[group == noVertex ? 0 : group + 2] += group != noVertex;
  }
  SumUp(begin);
  const std::unique_ptr<std::uint32_t[]> sorted(new std::uint32_t[own]);
  const std::unique_ptr<std::uint64_t[]> keys(new std::uint64_t[own]);
  for (std::uint32_t v = 0; v < groups.size(); ++v)
  {
    if (groups[v] != noVertex)
    {
      const std::uint32_t at = begin[groups[v] + 1]++;
      sorted[at] = v;
      keys[at] = sortKeyOf(v);
    }
  }
  // 2. Sort each group. In a small group, count for each vertex how many come before it; this needs
  //    no branches that are hard to predict. The counts add up to 0 + 1 + 2 … unless some keys are
  //    equal.
  constexpr std::uint32_t few = 24;
  for (std::size_t g = 0; g < own && begin[g] < own; ++g)
  {
    const std::uint32_t first = begin[g], last = begin[g + 1], count = last - first;
    std::uint32_t sum = 0;
    for (std::uint32_t i = first; i < last && count <= few; ++i)
    {
      std::uint32_t rank = 0;
      for (std::uint32_t j = first; j < last; ++j)
      {
        rank += keys[j] < keys[i];
      }
      numbers[sorted[i]] = first + rank;
      sum += rank;
    }
    if (2 * sum != count * (count - 1)) // equal keys, or a large group
    {
      SortFew(sorted.get() + first, count, isBefore);
      for (std::uint32_t i = first; i < last; ++i)
      {
        numbers[sorted[i]] = i;
      }
    }
  }
}

// Reads the ghosts' keys, and numbers the ghosts after the own vertices. keys: gets the key of each
// ghost; numbers: gets its number. Returns false if a key is malformed.
bool ReadGhosts(SymbolReader& symbols, std::span<const WalkVertex> vertices, std::size_t own,
  std::span<VertexKey> keys, std::span<VertexId> numbers);

}
