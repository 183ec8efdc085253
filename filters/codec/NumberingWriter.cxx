// SPDX-License-Identifier: BSD-3-Clause
#include "filters/codec/PieceWriter.h"

#include <vector>

namespace kdstream
{
namespace
{

// The group of each vertex, or noVertex for ghosts: in the order of the piece's numbers, a new
// group begins where (x, y, z) does not ascend.
std::vector<std::uint32_t> FindGroups(std::span<const WalkVertex> vertices,
  std::span<const Vec3> points, std::span<const VertexId> numbers, std::size_t own)
{
  std::vector<std::uint32_t> groups(vertices.size(), noVertex);
  std::vector<std::uint32_t> byNumber(own);
  for (std::uint32_t v = 0; v < groups.size(); ++v)
  {
    if (vertices[v].own != 0)
    {
      byNumber[numbers[v]] = v;
    }
  }
  std::uint32_t group = 0;
  for (std::size_t i = 0; i < byNumber.size(); ++i)
  {
    group += i > 0 && !(points[byNumber[i - 1]] < points[byNumber[i]]);
    groups[byNumber[i]] = group;
  }
  return groups;
}

}

void WriteGroups(SymbolWriter& symbols, std::span<const WalkVertex> vertices,
  std::span<const Vec3> points, std::span<const VertexId> numbers, std::size_t own)
{
  const std::vector<std::uint32_t> groups = FindGroups(vertices, points, numbers, own);
  // What the reader knows: the groups of earlier vertices. Vertex 0 can be in its own gate.
  std::vector<std::uint32_t> written(groups.size(), noVertex);
  std::uint32_t last = 0;
  for (std::size_t v = 0; v < groups.size(); ++v)
  {
    if (vertices[v].own == 0)
    {
      continue;
    }
    const std::uint32_t group = groups[v];
    const GateGroups near(vertices[v], written.data());
    const unsigned which = near.first == group    ? 0
                           : near.second == group ? 1
                           : near.third == group  ? 2
                                                  : otherGroup;
    symbols.Choice(near.Context(), which);
    if (which == otherGroup)
    {
      symbols.Signed(contexts::groupDifference, std::int64_t{ group } - near.Reference(last));
    }
    written[v] = last = group;
  }
}

void WriteGhosts(SymbolWriter& symbols, std::span<const WalkVertex> vertices,
  std::span<const VertexKey> keys, std::span<const VertexId> numbers)
{
  std::vector<VertexKey> walkKeys(vertices.size());
  VertexKey last = 0;
  for (std::size_t v = 0; v < vertices.size(); ++v)
  {
    if (vertices[v].own != 0)
    {
      continue;
    }
    const VertexKey key = keys[numbers[v]];
    const VertexKey reference = ReferenceKey(vertices, v, walkKeys.data(), last);
    const std::int64_t partition = PartitionOfKey(key), index = IndexOfKey(key);
    const std::int64_t nearPartition = PartitionOfKey(reference), nearIndex = IndexOfKey(reference);
    symbols.Choice(contexts::samePartition, partition == nearPartition);
    if (partition == nearPartition)
    {
      symbols.Signed(contexts::ghostIndex, index - nearIndex);
    }
    else
    {
      symbols.Signed(contexts::ghostPartition, partition - nearPartition);
      symbols.Number(contexts::ghostOtherIndex, static_cast<std::uint64_t>(index));
    }
    walkKeys[v] = last = key;
  }
}

}
