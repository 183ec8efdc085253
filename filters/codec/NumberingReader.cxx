// SPDX-License-Identifier: BSD-3-Clause
#include "filters/codec/NumberingReader.h"

namespace kdstream
{
namespace
{

struct Ghost
{
  VertexKey key;
  std::uint32_t vertex; // of the walk
};

// Returns false if it is not a key.
bool ReadKey(SymbolReader& symbols, VertexKey reference, VertexKey& key)
{
  std::int64_t partition = PartitionOfKey(reference), index = IndexOfKey(reference);
  if (symbols.Choice(contexts::samePartition) != 0)
  {
    index = WrappedSum(index, symbols.Signed(contexts::ghostIndex));
  }
  else
  {
    partition = WrappedSum(partition, symbols.Signed(contexts::ghostPartition));
    index = static_cast<std::int64_t>(symbols.Number(contexts::ghostOtherIndex));
  }
  key = MakeKey(static_cast<std::uint32_t>(partition), static_cast<std::uint32_t>(index));
  return ((static_cast<std::uint64_t>(partition) | static_cast<std::uint64_t>(index)) >> 32) == 0;
}

}

bool ReadGhosts(SymbolReader& symbols, std::span<const WalkVertex> vertices, std::size_t own,
  std::span<VertexKey> keys, std::span<VertexId> numbers)
{
  std::vector<VertexKey> walkKeys(vertices.size());
  std::vector<Ghost> ghosts, other;
  ghosts.reserve(vertices.size() - own);
  VertexKey last = 0;
  for (std::uint32_t v = 0; v < vertices.size(); ++v)
  {
    if (vertices[v].own == 0)
    {
      const VertexKey reference = ReferenceKey(vertices, v, walkKeys.data(), last);
      if (!ReadKey(symbols, reference, last))
      {
        return false;
      }
      walkKeys[v] = last;
      ghosts.push_back({ last, v });
    }
  }
  // Two ghosts with the same key get two numbers here; CheckPiece refuses them.
  SortByMerging(ghosts, other, [](const Ghost& x, const Ghost& y) { return x.key < y.key; });
  for (std::size_t i = 0; i < ghosts.size(); ++i)
  {
    keys[own + i] = ghosts[i].key;
    numbers[ghosts[i].vertex] = static_cast<VertexId>(own + i);
  }
  return true;
}

}
