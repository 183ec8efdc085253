// SPDX-License-Identifier: BSD-3-Clause
// A partly known tree gives the same answers as a completely known one, once it has received what
// it reports as missing.
#include "Testing/Fixtures/ErrorAt.h"
#include "viewer/session/model/KnownTree.h"

#include "filters/codec/PartitionBoxes.h"
#include "filters/core/VectorMath.h"
#include "viewer/session/Testing/MemoryServer.h"

#include <gtest/gtest.h>

#include <random>

using namespace kdstream;
using namespace kdstream::testing;
using protocol::BlobId;
using protocol::BlobKind;

namespace
{

// P = 12: pages of the root and of depth 7, boxes of 128 nodes.
MemoryServer& Torus()
{
  static MemoryServer server(MakeTorus(200, 80), 4, 2);
  return server;
}

struct TestKnownTree : ::testing::Test
{
  MemoryServer& server = Torus();
  const TreeDepths depths = server.Codec().depths;
  const std::vector<Box>& boxes = server.Tree();
  std::mt19937 random{ 5 };

  KnownTree Unknown(std::size_t limit = std::size_t{ 16 } << 20) const
  {
    return { this->depths, true, this->boxes[1], limit };
  }
  // Adds what is missing; returns how many blobs that were.
  std::size_t Bring(KnownTree& tree) const
  {
    const auto missing = tree.TakeMissing();
    for (const BlobId& blob : missing)
    {
      const Status added = tree.Add(blob, this->server.Blob(blob));
      EXPECT_TRUE(added) << added.GetError().message;
    }
    return missing.size();
  }
  std::uint32_t NearestBy(KnownTree& tree, const Vec3& point, std::size_t& brought) const
  {
    for (;;)
    {
      const NearestAnswer answer = NearestKnownPartition(tree, this->depths, point);
      if (answer.known)
      {
        return *answer.partition;
      }
      brought += this->Bring(tree);
    }
  }
  // A point where a finger may hit the surface.
  Vec3 AnyPoint()
  {
    const std::size_t first = this->boxes.size() / 2;
    const Box& box = this->boxes[first + this->random() % first];
    return box.lo * 0.3 + box.hi * 0.7;
  }
};

}

TEST_F(TestKnownTree, AnswersAsTheWholeTree)
{
  for (int i = 0; i < 60; ++i)
  {
    KnownTree tree = this->Unknown();
    const Vec3 point = this->AnyPoint();
    std::size_t brought = 0;
    const std::uint32_t nearest = this->NearestBy(tree, point, brought);
    ASSERT_EQ(nearest, NearestPartition(this->boxes, this->depths, point));
    EXPECT_LT(brought, 60u) << "of 257";
    const NodeId cell = NodeOfPartition(nearest, this->depths);
    for (unsigned rings = 0; rings <= 3; ++rings)
    {
      auto region = FindKnownRegion(tree, this->depths, cell, rings);
      while (!region)
      {
        ASSERT_GT(this->Bring(tree), 0u);
        region = FindKnownRegion(tree, this->depths, cell, rings);
      }
      ASSERT_EQ(*region, *FindRegion(this->boxes, this->depths, cell, rings));
    }
  }
}

TEST_F(TestKnownTree, WhatIsLeastUsedLeavesAndIsMissingAgain)
{
  constexpr std::size_t limit = 256 << 10;
  KnownTree tree = this->Unknown(limit);
  std::size_t brought = 0;
  for (int i = 0; i < 200; ++i)
  {
    const Vec3 point = this->AnyPoint();
    ASSERT_EQ(
      this->NearestBy(tree, point, brought), NearestPartition(this->boxes, this->depths, point));
    ASSERT_LE(tree.Bytes(), limit);
  }
  EXPECT_GT(brought, 257u) << "some came twice";
}

TEST_F(TestKnownTree, AWalkLooksUpWhatItEnters)
{
  KnownTree tree = this->Unknown();
  std::vector<NodeId> entered;
  const auto enter = [&](NodeId page, const Box& box)
  {
    entered.push_back(page);
    return box.lo[0] > 0 || page == 1; // about half of the pages
  };
  tree.Walk(enter);
  EXPECT_EQ(tree.TakeMissing(), std::set<BlobId>{ BlobId::TreePage(1) });
  ASSERT_TRUE(tree.Add(BlobId::TreePage(1), this->server.Blob(BlobId::TreePage(1))));
  entered.clear();
  tree.Walk(enter);
  EXPECT_EQ(entered.size(), 129u); // the root's page, and those of depth 7
  const auto missing = tree.TakeMissing();
  EXPECT_GT(missing.size(), 40u);
  EXPECT_LT(missing.size(), 90u);
  for (const BlobId& blob : missing)
  {
    EXPECT_GT(this->boxes[blob.number].hi[0], 0);
  }
}

TEST_F(TestKnownTree, LiesAreErrorsThatNameTheBlob)
{
  KnownTree tree = this->Unknown();
  const auto add = [&tree](const BlobId& blob, const std::vector<std::uint8_t>& bytes)
  {
    const Status status = tree.Add(blob, bytes);
    return status ? "added" : status.GetError().message;
  };
  const BlobId root = BlobId::TreePage(1), page = BlobId::TreePage(128),
               exact = BlobId::PartitionBoxes(128);
  EXPECT_EQ(add(page, { 1, 2, 3 }), "added") << "passed over: its box is not known";
  EXPECT_EQ(tree.Bytes(), 0u);
  EXPECT_EQ(add(root, { 1, 2, 3 }).rfind("tree page 1: ", 0), 0u);
  ASSERT_EQ(add(root, this->server.Blob(root)), "added");
  ASSERT_EQ(add(page, this->server.Blob(page)), "added");
  EXPECT_TRUE(
    fixtures::Mentions(add(BlobId::TreePage(2), this->server.Blob(page)), { "tree page 2: " }));
  EXPECT_TRUE(
    fixtures::Mentions(add(BlobId::PartitionBoxes(1), this->server.Blob(exact)), { "boxes 1: " }));
  // Boxes of other partitions are refused.
  EXPECT_TRUE(fixtures::Mentions(
    add(exact, this->server.Blob(BlobId::PartitionBoxes(255))), { "boxes 128: ", "partition 0 " }));
  EXPECT_EQ(add(exact, this->server.Blob(exact)), "added");
}
