// SPDX-License-Identifier: BSD-3-Clause
// When memory is short, the least recently used pieces are evicted, but never one that is shown.
#include "viewer/session/model/PieceCache.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

using namespace kdstream;

namespace
{

Piece MakePiece(NodeId node, std::size_t vertices)
{
  Piece piece;
  piece.id = { Resolution::Original(), node };
  piece.positions.resize(vertices);
  return piece;
}

PieceId Id(NodeId node)
{
  return { Resolution::Original(), node };
}

TEST(TestPieceCache, LeastRecentlyUsedLeavesFirst)
{
  const std::size_t one = MemoryOf(MakePiece(1, 100));
  PieceCache cache(3 * one);
  for (NodeId node = 1; node <= 3; ++node)
  {
    cache.Add(MakePiece(node, 100));
  }
  EXPECT_NE(cache.Find(Id(1)), nullptr); // counts as a use of 1
  EXPECT_NE(cache.Peek(Id(2)), nullptr); // peeking does not count as a use
  cache.Add(MakePiece(4, 100));
  EXPECT_EQ(cache.Peek(Id(2)), nullptr);
  EXPECT_NE(cache.Peek(Id(1)), nullptr);
  EXPECT_EQ(cache.Bytes(), 3 * one);
  cache.Clear();
  EXPECT_EQ(cache.Bytes(), 0u);
  EXPECT_EQ(cache.Size(), 0u);
}

TEST(TestPieceCache, PinnedStayEvenAboveTheLimit)
{
  const std::size_t one = MemoryOf(MakePiece(1, 100));
  PieceCache cache(2 * one);
  cache.Pin({ Id(1), Id(2), Id(3) });
  for (NodeId node = 1; node <= 4; ++node)
  {
    cache.Add(MakePiece(node, 100));
  }
  EXPECT_EQ(cache.Size(), 3u);
  EXPECT_EQ(cache.Peek(Id(4)), nullptr);
  cache.Pin({ Id(3) });
  EXPECT_EQ(cache.Size(), 2u);
  EXPECT_NE(cache.Peek(Id(3)), nullptr);
  EXPECT_EQ(cache.Peek(Id(1)), nullptr);
}

TEST(TestPieceCache, AgreesWithASimpleModelUnderRandomUse)
{
  std::mt19937 random(9);
  for (int trial = 0; trial < 50; ++trial)
  {
    const std::size_t limit = 20000;
    PieceCache cache(limit);
    std::vector<std::pair<NodeId, std::size_t>> model; // oldest first
    std::set<PieceId> pinned;
    const auto evict = [&]
    {
      std::size_t sum = 0;
      for (const auto& entry : model)
      {
        sum += entry.second;
      }
      for (auto it = model.begin(); it != model.end() && sum > limit;)
      {
        if (pinned.count(Id(it->first)) != 0)
        {
          ++it;
          continue;
        }
        sum -= it->second;
        it = model.erase(it);
      }
      return sum;
    };
    for (int i = 0; i < 300; ++i)
    {
      const auto node = static_cast<NodeId>(1 + random() % 12);
      const auto place = std::find_if(
        model.begin(), model.end(), [node](const auto& entry) { return entry.first == node; });
      if (random() % 8 == 0)
      {
        pinned = { Id(node), Id(static_cast<NodeId>(1 + random() % 12)) };
        cache.Pin(pinned);
      }
      else if (random() % 2 == 0)
      {
        Piece piece = MakePiece(node, random() % 300);
        if (place != model.end())
        {
          model.erase(place);
        }
        model.emplace_back(node, MemoryOf(piece));
        cache.Add(std::move(piece));
      }
      else
      {
        EXPECT_EQ(cache.Find(Id(node)) != nullptr, place != model.end());
        if (place != model.end())
        {
          std::rotate(place, place + 1, model.end());
        }
      }
      EXPECT_EQ(cache.Bytes(), evict());
      EXPECT_EQ(cache.Size(), model.size());
    }
  }
}

}
