// SPDX-License-Identifier: BSD-3-Clause
#include "filters/codec/TreePage.h"

#include "Testing/Fixtures/Invariants.h"
#include "Testing/Fixtures/Meshes.h"
#include "filters/codec/PartitionBoxes.h"
#include "filters/codec/Seal.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

using namespace kdstream;
using namespace kdstream::fixtures;

namespace
{

using Bytes = std::vector<std::uint8_t>;

// The first `size` bytes of a blob's content, with a correct checksum.
Bytes SealedPart(const Bytes& blob, std::size_t size)
{
  Bytes part(blob.begin(), blob.begin() + static_cast<std::ptrdiff_t>(size));
  SealBlob(part);
  return part;
}

std::size_t ContentOf(const Bytes& blob)
{
  return blob.size() - checksumSize;
}

bool Holds(const Box& outer, const Box& inner)
{
  bool holds = true;
  for (std::size_t k = 0; k < 3; ++k)
  {
    holds = holds && outer.lo[k] <= inner.lo[k] && inner.hi[k] <= outer.hi[k];
  }
  return holds;
}

// Whether each side is moved outward by at most a 16th of the parent's extent (and a little, for
// rounding).
bool IsNear(const Box& rounded, const Box& exact, const Box& parent)
{
  bool near = true;
  for (std::size_t k = 0; k < 3; ++k)
  {
    const double most =
      (parent.hi[k] - parent.lo[k]) * (1.0 / 16 + 1e-12) + 1e-12 * std::abs(parent.hi[k]);
    near = near && exact.lo[k] - rounded.lo[k] <= most && rounded.hi[k] - exact.hi[k] <= most;
  }
  return near;
}

PieceTable RandomFacts(const TreeDepths& depths, bool hasLevels)
{
  PieceTable pieces(depths, hasLevels);
  std::mt19937 random(7);
  for (const NodeId page : TreePages(depths))
  {
    for (const PieceId piece : PiecesOfTreePage(page, depths, hasLevels))
    {
      PieceFacts& facts = pieces.At(piece);
      facts.most99 = std::ldexp(float(random() % 999), static_cast<int>(random() % 80) - 40);
      facts.most = random() % 5 == 0 ? std::numeric_limits<float>::max()
                                     : facts.most99 * (1 + float(random() % 3));
      facts.bytes = static_cast<std::uint32_t>(random() % (1U << (random() % 26)));
    }
  }
  return pieces;
}

// Calls visit for trees with one vertex in each partition: they have many pages, with empty cells
// in them.
template <class Visit>
void ForEachTree(const Visit& visit)
{
  for (const NamedMesh& named : AllMeshes())
  {
    if (named.mesh.points.size() <= 9000)
    {
      SCOPED_TRACE(named.name);
      visit(*BuildKdTree(named.mesh.points, { 1, {}, 1 }));
    }
  }
}

}

TEST(TreePage, EveryNodeIsInOnePage)
{
  for (unsigned deepest = 0; deepest <= 16; ++deepest)
  {
    const TreeDepths depths{ deepest, deepest, deepest };
    std::vector<NodeId> reported(std::size_t{ 2 } << deepest);
    for (const NodeId page : TreePages(depths))
    {
      ASSERT_TRUE(IsTreePage(page, depths));
      for (unsigned below = 1; below <= DepthsOfTreePage(page, depths); ++below)
      {
        for (NodeId i = 0; i < NodeId{ 1 } << below; ++i)
        {
          ASSERT_EQ(std::exchange(reported[(page << below) + i], page), 0U);
        }
      }
    }
    for (NodeId node = 1; node < reported.size(); ++node)
    {
      ASSERT_EQ(TreePageOfNode(node, depths), node == 1 ? 1 : reported[node]) << deepest;
    }
    EXPECT_LE(DepthsOfTreePage(1, depths), 9U);
    EXPECT_FALSE(IsTreePage(0, depths));
  }
  EXPECT_FALSE(IsTreePage(2, { 14, 14, 14 }));
  EXPECT_TRUE(IsTreePage(1U << 9, { 14, 14, 14 }));
  EXPECT_FALSE(IsTreePage(1U << 14, { 14, 14, 14 }));
}

TEST(TreePage, BoxesHoldTheExactOnesAndAreNear)
{
  ForEachTree(
    [](const KdTree& tree)
    {
      const PieceTable pieces = RandomFacts(tree.depths, true);
      for (const NodeId page : TreePages(tree.depths))
      {
        const TreePage rounded = RoundTreePage(tree.boxes, page, tree.depths, pieces);
        const Box around = RoundedBoxOf(tree.boxes, page);
        const Bytes blob = EncodeTreePage(rounded);
        const auto reported = DecodeTreePage(blob, page, around, tree.depths, true);
        ASSERT_TRUE(reported) << reported.GetError().message;
        ASSERT_EQ(reported->boxes, rounded.boxes);
        ASSERT_EQ(reported->facts, rounded.facts);
        for (unsigned below = 1; below <= DepthsOfTreePage(page, tree.depths); ++below)
        {
          const NodeId first = page << below;
          for (NodeId node = first; node < first + (NodeId{ 1 } << below); ++node)
          {
            const Box &box = reported->BoxOf(node), &exact = tree.boxes[node];
            ASSERT_EQ(box.Empty(), exact.Empty());
            const Box& parent = reported->BoxOf(node / 2);
            ASSERT_TRUE(exact.Empty() ||
                        (Holds(box, exact) && Holds(parent, box) && IsNear(box, exact, parent)));
            ASSERT_EQ(box, RoundedBoxOf(tree.boxes, node));
          }
        }
      }
    });
}

TEST(TreePage, FactsAreRoundedUp)
{
  const TreeDepths depths{ 8, 12, 16 };
  for (const bool hasLevels : { true, false })
  {
    const PieceTable pieces = RandomFacts(depths, hasLevels);
    const std::vector<PieceId> ids = PiecesOfTreePage(1, depths, hasLevels);
    EXPECT_EQ(ids.size(), (hasLevels ? 12U + 2 + 4 + 8 + 16 + 32 : 0U) + 256);
    std::vector<Box> boxes(512);
    boxes[1].Add(Vec3{ 1, 2, 3 });
    const TreePage page = RoundTreePage(boxes, 1, depths, pieces);
    ASSERT_EQ(page.facts.size(), ids.size());
    for (std::size_t i = 0; i < ids.size(); ++i)
    {
      const PieceFacts &reported = page.facts[i], &exact = pieces.At(ids[i]);
      ASSERT_GE(reported.most99, exact.most99);
      ASSERT_LE(double(reported.most99), double(exact.most99) * 1.0626);
      ASSERT_TRUE(reported.most >= exact.most || exact.most == std::numeric_limits<float>::max());
      ASSERT_LE(reported.most99, reported.most);
      ASSERT_GE(reported.bytes, exact.bytes);
      ASSERT_LE(reported.bytes, exact.bytes + exact.bytes / 8);
      ASSERT_EQ(RoundedUp(reported), reported);
    }
  }
  EXPECT_EQ(RoundedUp({ 0, 0, 64U << 20 }).bytes, 64U << 20);
}

TEST(TreePage, WhateverBytesSayBoxesLieInTheirParents)
{
  const Mesh mesh = Torus(40, 30);
  const KdTree tree = *BuildKdTree(mesh.points, { 1, {}, 1 });
  const Bytes blob =
    EncodeTreePage(RoundTreePage(tree.boxes, 1, tree.depths, RandomFacts(tree.depths, true)));
  std::mt19937 random(3);
  std::size_t decoded = 0;
  for (int i = 0; i < 4000; ++i)
  {
    Bytes altered = SealedPart(blob, ContentOf(blob));
    altered.resize(ContentOf(blob));
    altered[blobHeadSize + random() % (altered.size() - blobHeadSize)] ^=
      static_cast<std::uint8_t>(1U << random() % 8);
    SealBlob(altered);
    const auto reported = DecodeTreePage(altered, 1, tree.boxes[1], tree.depths, true);
    for (std::size_t node = 2; reported && node < reported->boxes.size(); ++node)
    {
      const Box& box = reported->boxes[node];
      ASSERT_TRUE(box.Empty() || Holds(reported->boxes[node / 2], box));
      ASSERT_TRUE(box.Empty() || (box.lo[1] <= box.hi[1] && box.lo[2] <= box.hi[2]));
    }
    decoded += reported ? 1 : 0;
  }
  EXPECT_GT(decoded, 0U);
  EXPECT_LT(decoded, 4000U);
}

TEST(TreePage, WhatIsNotAPageIsRefused)
{
  const Mesh mesh = Torus(40, 30);
  const KdTree tree = *BuildKdTree(mesh.points, { 1, {}, 1 });
  const TreeDepths& depths = tree.depths;
  const Bytes blob =
    EncodeTreePage(RoundTreePage(tree.boxes, 1, depths, RandomFacts(depths, true)));
  const auto why = [&](const Bytes& bytes, NodeId page, const Box& around, bool levels = true)
  {
    const auto reported = DecodeTreePage(bytes, page, around, depths, levels);
    return reported ? "decoded" : reported.GetError().message;
  };
  const Box& root = tree.boxes[1];
  for (std::size_t size = 0; size < ContentOf(blob); ++size)
  {
    ASSERT_NE(why(SealedPart(blob, size), 1, root), "decoded");
  }
  Bytes longer(blob.begin(), blob.begin() + static_cast<std::ptrdiff_t>(ContentOf(blob)));
  longer.push_back(0);
  EXPECT_NE(why(SealedPart(longer, longer.size()), 1, root), "decoded");
  EXPECT_EQ(why(blob, 2, root), "tree page 2: is not a page of this tree");
  const double huge = std::numeric_limits<double>::max();
  EXPECT_EQ(
    why(blob, 1, { { -huge, 0, 0 }, { huge, 1, 1 } }), "tree page 1: is not a page of this tree");
  EXPECT_NE(why(blob, 1, root, false), "decoded") << "the facts of levels are too many";
}

TEST(PartitionBoxes, AreExactAndUniteToTheTrees)
{
  ForEachTree(
    [](const KdTree& tree)
    {
      std::vector<Box> boxes(tree.boxes.size());
      for (const NodeId node : AllPartitionBoxes(tree.depths))
      {
        ASSERT_TRUE(HasPartitionBoxes(node, tree.depths));
        const Bytes blob = EncodePartitionBoxes(tree.boxes, node, tree.depths);
        const auto reported = DecodePartitionBoxes(blob, node, tree.depths);
        ASSERT_TRUE(reported) << reported.GetError().message;
        for (std::size_t size = 0; size < ContentOf(blob); ++size)
        {
          ASSERT_FALSE(DecodePartitionBoxes(SealedPart(blob, size), node, tree.depths));
        }
        const NodeId first = node << (tree.depths.partition - DepthOfNode(node));
        for (NodeId i = 0; i < reported->size(); ++i)
        {
          ASSERT_EQ(BoxesOfPartition(first + i, tree.depths), node);
          boxes[first + i] = (*reported)[i];
        }
      }
      UniteBoxes(boxes);
      for (NodeId node = 1; node < boxes.size(); ++node)
      {
        ASSERT_EQ(boxes[node], tree.boxes[node]) << node;
      }
      EXPECT_FALSE(HasPartitionBoxes(0, tree.depths));
    });
}
