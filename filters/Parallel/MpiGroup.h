// SPDX-License-Identifier: BSD-3-Clause
// The ranks that build one model: a RankGroup that knows which rank has which blocks (NodeShares),
// and implements what the steps out of core need (BlockGroup). For kdstream-build-mpi and
// vtkKdStoreWriter. The steps of a build, and transfers from file to file (DistributedFiles), are
// not here.
#pragma once

#include "filters/Parallel/NodeShares.h"
#include "filters/outofcore/levels/BlockGroup.h"
#include "filters/ranks/RankGroup.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace kdstream
{

class MpiGroup
  : public RankGroup
  , public BlockGroup
{
public:
  // REQUIRES: `messages` outlives the group.
  explicit MpiGroup(RankMessages& messages);
  ~MpiGroup() override;

  // Which rank has which blocks.
  NodeShares& Shares() { return this->Nodes; }
  const NodeShares& Shares() const { return this->Nodes; }
  std::size_t OwnerOf(std::size_t block, unsigned depth) const
  {
    return this->Nodes.OwnerOf(block, depth);
  }

  bool IsFirst() const override { return this->Rank() == 0; }
  BlockRange Here(unsigned depth) const override
  {
    return this->Nodes.BlocksOf(this->Rank(), depth);
  }
  Status Sum(std::span<std::uint64_t> numbers) override { return this->RankGroup::Sum(numbers); }
  // The greatest number of any rank.
  Result<std::uint64_t> Most(std::uint64_t number) override;
  Status Spread(std::vector<VertexId>& numbers) override;
  Status Fetch(SpillFile& file, std::size_t elementBytes, std::span<const VertexId> begin,
    unsigned depth, std::span<const VertexId> wanted) override;

  // Fetches the bytes of other ranks' blocks of a depth. Every block has the same number of bytes.
  Status Share(std::span<std::byte> blocks, unsigned depth);
  // Computes one sum: each rank in turn adds its numbers to it.
  Result<double> AddInOrder(const std::function<Status(double& sum)>& add);

private:
  NodeShares Nodes;
};

}
