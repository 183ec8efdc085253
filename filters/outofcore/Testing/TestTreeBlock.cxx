// The whole way from a mesh to blocks: spilled, welded, sorted by the tree, joined with its
// triangles, loaded; against the mesh in memory.
#include "Testing/Fixtures/Meshes.h"
#include "filters/core/Weld.h"
#include "filters/outofcore/CellTriangles.h"
#include "filters/outofcore/ExternalTree.h"
#include "filters/outofcore/ExternalWeld.h"
#include "filters/outofcore/Testing/SpillTools.h"
#include "filters/outofcore/TreeBlock.h"

#include <algorithm>

using namespace kdstream;
using namespace kdstream::fixtures;
using namespace kdstream::testing;

namespace
{

constexpr std::uint64_t memory = 20000; // less than most of the meshes take

template <class Scalar>
SpillFile RecordsOf(SpillFolder& folder, const SpillFile& points)
{
  std::vector<PointRecord<Scalar>> records;
  for (const Vec3& p : ReadBack<Vec3>(points))
  {
    records.push_back(
      { { Scalar(p[0]), Scalar(p[1]), Scalar(p[2]) }, static_cast<VertexId>(records.size()) });
  }
  return Spilled(folder, records);
}

// The triangles' file after welding.
SpillFile Renumbered(SpillFolder& folder, const SpillFile& triangles, std::size_t count,
  const std::optional<VertexMap>& map)
{
  std::vector<NumberedTriangle> renumbered;
  const auto add = [&](std::span<const NumberedTriangle> block) -> Status
  {
    renumbered.insert(renumbered.end(), block.begin(), block.end());
    return {};
  };
  if (!map)
  {
    return Spilled(folder, ReadBack<NumberedTriangle>(triangles));
  }
  EXPECT_TRUE(MapTriangles(folder, triangles, count, *map, memory, {}, add));
  return Spilled(folder, renumbered);
}

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
  SpillFolder folder = MakeSpillFolder();
  VertexFiles files;
  files.count = static_cast<std::uint32_t>(named.mesh.points.size());
  files.points = Spilled(folder, named.mesh.points);
  std::vector<NumberedTriangle> numbered;
  for (const Triangle& t : named.mesh.triangles)
  {
    numbered.push_back({ t, static_cast<std::uint32_t>(numbered.size()) });
  }
  const Result<ExternalWeld> welded = WeldExternally(folder, std::move(files), memory);
  ASSERT_TRUE(welded);
  const SpillFile triangles =
    Renumbered(folder, Spilled(folder, numbered), numbered.size(), welded->map);

  Mesh mesh = named.mesh;
  WeldVertices(mesh);
  KdTreeOptions options;
  options.verticesPerPartition = 60;
  const KdTree tree = std::move(*BuildKdTree(mesh.points, options));

  SpillFile records = RecordsOf<Scalar>(folder, welded->vertices.points);
  ExternalTreeOptions external;
  external.memory = 1 << 20;
  const auto sorted = BuildExternalTree<Scalar>(folder, records, tree.depths, external);
  ASSERT_TRUE(sorted) << sorted.GetError().message;
  const auto ranks = RankVertices<Scalar>(folder, sorted->records, welded->vertices.count, memory);
  ASSERT_TRUE(ranks);
  for (const unsigned depth : { 0U, std::min(2U, tree.depths.partition), tree.depths.partition })
  {
    const auto cells =
      SortTrianglesIntoCells(folder, triangles, numbered.size(), *ranks, depth, memory);
    ASSERT_TRUE(cells);
    for (std::size_t cell = 0; cell < cells->BucketCount(); ++cell)
    {
      const auto block =
        LoadBlock<Scalar>(sorted->records, welded->vertices.count, *cells, depth, cell);
      ASSERT_TRUE(block) << block.GetError().message;
      CheckBlock(*block, mesh, tree, depth);
    }
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
