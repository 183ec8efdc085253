// SPDX-License-Identifier: BSD-3-Clause
// The whole way from a mesh to blocks: spilled, welded, sorted by the tree, joined with its
// triangles, and loaded; then compared with the mesh in memory.
#include "Testing/Fixtures/Meshes.h"
#include "filters/core/EdgeCount.h"
#include "filters/outofcore/Testing/BlockTools.h"

#include <algorithm>

using namespace kdstream;
using namespace kdstream::fixtures;
using namespace kdstream::testing;

namespace
{

constexpr std::uint64_t memory = 20000; // less than most of the meshes take

void CheckBlock(const TreeBlock& block, const Mesh& mesh, const KdTree& tree, unsigned depth)
{
  const auto own = tree.Cell(depth, block.cell);
  ASSERT_EQ(block.order.size(), own.size());
  ASSERT_TRUE(std::is_sorted(block.ids.begin(), block.ids.end()));
  for (std::size_t i = 0; i < own.size(); ++i)
  {
    ASSERT_EQ(block.ids[block.order[i]], own[i]);
    ASSERT_TRUE(block.IsOwn(block.order[i]));
  }
  std::size_t ghosts = 0;
  for (VertexId v = 0; v < block.ids.size(); ++v)
  {
    ASSERT_EQ(block.mesh.points[v], mesh.points[block.ids[v]]);
    ASSERT_EQ(tree.order[block.ranks[v]], block.ids[v]);
    ghosts += !block.IsOwn(v);
  }
  ASSERT_EQ(ghosts + own.size(), block.ids.size());

  const std::vector<std::uint32_t> cell = CellOfVertex(tree, depth);
  std::vector<std::uint32_t> expected;
  std::vector<std::uint8_t> used(mesh.points.size(), 0);
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
  {
    if (std::any_of(mesh.triangles[t].begin(), mesh.triangles[t].end(),
          [&](VertexId v) { return cell[v] == block.cell; }))
    {
      expected.push_back(t);
      std::for_each(mesh.triangles[t].begin(), mesh.triangles[t].end(),
        [&](VertexId v) { used[v] = cell[v] != block.cell; });
    }
  }
  ASSERT_EQ(block.numbers, expected);
  ASSERT_EQ(ghosts, static_cast<std::size_t>(std::count(used.begin(), used.end(), 1)));
  for (std::size_t i = 0; i < expected.size(); ++i)
  {
    for (std::size_t k = 0; k < 3; ++k)
    {
      ASSERT_EQ(block.ids[block.mesh.triangles[i][k]], mesh.triangles[expected[i]][k]);
    }
  }
}

template <class Scalar>
void CheckAllBlocks(const NamedMesh& named)
{
  SCOPED_TRACE(named.name);
  SpilledTree<Scalar> spilled(named.mesh, memory);
  const Mesh& mesh = spilled.mesh;
  const unsigned partition = spilled.tree.depths.partition;
  const std::size_t inconsistent = CountInconsistentEdges(mesh.triangles, mesh.points.size());
  for (const unsigned depth : { 0U, std::min(2U, partition), partition })
  {
    const auto cells = spilled.Cells(depth, memory);
    std::size_t inconsistentOfBlocks = 0;
    for (std::size_t cell = 0; cell < cells.BucketCount(); ++cell)
    {
      const auto block = spilled.Block(cells, depth, cell);
      ASSERT_TRUE(block) << block.GetError().message;
      CheckBlock(*block, mesh, spilled.tree, depth);
      inconsistentOfBlocks += CountInconsistentEdges(block->mesh.triangles,
        block->mesh.points.size(), {}, [&](VertexId v) { return block->IsOwn(v); });
    }
    EXPECT_EQ(inconsistentOfBlocks, inconsistent) << "in blocks of depth " << depth;
  }
}

}

TEST(TreeBlock, AsInMemory)
{
  for (const NamedMesh& named : AllMeshes())
  {
    CheckAllBlocks<double>(named);
  }
}

// Many inconsistent edges, all over the mesh.
TEST(TreeBlock, CountsInconsistentEdgesOfFlippedTriangles)
{
  for (NamedMesh named : ClosedMeshes())
  {
    for (std::size_t t = 0; t < named.mesh.triangles.size(); t += 7)
    {
      std::swap(named.mesh.triangles[t][0], named.mesh.triangles[t][1]);
    }
    ASSERT_GT(CountInconsistentEdges(named.mesh.triangles, named.mesh.points.size()), 50U);
    CheckAllBlocks<double>({ named.name, Shuffled(named.mesh, 5) });
  }
}

TEST(TreeBlock, AsInMemoryFromFloats)
{
  Mesh torus = Torus(40, 20);
  for (Vec3& p : torus.points)
  {
    p = { double(float(p[0])), double(float(p[1])), double(float(p[2])) };
  }
  CheckAllBlocks<float>({ "torus", torus });
  CheckAllBlocks<float>({ "shuffled torus", Shuffled(torus, 3) });
}
