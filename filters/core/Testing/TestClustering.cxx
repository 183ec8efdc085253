// SPDX-License-Identifier: BSD-3-Clause
// Turns any clustering into a tree, and into one level of a mesh.
#include "Testing/Fixtures/ErrorAt.h"
#include "filters/core/levels/SimplifyByClusters.h"
#include "filters/core/pieces/Glue.h"
#include "filters/core/pieces/VertexTree.h"
#include "filters/core/tree/Clustering.h"

#include "Testing/Fixtures/Invariants.h"
#include "Testing/Fixtures/Meshes.h"

#include <gtest/gtest.h>

#include <random>

namespace kdstream
{
namespace
{

using namespace fixtures;

// Clusters of any size and shape: random labels, of which some do not occur.
Clustering RandomClustering(std::size_t vertices, std::uint32_t labels, std::mt19937& random)
{
  std::vector<std::int64_t> drawn(vertices);
  for (std::int64_t& label : drawn)
  {
    label = static_cast<std::int64_t>(random() % labels) * 7 - 11;
  }
  return ClusteringOfLabels(drawn);
}

TEST(Clustering, LabelsAreNumberedInTheirOrder)
{
  const std::vector<std::int64_t> labels{ 40, -3, 40, 1LL << 40, 0 };
  const Clustering clustering = ClusteringOfLabels(labels);
  EXPECT_EQ(clustering.clusters, 4U);
  EXPECT_EQ(clustering.clusterOf, (std::vector<std::uint32_t>{ 2, 0, 2, 3, 1 }));
  EXPECT_EQ(ClusteringOfLabels({}).clusters, 0U);
}

TEST(Clustering, ATreeHasTheClustersAsItsPartitions)
{
  std::mt19937 random(3);
  for (const NamedMesh& named : AllMeshes())
  {
    SCOPED_TRACE(named.name);
    const std::vector<Vec3>& points = named.mesh.points;
    for (const std::uint32_t labels : { 1U, 5U, 64U, 301U })
    {
      const Clustering clustering = RandomClustering(points.size(), labels, random);
      const KdTree tree = TreeOfClustering(points, clustering);
      const std::size_t cells = std::size_t{ 1 } << tree.depths.partition;
      ASSERT_GE(cells, clustering.clusters);
      ASSERT_TRUE(cells == 1 || cells / 2 < clustering.clusters);
      ASSERT_EQ(tree.order.size(), points.size());
      ASSERT_EQ(tree.boxes.size(), 2 * cells);
      Box whole;
      for (std::size_t c = 0; c < cells; ++c)
      {
        Box box;
        const auto cell = tree.Cell(tree.depths.partition, c);
        EXPECT_TRUE(std::is_sorted(cell.begin(), cell.end()));
        EXPECT_EQ(cell.empty(), c >= clustering.clusters);
        for (const VertexId v : cell)
        {
          EXPECT_EQ(clustering.clusterOf[v], c);
          box.Add(points[v]);
        }
        EXPECT_EQ(tree.boxes[cells + c], box);
        whole.Add(box);
      }
      EXPECT_EQ(tree.boxes[1], whole);
      for (std::size_t node = 1; node < cells; ++node)
      {
        Box both = tree.boxes[2 * node];
        both.Add(tree.boxes[2 * node + 1]);
        EXPECT_EQ(tree.boxes[node], both);
      }
    }
  }
}

TEST(Clustering, PiecesOfItsTreeGlueToTheMesh)
{
  std::mt19937 random(9);
  for (const NamedMesh& named : AllMeshes())
  {
    SCOPED_TRACE(named.name);
    const Mesh& mesh = named.mesh;
    const Clustering clustering = RandomClustering(mesh.points.size(), 21, random);
    const KdTree tree = TreeOfClustering(mesh.points, clustering);
    const VertexTree numbered = NumberVertices(tree, {});
    const PieceCutter cutter(numbered, mesh, Resolution::Original());
    std::vector<Piece> pieces;
    for (std::size_t i = 0; i < clustering.clusters; ++i)
    {
      pieces.push_back(cutter.Cut(i));
      EXPECT_TRUE(CheckPiece(pieces.back(), tree.depths));
      EXPECT_EQ(pieces.back().ownVertices, tree.Cell(tree.depths.partition, i).size());
    }
    const Result<Mesh> glued = GluePartitions(pieces, mesh.scalarType);
    ASSERT_TRUE(glued);
    EXPECT_EQ(PointMultiset(*glued), PointMultiset(mesh));
    EXPECT_EQ(TriangleMultiset(*glued), TriangleMultiset(mesh));
  }
}

TEST(SimplifyByClusters, CellsOfATreeGiveItsFinestLevel)
{
  for (const NamedMesh& named : AllMeshes())
  {
    for (const bool byComponents : { true, false })
    {
      SCOPED_TRACE(named.name + (byComponents ? ", sheets" : ""));
      const Mesh& mesh = named.mesh;
      const KdTree tree = *BuildKdTree(mesh.points, { 100, {}, 8 });
      ClusterOptions options;
      options.byComponents = byComponents;
      options.coarsestDepth = tree.depths.finest;
      const std::vector<std::uint32_t> partition = CellOfVertex(tree, tree.depths.partition);
      const TriangleBuckets buckets = BucketTriangles(mesh.triangles,
        std::size_t{ 1 } << tree.depths.partition, [&](VertexId v) { return partition[v]; });
      const ClusterLevel expected =
        BuildClusterLevels(mesh.points, mesh.triangles, tree, buckets, options)->levels.back();

      const std::vector<std::uint32_t> cell = CellOfVertex(tree, tree.depths.finest);
      const Clustering clustering =
        ClusteringOfLabels(std::vector<std::int64_t>(cell.begin(), cell.end()));
      const Result<ClusterLevel> level = SimplifyByClusters(mesh, clustering, options);
      ASSERT_TRUE(level);
      EXPECT_EQ(level->positions, expected.positions);
      EXPECT_EQ(level->geometricErrors, expected.geometricErrors);
      EXPECT_EQ(level->triangles, expected.triangles);
    }
  }
}

TEST(SimplifyByClusters, TrianglesAreTheImageAndPointsLieInTheirClusters)
{
  std::mt19937 random(5);
  for (const NamedMesh& named : AllMeshes())
  {
    SCOPED_TRACE(named.name);
    const Mesh& mesh = named.mesh;
    const Clustering clustering = RandomClustering(mesh.points.size(), 97, random);
    ClusterOptions options;
    options.byComponents = false;
    const Result<ClusterLevel> level = SimplifyByClusters(mesh, clustering, options);
    ASSERT_TRUE(level);
    ASSERT_EQ(level->positions.size(), clustering.clusters);
    EXPECT_EQ(level->triangles, ImageOfTriangles(mesh.triangles, clustering.clusterOf));
    std::vector<Box> boxes(clustering.clusters);
    for (std::size_t v = 0; v < mesh.points.size(); ++v)
    {
      boxes[clustering.clusterOf[v]].Add(mesh.points[v]);
    }
    for (std::size_t c = 0; c < boxes.size(); ++c)
    {
      Box with = boxes[c];
      with.Add(level->positions[c]);
      EXPECT_EQ(with, boxes[c]);
    }
  }
}

TEST(SimplifyByClusters, RefusesWhatIsNotAClusteringOfTheMesh)
{
  const Mesh mesh = Torus(6, 4);
  Clustering clustering{ std::vector<std::uint32_t>(23, 0), 1 };
  EXPECT_TRUE(
    fixtures::FailsAt(SimplifyByClusters(mesh, clustering, {}), ErrorCode::InvalidArgument));
  clustering.clusterOf.assign(24, 0);
  clustering.clusterOf[5] = 3;
  EXPECT_TRUE(fixtures::FailsAt(
    SimplifyByClusters(mesh, clustering, {}), ErrorCode::InvalidArgument, "vertex 5"));
  EXPECT_TRUE(SimplifyByClusters({}, {}, {})->positions.empty());
}

}
}
