// SPDX-License-Identifier: BSD-3-Clause
#include "Testing/Fixtures/ErrorAt.h"
#include "Testing/Fixtures/HardPoints.h"
#include "Testing/Fixtures/Meshes.h"
#include "filters/core/tree/Clustering.h"
#include "filters/core/tree/KdTree.h"
#include "filters/program/TbbExecution.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

using namespace kdstream;
using namespace kdstream::fixtures;

namespace
{

const KdTreeOptions optionSets[] = { {}, { 1, {}, 1 }, { 7, {}, 3 }, { 100, {}, 8 },
  { 2000, 1U, 8 }, { 300, {}, 0 } };

std::size_t LongestAxis(const Box& box)
{
  std::size_t axis = 0;
  for (std::size_t k = 1; k < 3; ++k)
  {
    axis = box.hi[k] - box.lo[k] > box.hi[axis] - box.lo[axis] ? k : axis;
  }
  return axis;
}

}

TEST(KdTree, CellsOfEveryDepthDifferByAtMostOneVertex)
{
  for (const NamedMesh& named : AllMeshes())
  {
    for (const KdTreeOptions& options : optionSets)
    {
      SCOPED_TRACE(named.name);
      const auto tree = BuildKdTree(named.mesh.points, options);
      ASSERT_TRUE(tree);
      const std::size_t n = named.mesh.points.size();
      for (unsigned d = 0; d <= tree->depths.finest; ++d)
      {
        for (std::size_t c = 0; c < std::size_t{ 1 } << d; ++c)
        {
          const std::size_t size = tree->Cell(d, c).size();
          ASSERT_GE(size, n >> d) << "depth " << d;
          ASSERT_LE(size, (n + (std::size_t{ 1 } << d) - 1) >> d) << "depth " << d;
        }
      }
    }
  }
}

TEST(KdTree, EveryVertexIsInOneCellAndCellsAreAscending)
{
  for (const NamedMesh& named : AllMeshes())
  {
    SCOPED_TRACE(named.name);
    const auto tree = BuildKdTree(named.mesh.points, { 100, {}, 8 });
    ASSERT_TRUE(tree);
    EXPECT_EQ(
      std::set<VertexId>(tree->order.begin(), tree->order.end()).size(), named.mesh.points.size());
    for (std::size_t c = 0; c + 1 < tree->cellBegin.size(); ++c)
    {
      const auto cell = tree->Cell(tree->depths.finest, c);
      EXPECT_TRUE(std::is_sorted(cell.begin(), cell.end()));
    }
  }
}

TEST(KdTree, SplitsAlongTheLongestSideOnTheTotalOrder)
{
  for (const NamedMesh& named : AllMeshes())
  {
    SCOPED_TRACE(named.name);
    const auto& points = named.mesh.points;
    const auto tree = BuildKdTree(points, { 100, {}, 8 });
    ASSERT_TRUE(tree);
    for (unsigned d = 0; d < tree->depths.finest; ++d)
    {
      for (std::size_t c = 0; c < std::size_t{ 1 } << d; ++c)
      {
        Box box;
        for (const VertexId v : tree->Cell(d, c))
        {
          box.Add(points[v]);
        }
        const std::size_t axis = LongestAxis(box);
        std::pair<double, VertexId> greatest{ -INFINITY, 0 }, least{ INFINITY, 0 };
        for (const VertexId v : tree->Cell(d + 1, 2 * c))
        {
          greatest = std::max(greatest, { points[v][axis], v });
        }
        for (const VertexId v : tree->Cell(d + 1, 2 * c + 1))
        {
          least = std::min(least, { points[v][axis], v });
        }
        ASSERT_LT(greatest, least) << "cell " << c << " of depth " << d;
      }
    }
  }
}

// The order of the tree by its definition: sort each cell along its longest side, halve it.
void OrderByDefinition(
  const std::vector<Vec3>& points, unsigned depths, VertexId* begin, VertexId* end)
{
  if (depths == 0)
  {
    std::sort(begin, end);
    return;
  }
  Box box;
  for (const VertexId* v = begin; v != end; ++v)
  {
    box.Add(points[*v]);
  }
  const std::size_t axis = end - begin > 0 ? LongestAxis(box) : 0;
  std::sort(begin, end,
    [&](VertexId a, VertexId b)
    { return std::pair(points[a][axis], a) < std::pair(points[b][axis], b); });
  VertexId* const middle = begin + (end - begin) / 2;
  OrderByDefinition(points, depths - 1, begin, middle);
  OrderByDefinition(points, depths - 1, middle, end);
}

TEST(KdTree, IsTheTreeOfTheDefinitionOnHardInput)
{
  for (const HardPoints& hard : AllHardPoints({ 1, 2, 3, 33, 700, 5000, 40000 }))
  {
    SCOPED_TRACE(hard.name + ", " + std::to_string(hard.points.size()));
    const auto tree = BuildKdTree(hard.points, { 100, {}, 8 });
    ASSERT_TRUE(tree);
    std::vector<VertexId> order(hard.points.size());
    std::iota(order.begin(), order.end(), 0U);
    OrderByDefinition(hard.points, tree->depths.finest, order.data(), order.data() + order.size());
    ASSERT_EQ(tree->order, order);
  }
}

TEST(KdTree, BoxesAreThoseOfTheVertices)
{
  for (const NamedMesh& named : AllMeshes())
  {
    SCOPED_TRACE(named.name);
    const auto tree = BuildKdTree(named.mesh.points, { 50, {}, 8 });
    ASSERT_TRUE(tree);
    for (unsigned d = 0; d <= tree->depths.partition; ++d)
    {
      for (std::size_t c = 0; c < std::size_t{ 1 } << d; ++c)
      {
        Box box;
        for (const VertexId v : tree->Cell(d, c))
        {
          box.Add(named.mesh.points[v]);
        }
        EXPECT_EQ(tree->boxes[(std::size_t{ 1 } << d) + c], box);
      }
    }
  }
}

TEST(KdTree, IsTheSameOnAnyNumberOfThreads)
{
  for (const NamedMesh& named : AllMeshes())
  {
    SCOPED_TRACE(named.name);
    const auto serial = BuildKdTree(named.mesh.points, { 50, {}, 8 });
    for (const unsigned threads : { 1U, 2U, 8U })
    {
      const auto parallel =
        BuildKdTree(named.mesh.points, { 50, {}, 8 }, MakeTbbExecution(threads));
      EXPECT_EQ(serial->order, parallel->order);
      EXPECT_EQ(serial->boxes, parallel->boxes);
    }
  }
}

TEST(KdTree, PartitionsWithoutLevelsAreThoseOfTheTree)
{
  for (const HardPoints& hard : AllHardPoints({ 1, 2, 3, 33, 700, 5000, 40000 }))
  {
    for (const KdTreeOptions& options : { KdTreeOptions{ 1, {}, 0 }, { 100, {}, 8 }, { 7, 1, 0 } })
    {
      SCOPED_TRACE(hard.name);
      const auto tree = BuildKdTree(hard.points, options);
      ASSERT_TRUE(tree);
      for (const unsigned threads : { 1U, 4U })
      {
        const auto clustering = ClusterByKdTree(hard.points, options, MakeTbbExecution(threads));
        ASSERT_TRUE(clustering);
        EXPECT_EQ(clustering->clusters, 1U << tree->depths.partition);
        EXPECT_EQ(clustering->clusterOf, CellOfVertex(*tree, tree->depths.partition));
      }
    }
  }
  const std::vector<Vec3> three(3);
  EXPECT_EQ(ClusterByKdTree(three, { 0, 4, 0 }).GetError().message,
    BuildKdTree(three, { 0, 4, 0 }).GetError().message);
}

TEST(KdTree, DepthsFollowTheRule)
{
  // n, N, cell vertices -> P, S, L
  const auto depths = [](std::size_t n, std::uint32_t size, std::uint32_t cell) {
    return *ComputeDepths(n, { size, {}, cell });
  };
  EXPECT_EQ(depths(437645, 2000, 8), (TreeDepths{ 8, 12, 16 }));
  EXPECT_EQ(depths(14027867, 2000, 8), (TreeDepths{ 13, 17, 21 }));
  EXPECT_EQ(depths(1, 2000, 8), (TreeDepths{ 0, 0, 0 }));
  EXPECT_EQ(depths(3, 2000, 8), (TreeDepths{ 0, 1, 1 }));
  EXPECT_EQ(depths(3, 1, 8), (TreeDepths{ 2, 2, 2 }));
  EXPECT_EQ(depths(2000, 2000, 8), (TreeDepths{ 0, 4, 10 }));
  EXPECT_EQ(depths(2001, 2000, 8), (TreeDepths{ 1, 5, 10 }));
  EXPECT_EQ(depths(100000, 2000, 1000), (TreeDepths{ 6, 10, 11 }));
  EXPECT_EQ(depths(100000, 2000, 0), (TreeDepths{ 6, 6, 6 }));
  EXPECT_EQ(ComputeDepths(100, { 2000, 64U, 8 })->partition, 6U);
}

TEST(KdTree, SaysWhatIsWrongWithOptions)
{
  const auto isRefused = [](const KdTreeOptions& options, std::string_view what)
  { return fixtures::FailsAt(ComputeDepths(100, options), ErrorCode::InvalidArgument, what); };
  EXPECT_TRUE(isRefused({ 2000, 48U, 8 }, "partitions 48"));
  EXPECT_TRUE(isRefused({ 2000, 0U, 8 }, "partitions 0"));
  EXPECT_TRUE(isRefused({ 2000, 128U, 8 }, "partitions 128"));
  EXPECT_TRUE(isRefused({ 0, {}, 8 }, "vertices per partition"));
  EXPECT_TRUE(isRefused({ 10, {}, 1025 }, "vertices per cell, 1025"));
  EXPECT_TRUE(fixtures::FailsAt(ComputeDepths(0, {}), ErrorCode::InvalidArgument, "no vertices"));
  EXPECT_TRUE(
    fixtures::FailsAt(ComputeDepths(noVertex, {}), ErrorCode::LimitExceeded, "4294967295"));
}

TEST(KdTree, StopsWhenCancelled)
{
  Execution execution;
  execution.progress = [](std::string_view, double) { return false; };
  const auto tree = BuildKdTree(Torus(40, 40).points, { 100, {}, 8 }, execution);
  ASSERT_FALSE(tree);
  EXPECT_EQ(tree.GetError().code, ErrorCode::Cancelled);
}
