// SPDX-License-Identifier: BSD-3-Clause
// Gathering reorders a mesh, and changes nothing else.
#include "Testing/Fixtures/Attributes.h"
#include "Testing/Fixtures/Meshes.h"
#include "filters/core/tree/GatherMesh.h"
#include "filters/program/TbbExecution.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

using namespace kdstream;
using namespace kdstream::fixtures;

namespace
{

KdTreeOptions SmallPartitions()
{
  KdTreeOptions options;
  options.verticesPerPartition = 60;
  return options;
}

std::vector<NamedMesh> Meshes()
{
  std::vector<NamedMesh> meshes = AllMeshes();
  meshes.push_back({ "in no order", WithAttributes(Shuffled(DisplacedSphere(5), 4), 5) });
  meshes.push_back({ "equal coordinates", WithAttributes(Shuffled(GridPlate(40), 3), 6) });
  return meshes;
}

// The i-th tuple of an array.
std::span<const std::uint8_t> TupleOf(const Attribute& array, std::size_t i)
{
  return std::span(array.values).subspan(i * array.TupleSize(), array.TupleSize());
}

struct Gathered
{
  Mesh mesh;
  KdTree tree;
  GatheredMesh result;
};

// Each vertex is unchanged, and the vertices of a partition have consecutive numbers from its first
// place on, in the order of their ids.
void ExpectSameVertices(const Mesh& before, const KdTree& tree, const Gathered& gathered)
{
  const std::vector<VertexId>& ids = gathered.result.ids;
  ASSERT_EQ(ids.size(), before.points.size());
  ASSERT_EQ(gathered.mesh.points.size(), before.points.size());
  for (std::size_t v = 0; v < ids.size(); ++v)
  {
    ASSERT_EQ(gathered.mesh.points[v], before.points[ids[v]]) << v;
    ASSERT_EQ(ids[gathered.tree.order[v]], tree.order[v]) << v;
  }
  for (std::size_t p = 0; p < std::size_t{ 1 } << tree.depths.partition; ++p)
  {
    const std::span<const VertexId> cell = gathered.tree.Cell(tree.depths.partition, p);
    const auto first = static_cast<std::size_t>(cell.data() - gathered.tree.order.data());
    std::vector<VertexId> sorted(cell.begin(), cell.end()), expected(cell.size());
    std::sort(sorted.begin(), sorted.end());
    std::iota(expected.begin(), expected.end(), static_cast<VertexId>(first));
    EXPECT_EQ(sorted, expected) << p;
    const auto begin = ids.begin() + static_cast<std::ptrdiff_t>(first);
    EXPECT_TRUE(std::is_sorted(begin, begin + static_cast<std::ptrdiff_t>(cell.size()))) << p;
  }
}

// Each bucket has the same triangles in the same order, and no triangle is lost. Returns the old
// place of each triangle.
std::vector<std::uint32_t> ExpectSameBuckets(
  const Mesh& before, const KdTree& tree, const Gathered& gathered)
{
  const std::vector<std::uint32_t> partition = CellOfVertex(tree, tree.depths.partition);
  const TriangleBuckets old = BucketTriangles(before.triangles,
    std::size_t{ 1 } << tree.depths.partition, [&](VertexId v) { return partition[v]; });
  std::vector<std::uint32_t> was(before.triangles.size(), noVertex);
  EXPECT_EQ(gathered.mesh.triangles.size(), was.size());
  EXPECT_EQ(gathered.result.buckets.begin, old.begin);
  if (gathered.result.buckets.begin != old.begin)
  {
    return was;
  }
  for (std::size_t i = 0; i < old.triangles.size(); ++i)
  {
    const Triangle& moved = gathered.mesh.triangles[gathered.result.buckets.triangles[i]];
    Triangle corners;
    std::transform(moved.begin(), moved.end(), corners.begin(),
      [&](VertexId v) { return gathered.result.ids[v]; });
    EXPECT_EQ(corners, before.triangles[old.triangles[i]]) << i;
    was[gathered.result.buckets.triangles[i]] = old.triangles[i];
  }
  std::vector<std::uint32_t> sorted = was, all(was.size());
  std::sort(sorted.begin(), sorted.end());
  std::iota(all.begin(), all.end(), 0U);
  EXPECT_EQ(sorted, all);
  return was;
}

void ExpectSameArrays(
  const Mesh& before, const Gathered& gathered, std::span<const std::uint32_t> was)
{
  ASSERT_EQ(gathered.mesh.attributes.size(), before.attributes.size());
  for (std::size_t a = 0; a < before.attributes.size(); ++a)
  {
    const Attribute& array = gathered.mesh.attributes[a];
    const Attribute& old = before.attributes[a];
    ASSERT_EQ(array.Info(), old.Info());
    ASSERT_EQ(array.values.size(), old.values.size());
    const std::span<const std::uint32_t> from =
      array.association == AttributeAssociation::Point ? gathered.result.ids : was;
    for (std::size_t i = 0; i < from.size(); ++i)
    {
      ASSERT_TRUE(std::ranges::equal(TupleOf(array, i), TupleOf(old, from[i]))) << a << " " << i;
    }
  }
}

}

TEST(GatherMesh, MovesEverythingAndKeepsTheOrderInsidePartitions)
{
  for (const NamedMesh& named : Meshes())
  {
    const Result<KdTree> tree = BuildKdTree(named.mesh.points, SmallPartitions());
    ASSERT_TRUE(tree) << tree.GetError().message;
    for (const unsigned threads : { 1U, 3U })
    {
      SCOPED_TRACE(named.name + ", threads " + std::to_string(threads));
      Gathered gathered{ named.mesh, *tree, {} };
      gathered.result = GatherMesh(gathered.mesh, gathered.tree, MakeTbbExecution(threads));
      ExpectSameVertices(named.mesh, *tree, gathered);
      ExpectSameArrays(named.mesh, gathered, ExpectSameBuckets(named.mesh, *tree, gathered));
    }
  }
}

TEST(GatherMesh, GatheredTrianglesLieByLowestPartition)
{
  Mesh mesh = Shuffled(DisplacedSphere(5), 4);
  Result<KdTree> tree = BuildKdTree(mesh.points, SmallPartitions());
  ASSERT_TRUE(tree);
  GatherMesh(mesh, *tree, MakeTbbExecution(3));
  const std::vector<std::uint32_t> partition = CellOfVertex(*tree, tree->depths.partition);
  EXPECT_TRUE(std::is_sorted(partition.begin(), partition.end()));
  EXPECT_TRUE(std::is_sorted(mesh.triangles.begin(), mesh.triangles.end(),
    [&](const Triangle& a, const Triangle& b)
    {
      return partition[*std::min_element(a.begin(), a.end())] <
             partition[*std::min_element(b.begin(), b.end())];
    }));
}

// It is enough that either triangles or vertices are scattered. A small mesh, or one in order, is
// not.
TEST(GatherMesh, SeesWhatIsScattered)
{
  constexpr VertexId vertices = 20000;
  std::vector<std::uint32_t> inOrder(vertices), inNone(vertices);
  std::vector<Triangle> follow(vertices - 2), jump(vertices - 2);
  for (VertexId v = 0; v < vertices; ++v)
  {
    inOrder[v] = v / 100;
    inNone[v] = v % 100;
  }
  for (VertexId t = 0; t < follow.size(); ++t)
  {
    follow[t] = { t, t + 1, t + 2 };
    jump[t] = { (t * 7919) % vertices, 0, 1 };
  }
  EXPECT_FALSE(IsScattered(follow, inOrder));
  EXPECT_TRUE(IsScattered(jump, inOrder));
  EXPECT_TRUE(IsScattered(follow, inNone));
  EXPECT_TRUE(IsScattered({}, inNone));
  EXPECT_FALSE(IsScattered({}, inOrder));
  EXPECT_FALSE(IsScattered({}, {}));
  EXPECT_FALSE(IsScattered(std::span(jump).first(1000), inOrder));
}
