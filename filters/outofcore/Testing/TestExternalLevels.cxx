// SPDX-License-Identifier: BSD-3-Clause
// The levels made out of core are compared with those made in memory: equal to the bit for any
// blocks.
#include "Testing/Fixtures/Attributes.h"
#include "Testing/Fixtures/Meshes.h"
#include "filters/core/levels/Levels.h"
#include "filters/outofcore/Testing/BlockTools.h"
#include "filters/outofcore/levels/ExternalLevels.h"
#include "filters/outofcore/mesh/CoincidentRanks.h"
#include "filters/outofcore/mesh/RankTuples.h"

#include <cmath>
#include <map>
#include <random>
#include <set>

using namespace kdstream;
using namespace kdstream::fixtures;
using namespace kdstream::testing;

namespace
{

constexpr std::uint64_t memory = 1 << 20;

MeshBlocks BlocksOf(SpilledTree<double>& spilled, unsigned depth)
{
  MeshBlocks mesh;
  mesh.depths = spilled.tree.depths;
  mesh.vertexCount = spilled.vertices.count;
  mesh.triangleCount = static_cast<std::uint32_t>(spilled.mesh.triangles.size());
  mesh.box = spilled.tree.boxes[1];
  mesh.floats = false;
  mesh.blockDepth = depth;
  mesh.records = std::move(spilled.records);
  mesh.triangles.emplace(spilled.Cells(depth, memory));
  mesh.scalarType = spilled.mesh.scalarType;
  mesh.attributes = spilled.attributes;
  if (spilled.vertices.tupleBytes > 0)
  {
    mesh.pointTuples = std::move(*SortTuplesByRank(
      spilled.folder, spilled.vertices.tuples, spilled.vertices.tupleBytes, spilled.ranks, memory));
  }
  return mesh;
}

void CheckLevel(const ClusterLevel& expected, const LevelFile& level)
{
  const auto clusters = ReadBack<ClusterRecord>(level.clusters);
  ASSERT_EQ(clusters.size(), expected.lowest.size());
  ASSERT_EQ(level.ClusterCount(), clusters.size());
  for (std::size_t c = 0; c < clusters.size(); ++c)
  {
    ASSERT_EQ(clusters[c].position, expected.positions[c]) << "cluster " << c;
    ASSERT_EQ(clusters[c].geometricError, expected.geometricErrors[c]) << "cluster " << c;
    ASSERT_EQ(clusters[c].lowest, expected.lowest[c]) << "cluster " << c;
  }
  if (level.parents.IsOpen() || !expected.parents.empty())
  {
    EXPECT_EQ(ReadBack<VertexId>(level.parents), expected.parents);
  }
  EXPECT_EQ(*LoadAllTriangles(level), expected.triangles);
  for (std::size_t block = 0; block < level.BlockCount(); ++block)
  {
    const VertexId begin = level.begin[block], end = level.begin[block + 1];
    std::vector<Triangle> touching;
    std::copy_if(expected.triangles.begin(), expected.triangles.end(), std::back_inserter(touching),
      [&](const Triangle& t) {
        return std::any_of(t.begin(), t.end(), [&](VertexId c) { return c >= begin && c < end; });
      });
    const LevelBlock loaded = *LoadLevelBlock(level, block);
    ASSERT_EQ(loaded.triangles.size(), touching.size());
    for (std::size_t t = 0; t < touching.size(); ++t)
    {
      for (std::size_t k = 0; k < 3; ++k)
      {
        ASSERT_EQ(loaded.clusters[loaded.triangles[t][k]], touching[t][k]);
      }
    }
  }
}

std::vector<std::byte> MeansOf(const ClusterLevel& level)
{
  Mesh arrays;
  arrays.attributes = level.attributes;
  return TuplesOf(arrays, AttributeAssociation::Point, level.lowest.size());
}

// A way to make levels.
struct Way
{
  std::string name;
  LevelOptions options{};
  bool weld = true;
};

std::vector<Way> ClusterWays()
{
  LevelOptions cluster;
  cluster.maker = LevelMaker::Cluster;
  LevelOptions paper = cluster;
  paper.representative = Representative::Mean;
  paper.byComponents = false;
  LevelOptions mean = cluster;
  mean.representative = Representative::Mean;
  return { { "clusters", cluster }, { "clusters, not welded", cluster, false },
    { "mean, no sheets", paper }, { "mean, not welded", mean, false } };
}

void CheckLevels(const NamedMesh& named, std::uint32_t verticesPerPartition,
  std::uint32_t cellVertices, const std::vector<unsigned>& blockDepths, const Way& way = {},
  unsigned* firstInFiles = nullptr)
{
  SCOPED_TRACE(named.name + " " + way.name);
  SpilledTree<double> spilled(named.mesh, memory, verticesPerPartition, cellVertices, way.weld);
  const auto partition = CellOfVertex(spilled.tree, spilled.tree.depths.partition);
  const TriangleBuckets buckets = BucketTriangles(spilled.mesh.triangles,
    std::size_t{ 1 } << spilled.tree.depths.partition, [&](VertexId v) { return partition[v]; });
  const ClusterLevels expected = *BuildLevels(spilled.mesh, spilled.tree, buckets, way.options);
  for (const unsigned wanted : blockDepths)
  {
    const unsigned depth = std::min(wanted, spilled.tree.depths.partition);
    SCOPED_TRACE("blocks of depth " + std::to_string(depth));
    MeshBlocks mesh = BlocksOf(spilled, depth);
    mesh.mayCoincide = !way.weld || spilled.vertices.tupleBytes > 0;
    const Result<ExternalLevels> levels = BuildExternalLevels(spilled.folder, mesh, way.options);
    spilled.records = std::move(mesh.records);
    ASSERT_TRUE(levels) << levels.GetError().message;
    const auto clusterOfRank = ReadBack<VertexId>(levels->clusterOfRank);
    for (std::size_t rank = 0; rank < clusterOfRank.size(); ++rank)
    {
      ASSERT_EQ(clusterOfRank[rank], expected.finest[spilled.tree.order[rank]]);
    }
    ASSERT_EQ(levels->coarse.size(), levels->firstInFiles);
    ASSERT_LE(levels->firstInFiles, spilled.tree.depths.stitch);
    if (firstInFiles)
    {
      *firstInFiles = levels->firstInFiles;
    }
    for (unsigned d = 0; d <= spilled.tree.depths.finest; ++d)
    {
      SCOPED_TRACE("level " + std::to_string(d));
      if (d >= levels->firstInFiles)
      {
        CheckLevel(expected.levels[d], levels->files[d]);
        const SpillFile& tuples = levels->files[d].tuples;
        EXPECT_EQ(tuples.IsOpen() ? ReadBack<std::byte>(tuples) : std::vector<std::byte>(),
          MeansOf(expected.levels[d]));
        continue;
      }
      const ClusterLevel& coarse = levels->coarse[d];
      EXPECT_EQ(coarse.positions, expected.levels[d].positions);
      EXPECT_EQ(coarse.geometricErrors, expected.levels[d].geometricErrors);
      EXPECT_EQ(coarse.lowest, expected.levels[d].lowest);
      EXPECT_EQ(coarse.parents, expected.levels[d].parents);
      EXPECT_EQ(coarse.triangles, expected.levels[d].triangles);
      EXPECT_EQ(coarse.attributes, expected.levels[d].attributes);
    }
  }
}

// Vertices on a grid of side^3 places. Most vertices share their place with others all over the
// tree. Some zeros are negative.
Mesh OnGrid(Mesh mesh, double side)
{
  std::size_t zeros = 0;
  for (Vec3& p : mesh.points)
  {
    for (double& x : p)
    {
      x = std::round(x * side / 2);
      x = x == 0 && ++zeros % 3 == 0 ? -0.0 : std::abs(x);
    }
  }
  return mesh;
}

// Small arrays of every kind that levels carry. The lengths of the normals differ so much that the
// order in which they are added matters.
Mesh WithColors(Mesh mesh, std::uint32_t seed)
{
  std::mt19937 random(seed);
  const std::size_t count = mesh.points.size();
  Attribute normals{ { "Normals", AttributeType::Float64, AttributeAssociation::Point, 3 }, {} };
  Attribute colors{ { "RGB", AttributeType::UInt8, AttributeAssociation::Point, 3 }, {} };
  normals.values.resize(count * normals.TupleSize());
  colors.values.resize(count * colors.TupleSize());
  for (std::size_t i = 0; i < count; ++i)
  {
    for (std::size_t k = 0; k < 3; ++k)
    {
      normals.Set(i, k, std::ldexp(double(random() % 2000) - 1000, -int(random() % 40)));
      colors.Set(i, k, double(random() % 256));
    }
  }
  mesh.attributes = { std::move(normals), std::move(colors) };
  return mesh;
}

// Triangles between random vertices: so a level of few clusters still has nearly as many triangles.
Mesh Knot(VertexId vertices, std::size_t triangles)
{
  Mesh mesh = Soup(vertices / 3, 2);
  std::mt19937 random(6);
  mesh.triangles.resize(triangles);
  for (Triangle& t : mesh.triangles)
  {
    while (t[0] == t[1] || t[1] == t[2] || t[2] == t[0])
    {
      std::generate(t.begin(), t.end(), [&] { return static_cast<VertexId>(random() % vertices); });
    }
  }
  return mesh;
}

Mesh WithoutTriangles(Mesh mesh)
{
  mesh.triangles.clear();
  return mesh;
}

// Side by side along x: a plane of 128 x 128 vertices, a rough plane half as wide (64 x 128), and a
// soup of tetrahedra with the same number of vertices as the rough plane. So the first half of the
// tree's vertices are those of the plane.
Mesh PlaneAndRoughAndBodies()
{
  std::mt19937 random(9);
  const auto unit = [&] { return double(random() % 65536) / 65536; };
  Mesh mesh;
  const auto addGrid = [&](std::size_t columns, double begin, double roughness)
  {
    constexpr std::size_t rows = 128;
    const auto first = static_cast<VertexId>(mesh.points.size());
    for (std::size_t i = 0; i < columns * rows; ++i)
    {
      mesh.points.push_back(
        { begin + double(i / rows) / 64, double(i % rows) / 128, roughness * unit() });
    }
    for (std::size_t i = 0; i + rows < columns * rows; ++i)
    {
      if (i % rows + 1 < rows)
      {
        const VertexId a = first + static_cast<VertexId>(i), c = a + VertexId{ rows };
        mesh.triangles.push_back({ a, c, a + 1 });
        mesh.triangles.push_back({ a + 1, c, c + 1 });
      }
    }
  };
  addGrid(128, 0, 0);
  addGrid(64, 2, 0.005);
  for (std::size_t i = 0; i < 2048; ++i)
  {
    const auto a = static_cast<VertexId>(mesh.points.size());
    for (std::size_t k = 0; k < 4; ++k)
    {
      mesh.points.push_back({ 3.01 + unit(), unit(), unit() });
    }
    for (const Triangle& t : { Triangle{ 0, 1, 2 }, { 0, 2, 3 }, { 0, 3, 1 }, { 1, 3, 2 } })
    {
      mesh.triangles.push_back({ a + t[0], a + t[1], a + t[2] });
    }
  }
  return mesh;
}

std::vector<PointRecord<double>> RecordsOnGrid(std::size_t count, int side)
{
  std::mt19937 random(side);
  std::vector<PointRecord<double>> records(count);
  for (PointRecord<double>& record : records)
  {
    for (double& x : record.p)
    {
      x = double(int(random() % side)) * (random() % 2 == 0 ? 1 : -1);
    }
    record.id = static_cast<VertexId>(random());
  }
  return records;
}

template <class Scalar>
void CheckPairs(const std::vector<PointRecord<double>>& points, std::uint64_t limit)
{
  std::vector<PointRecord<Scalar>> records;
  std::set<std::pair<VertexId, VertexId>> expected;
  std::map<Vec3, VertexId> last;
  for (VertexId rank = 0; rank < points.size(); ++rank)
  {
    const Vec3& p = points[rank].p;
    records.push_back({ { Scalar(p[0]), Scalar(p[1]), Scalar(p[2]) }, points[rank].id });
    const auto [found, isNew] = last.try_emplace(p, rank);
    if (!isNew)
    {
      expected.emplace(std::exchange(found->second, rank), rank);
    }
  }
  SpillFolder folder = MakeSpillFolder();
  const SpillFile file = Spilled(folder, records);
  std::set<std::pair<VertexId, VertexId>> pairs;
  ASSERT_TRUE(
    ForEachCoincidentPair<Scalar>(folder, file, static_cast<std::uint32_t>(records.size()), limit,
      [&](VertexId a, VertexId b) -> Status
      {
        EXPECT_TRUE(pairs.emplace(a, b).second);
        return {};
      }));
  EXPECT_EQ(pairs, expected);
}

}

TEST(CoincidentRanks, ChainsInTheOrderOfRanks)
{
  for (const int side : { 1, 3, 40 })
  {
    for (const std::uint64_t limit : { 1 << 9, 1 << 14, 1 << 24 })
    {
      SCOPED_TRACE("side " + std::to_string(side) + ", memory " + std::to_string(limit));
      CheckPairs<double>(RecordsOnGrid(20000, side), limit);
      CheckPairs<float>(RecordsOnGrid(20000, side), limit);
    }
  }
}

TEST(ExternalLevels, AsInMemory)
{
  for (const NamedMesh& named : AllMeshes())
  {
    CheckLevels(named, 60, 8, { 0, 2, 31 });
  }
}

TEST(ExternalLevels, ClustersAsInMemory)
{
  for (const NamedMesh& named : AllMeshes())
  {
    for (const Way& way : ClusterWays())
    {
      CheckLevels(named, 60, 8, { 0, 2, 31 }, way);
    }
  }
}

// Trees that are deep enough for rounds by blocks.
TEST(ExternalLevels, ClustersByBlocks)
{
  const Mesh surface = WithColors(Shuffled(Torus(300, 150), 4), 3);
  const std::vector<Way> ways = ClusterWays();
  for (const Way& way : ways)
  {
    CheckLevels({ "torus", surface }, 500, 2, { 0, 2, 5 }, way);
  }
  CheckLevels({ "cloud", Cloud(6) }, 1000, 1, { 1, 5 });
  CheckLevels({ "cloud", WithoutTriangles(surface) }, 20, 1, { 4, 31 });
  CheckLevels({ "soup", Soup(20000, 5) }, 1000, 2, { 3 }, ways[0]);
  CheckLevels({ "soup", Soup(20000, 5) }, 1000, 2, { 3 }, ways[2]);
}

// Vertices in one place are connected across blocks.
TEST(ExternalLevels, CoincidentInOtherBlocks)
{
  for (const double side : { 2.0, 8.0, 40.0 })
  {
    for (const Way& way : ClusterWays())
    {
      CheckLevels({ "soup", OnGrid(Soup(12000, 7), side) }, 400, 2, { 1, 5 }, way);
    }
    const Way cloud{ "not welded", {}, false };
    CheckLevels({ "cloud", OnGrid(Cloud(6), side) }, 400, 1, { 0, 5 }, cloud);
  }
}

// Trees that are deep enough for rounds by blocks.
TEST(ExternalLevels, RoundsByBlocks)
{
  CheckLevels({ "sphere", DisplacedSphere(7) }, 1000, 8, { 0, 1, 3, 5 });
  CheckLevels({ "shuffled", WithColors(Shuffled(Torus(400, 200), 4), 3) }, 500, 4, { 2, 4 });
  CheckLevels({ "soup", Soup(30000, 5) }, 1000, 8, { 3 });
}

// The bodies in one node cannot collapse, so the node would hold too many clusters. It must then
// take more merges, in a block that is not the first one, and only from some of the block's parts.
TEST(ExternalLevels, AFullNodeOfALaterBlockTakesMore)
{
  CheckLevels({ "plane, rough and bodies", PlaneAndRoughAndBodies() }, 4096, 4, { 0, 1, 2 });
}

// Every block is given all triangles; each triangle must be counted once.
TEST(ImageWriter, CountsEachTriangleOnce)
{
  constexpr VertexId clusters = 40;
  std::mt19937 random(9);
  std::vector<Triangle> any(3000); // with degenerate, repeated and rotated ones
  for (Triangle& t : any)
  {
    std::generate(t.begin(), t.end(), [&] { return static_cast<VertexId>(random() % clusters); });
  }
  SpillFolder folder = MakeSpillFolder();
  LevelFile level;
  level.blockDepth = 2;
  level.begin = { 0, 7, 7, 30, clusters };
  ImageWriter writer(folder, level);
  ASSERT_TRUE(writer.Begin(0));
  for (std::size_t block = 0; block < level.BlockCount(); ++block)
  {
    std::vector<Triangle> mapped = any;
    ASSERT_TRUE(writer.Add(mapped));
  }
  std::set<Triangle> once;
  for (const Triangle& t : any)
  {
    if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0])
    {
      once.insert(RotateLowestFirst(t));
    }
  }
  EXPECT_EQ(writer.TriangleCount(), once.size());
  const auto all = LoadAllTriangles(level);
  ASSERT_TRUE(all) << all.GetError().message;
  EXPECT_EQ(*all, std::vector<Triangle>(once.begin(), once.end()));
}

TEST(ExternalLevels, LargeLevelsBelowStitch)
{
  unsigned firstInFiles = 0;
  CheckLevels({ "sphere", DisplacedSphere(7) }, 20, 1, { 0, 4 }, {}, &firstInFiles);
  EXPECT_EQ(firstInFiles, 16U);
  // Small bodies: too many remain to be collapsed freely.
  CheckLevels({ "tetrahedra", Tetrahedra(40000) }, 20, 1, { 0, 3 }, {}, &firstInFiles);
  EXPECT_LT(firstInFiles, 16U);
  // Few clusters, but too many triangles.
  CheckLevels({ "knot", Knot(3000, 820000) }, 20, 1, { 3 }, {}, &firstInFiles);
  EXPECT_LT(firstInFiles, 12U);
}
