// SPDX-License-Identifier: BSD-3-Clause
#include "filters/adapter/PartitionLayout.h"

#include <algorithm>
#include <numeric>

namespace kdstream
{

PartitionLayout::PartitionLayout(std::vector<std::uint32_t> partitionOf, std::size_t partitions,
  std::span<const Triangle> elements)
  : Partition(std::move(partitionOf))
  , OwnBegin(partitions + 1, 0)
  , Own(this->Partition.size())
  , PlaceInOwn(this->Partition.size())
  , Elements(elements)
  , Buckets(BucketTriangles(
      elements, partitions, [this](VertexId v) { return std::size_t{ this->Partition[v] }; }))
{
  for (const std::uint32_t partition : this->Partition)
  {
    ++this->OwnBegin[partition + 1];
  }
  std::partial_sum(this->OwnBegin.begin(), this->OwnBegin.end(), this->OwnBegin.begin());
  std::vector<VertexId> filled(partitions, 0);
  for (VertexId v = 0; v < this->Partition.size(); ++v)
  {
    const std::uint32_t partition = this->Partition[v];
    this->PlaceInOwn[v] = filled[partition]++;
    this->Own[this->OwnBegin[partition] + this->PlaceInOwn[v]] = v;
  }
}

PartitionPiece PartitionLayout::Cut(std::size_t partition) const
{
  PartitionPiece piece;
  const std::span<const std::uint32_t> elements = this->Buckets.Of(partition);
  piece.elements.assign(elements.begin(), elements.end());
  piece.vertices.assign(this->Own.begin() + std::ptrdiff_t(this->OwnBegin[partition]),
    this->Own.begin() + std::ptrdiff_t(this->OwnBegin[partition + 1]));
  piece.owned = piece.vertices.size();

  std::vector<VertexId> ghosts;
  piece.duplicate.reserve(elements.size());
  for (const std::uint32_t element : elements)
  {
    std::size_t owner = partition;
    for (const VertexId v : this->Elements[element])
    {
      owner = std::min<std::size_t>(owner, this->Partition[v]);
      if (this->Partition[v] != partition)
      {
        ghosts.push_back(v);
      }
    }
    piece.duplicate.push_back(owner != partition);
  }
  std::sort(ghosts.begin(), ghosts.end());
  ghosts.erase(std::unique(ghosts.begin(), ghosts.end()), ghosts.end());

  const auto placeOf = [&](VertexId v)
  {
    if (this->Partition[v] == partition)
    {
      return this->PlaceInOwn[v];
    }
    const auto ghost = std::lower_bound(ghosts.begin(), ghosts.end(), v);
    return static_cast<VertexId>(piece.owned + std::size_t(ghost - ghosts.begin()));
  };
  piece.corners.reserve(elements.size());
  for (const std::uint32_t element : elements)
  {
    const Triangle& t = this->Elements[element];
    piece.corners.push_back({ placeOf(t[0]), placeOf(t[1]), placeOf(t[2]) });
  }
  piece.vertices.insert(piece.vertices.end(), ghosts.begin(), ghosts.end());
  return piece;
}

}
