// SPDX-License-Identifier: BSD-3-Clause
#include "filters/Parallel/NodeShares.h"

namespace kdstream
{
namespace
{

std::uint64_t CeilOfHalves(std::uint64_t number, unsigned halvings)
{
  return (number + (std::uint64_t{ 1 } << halvings) - 1) >> halvings;
}

}

BlockRange NodeShares::BlocksOf(std::size_t rank, unsigned depth) const
{
  const auto begin = [&](std::size_t r) -> std::size_t
  {
    const std::uint64_t nodes = std::uint64_t{ 1 } << this->NodeDepth;
    const std::uint64_t node = (r * nodes + this->Ranks - 1) / this->Ranks;
    return depth >= this->NodeDepth ? node << (depth - this->NodeDepth)
                                    : CeilOfHalves(node, this->NodeDepth - depth);
  };
  return { begin(rank), begin(rank + 1) };
}

std::size_t NodeShares::OwnerOf(std::size_t block, unsigned depth) const
{
  std::size_t low = 0, high = this->Ranks - 1;
  while (low < high)
  {
    const std::size_t middle = (low + high) / 2;
    if (block < this->BlocksOf(middle, depth).end)
    {
      high = middle;
    }
    else
    {
      low = middle + 1;
    }
  }
  return low;
}

std::vector<std::uint64_t> NodeShares::PlacesOf(
  std::span<const VertexId> begin, unsigned depth) const
{
  std::vector<std::uint64_t> places;
  for (std::size_t rank = 0; rank < this->Ranks; ++rank)
  {
    places.push_back(begin[this->BlocksOf(rank, depth).begin]);
  }
  places.push_back(begin.back());
  return places;
}

}
