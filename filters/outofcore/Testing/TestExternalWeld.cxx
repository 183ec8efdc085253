// SPDX-License-Identifier: BSD-3-Clause
#include "Testing/Fixtures/Attributes.h"
#include "Testing/Fixtures/HardPoints.h"
#include "Testing/Fixtures/Meshes.h"
#include "filters/core/Weld.h"
#include "filters/outofcore/Testing/SpillTools.h"
#include "filters/outofcore/mesh/ExternalWeld.h"

#include <cstring>
#include <random>

using namespace kdstream;
using namespace kdstream::fixtures;
using namespace kdstream::testing;

namespace
{

// For each vertex its tuples of all point arrays, one array after the other.
std::vector<std::byte> TuplesOf(const Mesh& mesh, std::size_t& tupleBytes)
{
  std::vector<std::byte> bytes;
  tupleBytes = 0;
  for (const Attribute& array : mesh.attributes)
  {
    tupleBytes += array.association == AttributeAssociation::Point ? array.TupleSize() : 0;
  }
  for (std::size_t v = 0; v < mesh.points.size(); ++v)
  {
    for (const Attribute& array : mesh.attributes)
    {
      if (array.association == AttributeAssociation::Point)
      {
        for (const std::uint8_t byte : TupleOf(array, v))
        {
          bytes.push_back(static_cast<std::byte>(byte));
        }
      }
    }
  }
  return bytes;
}

// Checks that the result equals core's, bit for bit, from almost no memory to enough.
void CompareWithCore(const std::string& name, const Mesh& mesh)
{
  // One triangle at each vertex shows which number welding gave the vertex.
  Mesh welded = mesh;
  welded.triangles.clear();
  for (VertexId v = 0; v < mesh.points.size(); ++v)
  {
    welded.triangles.push_back({ v, v, v });
  }
  const std::size_t went = WeldVertices(welded);
  std::size_t ignored = 0;
  const std::vector<std::byte> tuples = TuplesOf(welded, ignored);

  for (const std::uint64_t memory : { 300, 5000, 1 << 26 })
  {
    SCOPED_TRACE(name + ", memory " + std::to_string(memory));
    SpillFolder folder = MakeSpillFolder();
    VertexFiles files;
    files.count = static_cast<std::uint32_t>(mesh.points.size());
    files.points = Spilled(folder, mesh.points);
    const std::vector<std::byte> all = TuplesOf(mesh, files.tupleBytes);
    if (files.tupleBytes > 0)
    {
      files.tuples = Spilled(folder, all);
    }
    Result<ExternalWeld> external = WeldExternally(folder, std::move(files), memory);
    ASSERT_TRUE(external) << external.GetError().message;
    EXPECT_EQ(external->welded, went);
    ASSERT_EQ(external->vertices.count, welded.points.size());
    const std::vector<Vec3> points = ReadBack<Vec3>(external->vertices.points);
    ASSERT_EQ(points.size(), welded.points.size());
    EXPECT_EQ(std::memcmp(points.data(), welded.points.data(), points.size() * sizeof(Vec3)), 0);
    if (external->vertices.tupleBytes > 0)
    {
      EXPECT_EQ(ReadBack<std::byte>(external->vertices.tuples), tuples);
    }
    ASSERT_EQ(external->map.has_value(), went > 0);
    if (external->map)
    {
      const std::vector<VertexId> map = ReadBack<VertexId>(external->map->file);
      ASSERT_EQ(map.size(), mesh.points.size());
      for (VertexId v = 0; v < map.size(); ++v)
      {
        ASSERT_EQ(map[v], welded.triangles[v][0]) << "vertex " << v;
      }
    }
  }
}

}

TEST(ExternalWeld, AsInMemory)
{
  for (const NamedMesh& named : AllMeshes())
  {
    CompareWithCore(named.name, named.mesh);
  }
  for (const HardPoints& hard : AllHardPoints({ 1, 7, 400 }))
  {
    Mesh mesh;
    mesh.points = hard.points;
    CompareWithCore(hard.name, mesh);
  }
}

// Some vertices in one place have equal tuples, some do not; -0.0 is not 0.0.
TEST(ExternalWeld, AsInMemoryWithAttributes)
{
  for (std::uint32_t seed = 0; seed < 8; ++seed)
  {
    Mesh mesh;
    std::mt19937 random(seed);
    for (int i = 0; i < 500; ++i)
    {
      const double x = double(random() % 4), y = random() % 2 == 0 ? 0.0 : -0.0;
      mesh.points.push_back({ x, y, 1 });
    }
    Attribute label;
    label.name = "label";
    label.type = AttributeType::UInt8;
    label.components = 3;
    label.association = AttributeAssociation::Point;
    for (std::size_t i = 0; i < 3 * mesh.points.size(); ++i)
    {
      label.values.push_back(static_cast<std::uint8_t>(random() % 2));
    }
    mesh.attributes.push_back(label);
    CompareWithCore("labels", mesh);
    CompareWithCore("attributes", WithAttributes(DisplacedSphere(2), seed));
  }
}

TEST(ExternalWeld, NothingInTheFolderIsLeft)
{
  const Mesh mesh = Soup(300, 1);
  SpillFolder folder = MakeSpillFolder();
  {
    VertexFiles files;
    files.count = static_cast<std::uint32_t>(mesh.points.size());
    files.points = Spilled(folder, mesh.points);
    EXPECT_TRUE(WeldExternally(folder, std::move(files), 1000));
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder.Path()));
  EXPECT_EQ(folder.Counts().bytesOnDisk, 0U);
}

TEST(ExternalWeld, Cancelled)
{
  const Mesh mesh = Soup(300, 1);
  for (int most = 0; most < 5; ++most)
  {
    SpillFolder folder = MakeSpillFolder();
    VertexFiles files;
    files.count = static_cast<std::uint32_t>(mesh.points.size());
    files.points = Spilled(folder, mesh.points);
    Execution execution;
    int reports = 0;
    execution.progress = [&](std::string_view step, double done)
    {
      EXPECT_EQ(step, "weld");
      EXPECT_GE(done, 0);
      EXPECT_LE(done, 1);
      return reports++ < most;
    };
    const Result<ExternalWeld> welded = WeldExternally(folder, std::move(files), 1000, execution);
    ASSERT_FALSE(welded);
    EXPECT_EQ(welded.GetError().code, ErrorCode::Cancelled);
  }
}
