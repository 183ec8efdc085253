// SPDX-License-Identifier: BSD-3-Clause
#include "filters/Parallel/NodeShares.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace kdstream
{
namespace
{

// Calls use(shares, ranks) for groups of 1 to 9 ranks, divided at the depths 0 to 5.
template <class Use>
void ForEachGroup(const Use& use)
{
  for (std::size_t ranks = 1; ranks < 10; ++ranks)
  {
    for (unsigned divided = 0; divided < 6; ++divided)
    {
      SCOPED_TRACE(std::to_string(ranks) + " ranks, divided at depth " + std::to_string(divided));
      NodeShares shares(ranks);
      shares.Divide(divided);
      use(shares, ranks);
    }
  }
}

TEST(NodeShares, BlocksOfAllRanksFollowEachOther)
{
  ForEachGroup(
    [](const NodeShares& shares, std::size_t ranks)
    {
      for (unsigned depth = 0; depth < 8; ++depth)
      {
        std::size_t end = 0;
        for (std::size_t rank = 0; rank < ranks; ++rank)
        {
          const BlockRange blocks = shares.BlocksOf(rank, depth);
          EXPECT_EQ(blocks.begin, end) << "rank " << rank << ", depth " << depth;
          ASSERT_LE(blocks.begin, blocks.end);
          end = blocks.end;
        }
        EXPECT_EQ(end, std::size_t{ 1 } << depth);
        EXPECT_GT(shares.BlocksOf(0, depth).end, 0U) << "rank 0 has one at least";
      }
    });
}

TEST(NodeShares, OwnerIsTheRankThatHasTheBlock)
{
  ForEachGroup(
    [](const NodeShares& shares, std::size_t ranks)
    {
      for (unsigned depth = 0; depth < 8; ++depth)
      {
        for (std::size_t rank = 0; rank < ranks; ++rank)
        {
          const BlockRange blocks = shares.BlocksOf(rank, depth);
          for (std::size_t block = blocks.begin; block < blocks.end; ++block)
          {
            EXPECT_EQ(shares.OwnerOf(block, depth), rank) << "block " << block;
          }
        }
      }
    });
}

// A block below the divided depth is on the rank of its ancestor, so that nothing moves between
// levels.
TEST(NodeShares, DeeperBlocksGoWithTheirAncestors)
{
  ForEachGroup(
    [](const NodeShares& shares, std::size_t)
    {
      for (std::size_t block = 0; block < 128; ++block)
      {
        const unsigned depth = shares.DividedDepth();
        EXPECT_EQ(shares.OwnerOf(block, 7), shares.OwnerOf(block >> (7 - depth), depth));
      }
    });
}

TEST(NodeShares, PlacesAreWhereTheFirstBlockOfEachRankBegins)
{
  NodeShares shares(3);
  shares.Divide(2);
  const std::vector<VertexId> begin{ 0, 10, 30, 60, 100 };
  // The first rank has nodes 0 and 1, the second has node 2, the third node 3.
  EXPECT_EQ(shares.PlacesOf(begin, 2), (std::vector<std::uint64_t>{ 0, 30, 60, 100 }));
}

}
}
