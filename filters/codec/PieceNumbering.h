// Which of a piece's numbers each vertex of the walk has. Layout: doc/formats.md, "Groups".
//
// Own vertices are numbered so that clusters are runs of near places (doc/design.md#numbers), and
// inside a finest cluster by place. So their numbers fall into *groups*, runs of strictly ascending
// (x, y, z): a vertex tells its group, mostly that of a neighbour, and a group's vertices are
// sorted again. Ghosts tell their keys, mostly near those of a neighbour, and are numbered in their
// order.
#pragma once

#include "filters/codec/PieceContexts.h"
#include "filters/codec/Sorting.h"
#include "filters/codec/TriangleWalk.h"
#include "filters/core/pieces/Piece.h"

#include <algorithm>
#include <memory>
#include <span>
#include <type_traits>
#include <vector>

namespace kdstream
{

// The vertices of the walk, those without triangles behind it.
struct NumberedVertices
{
  std::span<const WalkVertex> vertices;
  std::vector<Vec3> positions;   // writing: of each vertex, as its coordinates are coded
  std::size_t own = 0;           // of all vertices
  std::vector<VertexId> numbers; // of each vertex; a reader fills it
};

// A sum modulo 2^64: differences from a file may be anything.
constexpr std::int64_t Wrapped(std::int64_t value, std::int64_t difference)
{
  return static_cast<std::int64_t>(
    static_cast<std::uint64_t>(value) + static_cast<std::uint64_t>(difference));
}

// Writing: the group of each vertex, or noVertex for ghosts.
inline std::vector<std::uint32_t> GroupsOf(const NumberedVertices& numbered)
{
  std::vector<std::uint32_t> groups(numbered.vertices.size(), noVertex);
  std::vector<std::uint32_t> byNumber(numbered.own);
  for (std::uint32_t v = 0; v < groups.size(); ++v)
  {
    if (numbered.vertices[v].own != 0)
    {
      byNumber[numbered.numbers[v]] = v;
    }
  }
  std::uint32_t group = 0;
  for (std::size_t i = 0; i < byNumber.size(); ++i)
  {
    group += i > 0 && !(numbered.positions[byNumber[i - 1]] < numbered.positions[byNumber[i]]);
    groups[byNumber[i]] = group;
  }
  return groups;
}

// Codes the groups of own vertices, one after the other in the order of the walk.
template <class Coder>
class GroupCoder
{
public:
  GroupCoder(Coder& coder, const NumberedVertices& numbered)
    : Cursor(coder)
    , Vertices(numbered.vertices)
    , Own(numbered.own)
    , Groups(numbered.vertices.size(), noVertex)
  {
  }

  // coded: writing, the group of own vertex v. False where what is read is none.
  KDSTREAM_IN_LOOPS bool Code(std::size_t v, std::uint32_t coded = 0)
  {
    // Of vertex 0 itself, whose gate names it, nothing is known yet.
    const auto& gate = this->Vertices[v].gate;
    std::uint32_t* groups = this->Groups.data();
    const std::uint32_t first = groups[gate[0]], second = groups[gate[1]], third = groups[gate[2]];
    const std::size_t context = contexts::groupOf + (first == second ? 1U : 0U) +
                                (second == third ? 2U : 0U) + (first == third ? 4U : 0U);
    unsigned which = 3;
    if constexpr (!Coder::reading)
    {
      which = first == coded ? 0 : (second == coded ? 1 : (third == coded ? 2 : 3));
    }
    which = this->Cursor.Choice(context, which);
    const std::array<std::uint32_t, 4> near{ first, second, third, noVertex };
    std::uint32_t group = near[which & 3]; // branches would often be foretold wrongly
    if (which > 2)
    {
      const std::uint32_t known = first != noVertex ? first : (second != noVertex ? second : third);
      const std::int64_t from = known != noVertex ? known : this->Last;
      const std::int64_t difference = Coder::reading ? 0 : std::int64_t{ coded } - from;
      const std::int64_t sum =
        Wrapped(from, this->Cursor.Signed(contexts::groupDifference, difference));
      group = sum >= 0 && sum < std::int64_t(noVertex) ? static_cast<std::uint32_t>(sum) : noVertex;
    }
    groups[v] = this->Last = group;
    return group < this->Own;
  }
  // Reading: the group of each vertex, or noVertex for ghosts.
  const std::vector<std::uint32_t>& All() const { return this->Groups; }

  typename Coder::Cursor Cursor;

private:
  std::span<const WalkVertex> Vertices;
  std::size_t Own;
  std::vector<std::uint32_t> Groups;
  std::uint32_t Last = 0;
};

inline void WriteGroups(SymbolWriter& coder, const NumberedVertices& numbered)
{
  const std::vector<std::uint32_t> groups = GroupsOf(numbered);
  GroupCoder<SymbolWriter> groupCoder(coder, numbered);
  for (std::size_t v = 0; v < groups.size(); ++v)
  {
    if (numbered.vertices[v].own != 0)
    {
      (void)groupCoder.Code(v, groups[v]);
    }
  }
}

// Reading: numbers own vertices by group, then by place, then as the walk found them. placeOf(v): a
// number that ascends with (x, y, z), equal where it takes more to tell; isBefore(v, w): all.
template <class PlaceOf, class IsBefore>
void NumberByGroup(NumberedVertices& numbered, std::span<const std::uint32_t> groups,
  const PlaceOf& placeOf, const IsBefore& isBefore)
{
  std::vector<std::uint32_t> begin(numbered.own + 2); // of group g at g + 1
  for (const std::uint32_t group : groups)
  {
    begin[group == noVertex ? 0 : group + 2] += group != noVertex;
  }
  SumUp(begin);
  const std::unique_ptr<std::uint32_t[]> sorted(new std::uint32_t[numbered.own]);
  const std::unique_ptr<std::uint64_t[]> places(new std::uint64_t[numbered.own]);
  for (std::uint32_t v = 0; v < groups.size(); ++v)
  {
    if (groups[v] != noVertex)
    {
      const std::uint32_t at = begin[groups[v] + 1]++;
      sorted[at] = v;
      places[at] = placeOf(v);
    }
  }
  constexpr std::uint32_t few = 24;
  for (std::size_t g = 0; g < numbered.own && begin[g] < numbered.own; ++g)
  {
    const std::uint32_t first = begin[g], last = begin[g + 1], count = last - first;
    std::uint32_t sum = 0;
    // Few: how many are before each, which takes no branches that are hard to foretell.
    for (std::uint32_t i = first; i < last && count <= few; ++i)
    {
      std::uint32_t rank = 0;
      for (std::uint32_t j = first; j < last; ++j)
      {
        rank += places[j] < places[i];
      }
      numbered.numbers[sorted[i]] = first + rank;
      sum += rank;
    }
    if (2 * sum != count * (count - 1)) // some places are not told apart, or there are many
    {
      SortFew(sorted.get() + first, count, isBefore);
      for (std::uint32_t i = first; i < last; ++i)
      {
        numbered.numbers[sorted[i]] = i;
      }
    }
  }
}

// Codes the keys of ghosts. keys: of the piece's vertices; a reader fills those of the ghosts, and
// finds their numbers.
template <class Coder>
bool CodeGhosts(Coder& coder, NumberedVertices& numbered,
  std::span<std::conditional_t<Coder::reading, VertexKey, const VertexKey>> keys)
{
  const auto& vertices = numbered.vertices;
  std::vector<VertexKey> walkKeys(vertices.size());
  VertexKey last = 0;
  for (std::uint32_t v = 0; v < vertices.size(); ++v)
  {
    if (vertices[v].own != 0)
    {
      continue;
    }
    VertexKey key = 0, reference = last;
    for (std::size_t k = 3; k-- > 0;)
    {
      const std::uint32_t near = vertices[v].gate[k];
      reference = near < v && vertices[near].own == 0 ? walkKeys[near] : reference;
    }
    if constexpr (!Coder::reading)
    {
      key = keys[numbered.numbers[v]];
    }
    const std::int64_t partitionBefore = PartitionOfKey(reference);
    const std::int64_t indexBefore = IndexOfKey(reference);
    std::int64_t partition = PartitionOfKey(key), index = IndexOfKey(key);
    const bool same = coder.Choice(contexts::samePartition, partition == partitionBefore) != 0;
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
    // Two of one key get two numbers here, and CheckPiece refuses them.
    struct Ghost
    {
      VertexKey key;
      std::uint32_t vertex;
    };
    std::vector<Ghost> ghosts, other;
    ghosts.reserve(vertices.size() - numbered.own);
    for (std::uint32_t v = 0; v < vertices.size(); ++v)
    {
      if (vertices[v].own == 0)
      {
        ghosts.push_back({ walkKeys[v], v });
      }
    }
    SortByMerging(ghosts, other, [](const Ghost& x, const Ghost& y) { return x.key < y.key; });
    for (std::size_t i = 0; i < ghosts.size(); ++i)
    {
      keys[numbered.own + i] = ghosts[i].key;
      numbered.numbers[ghosts[i].vertex] = static_cast<VertexId>(numbered.own + i);
    }
  }
  return true;
}

}
