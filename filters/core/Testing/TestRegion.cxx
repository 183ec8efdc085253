// SPDX-License-Identifier: BSD-3-Clause
#include "Testing/Fixtures/Meshes.h"
#include "filters/core/tree/Region.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>

using namespace kdstream;
using namespace kdstream::fixtures;

TEST(FindRegion, AgreesWithTestingEveryBox)
{
  for (const NamedMesh& named : AllMeshes())
  {
    SCOPED_TRACE(named.name);
    const auto tree = *BuildKdTree(named.mesh.points, { 20, {}, 8 });
    std::mt19937 random(1);
    const NodeId first = NodeId{ 1 } << tree.depths.partition;
    for (unsigned draw = 0; draw < 50; ++draw)
    {
      const auto cell = static_cast<NodeId>(1 + random() % (2 * first - 1));
      const auto rings = static_cast<unsigned>(random() % 4);
      Box reach = tree.boxes[cell];
      double average = 0;
      for (std::size_t k = 0; k < 3; ++k)
      {
        average += (reach.hi[k] - reach.lo[k]) / 3;
      }
      std::set<std::uint32_t> expected;
      for (NodeId node = first; node < 2 * first; ++node)
      {
        bool touches = !tree.boxes[node].Empty() && !reach.Empty();
        for (std::size_t k = 0; k < 3; ++k)
        {
          touches = touches && tree.boxes[node].lo[k] <= reach.hi[k] + rings * average &&
                    tree.boxes[node].hi[k] >= reach.lo[k] - rings * average;
        }
        if (touches)
        {
          expected.insert(node - first);
        }
      }
      const auto region = FindRegion(tree.boxes, tree.depths, cell, rings);
      ASSERT_TRUE(region);
      EXPECT_EQ(std::set<std::uint32_t>(region->begin(), region->end()), expected);
      EXPECT_EQ(region->size(), expected.size());
      if (DepthOfNode(cell) == tree.depths.partition && !reach.Empty())
      {
        EXPECT_EQ(region->front(), cell - first) << "the cell itself comes first";
      }
    }
    EXPECT_FALSE(FindRegion(tree.boxes, tree.depths, 0, 1));
    EXPECT_FALSE(FindRegion(tree.boxes, tree.depths, 2 * first, 1));
  }
}

TEST(NearestPartition, IsTheLowestOfTheNearest)
{
  const auto tree = *BuildKdTree(GridPlate(40).points, { 20, {}, 8 });
  const NodeId first = NodeId{ 1 } << tree.depths.partition;
  std::mt19937 random(1);
  for (unsigned draw = 0; draw < 300; ++draw)
  {
    const Vec3 point{ double(random() % 50) - 5, double(random() % 50) - 5, double(random() % 3) };
    double best = INFINITY;
    std::uint32_t expected = 0;
    for (NodeId node = first; node < 2 * first; ++node)
    {
      double distance = 0;
      for (std::size_t k = 0; k < 3; ++k)
      {
        const double d =
          std::max({ tree.boxes[node].lo[k] - point[k], point[k] - tree.boxes[node].hi[k], 0.0 });
        distance += d * d;
      }
      if (distance < best)
      {
        best = distance;
        expected = node - first;
      }
    }
    EXPECT_EQ(NearestPartition(tree.boxes, tree.depths, point), expected);
  }
}
