// SPDX-License-Identifier: BSD-3-Clause
#include "Testing/Fixtures/Attributes.h"
#include "Testing/Fixtures/ErrorAt.h"
#include "Testing/Fixtures/Meshes.h"
#include "Testing/Fixtures/TemporaryFolder.h"
#include "filters/meshio/MeshWriter.h"
#include "filters/outofcore/Testing/SpillTools.h"
#include "filters/outofcore/mesh/MeshSpill.h"

#include <cstring>
#include <fstream>
#include <limits>

using namespace kdstream;
using namespace kdstream::fixtures;
using namespace kdstream::testing;

namespace
{

constexpr std::size_t all = std::numeric_limits<std::size_t>::max();

Mesh ReadWhole(const std::filesystem::path& file)
{
  Mesh mesh;
  const auto reader = std::move(*MeshReader::Open(file));
  EXPECT_TRUE(reader->ReadVertices(mesh, all));
  EXPECT_TRUE(reader->ReadTriangles(mesh, all));
  return mesh;
}

// The tuples as a spilled mesh stores them, taken array by array.
std::vector<std::byte> TuplesOf(const Mesh& mesh, const std::vector<AttributeInfo>& attributes,
  AttributeAssociation association, std::size_t count)
{
  std::vector<std::byte> bytes;
  for (std::size_t i = 0; i < count; ++i)
  {
    for (const AttributeInfo& wanted : attributes)
    {
      if (wanted.association == association)
      {
        for (const std::uint8_t byte : TupleOf(*FindAttribute(mesh.attributes, wanted), i))
        {
          bytes.push_back(static_cast<std::byte>(byte));
        }
      }
    }
  }
  return bytes;
}

void CompareWithMemory(
  const std::string& name, const std::filesystem::path& file, std::size_t chunkBytes = 1 << 20)
{
  SCOPED_TRACE(name);
  const Mesh mesh = ReadWhole(file);
  SpillFolder folder = MakeSpillFolder();
  const auto reader = std::move(*MeshReader::Open(file));
  const Result<SpilledMesh> spilled = SpillMesh(folder, *reader, chunkBytes);
  ASSERT_TRUE(spilled) << spilled.GetError().message;
  EXPECT_EQ(spilled->scalarType, mesh.scalarType);
  ASSERT_EQ(spilled->vertices.count, mesh.points.size());
  const auto points = ReadBack<Vec3>(spilled->vertices.points);
  ASSERT_EQ(points.size(), mesh.points.size());
  EXPECT_EQ(std::memcmp(points.data(), mesh.points.data(), points.size() * sizeof(Vec3)), 0);
  bool floats = true;
  for (const Vec3& p : mesh.points)
  {
    for (const double x : p)
    {
      floats = floats && double(float(x)) == x;
    }
  }
  EXPECT_EQ(spilled->fitFloats, floats);

  ASSERT_EQ(spilled->triangleCount, mesh.triangles.size());
  const auto triangles = ReadBack<NumberedTriangle>(spilled->triangles);
  for (std::uint32_t t = 0; t < triangles.size(); ++t)
  {
    ASSERT_EQ(triangles[t], (NumberedTriangle{ mesh.triangles[t], t }));
  }

  ASSERT_EQ(spilled->attributes.size(), mesh.attributes.size());
  if (spilled->vertices.tupleBytes > 0)
  {
    EXPECT_EQ(ReadBack<std::byte>(spilled->vertices.tuples),
      TuplesOf(mesh, spilled->attributes, AttributeAssociation::Point, mesh.points.size()));
  }
  if (spilled->cellTupleBytes > 0 && !mesh.triangles.empty())
  {
    EXPECT_EQ(ReadBack<std::byte>(spilled->cellTuples),
      TuplesOf(mesh, spilled->attributes, AttributeAssociation::Cell, mesh.triangles.size()));
  }
}

}

TEST(MeshSpill, AsInMemory)
{
  const fixtures::TemporaryFolder scratch;
  for (const NamedMesh& named : AllMeshes())
  {
    const std::filesystem::path file = scratch / "mesh.ply";
    ASSERT_TRUE(WriteMesh(file, named.mesh));
    CompareWithMemory(named.name, file);
    ASSERT_TRUE(WriteMesh(file, WithAttributes(named.mesh, 7)));
    CompareWithMemory(named.name + " with attributes", file);
  }
}

// More than one chunk of vertices and of triangles.
TEST(MeshSpill, InSeveralChunks)
{
  const fixtures::TemporaryFolder scratch;
  const std::filesystem::path file = scratch / "mesh.ply";
  const Mesh mesh = WithAttributes(Soup(900, 4), 4);
  ASSERT_TRUE(WriteMesh(file, mesh));
  for (const std::size_t chunkBytes : { 0, 1000, 20000 })
  {
    CompareWithMemory("soup", file, chunkBytes);
  }
}

TEST(MeshSpill, NoVertices)
{
  const fixtures::TemporaryFolder scratch;
  const std::filesystem::path file = scratch / "empty.ply";
  std::ofstream(file) << "ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\n"
                         "property float y\nproperty float z\nend_header\n";
  SpillFolder folder = MakeSpillFolder();
  const auto reader = std::move(*MeshReader::Open(file));
  const Result<SpilledMesh> spilled = SpillMesh(folder, *reader, 1 << 20);
  ASSERT_FALSE(spilled);
  EXPECT_TRUE(FailsAt(spilled, ErrorCode::InvalidInput));
  EXPECT_TRUE(std::filesystem::is_empty(folder.Path()));
}

// A header may promise more than the file holds. No disk space is allocated for the promise, and
// the error is the reader's.
TEST(MeshSpill, TruncatedBodyAfterALargeClaim)
{
  const fixtures::TemporaryFolder scratch;
  const std::filesystem::path file = scratch / "lies.ply";
  std::ofstream(file) << "ply\nformat ascii 1.0\nelement vertex 4000000000\nproperty float x\n"
                         "property float y\nproperty float z\nend_header\n1 2 3\n4 5 6\n";
  SpillFolder folder = MakeSpillFolder();
  const auto reader = std::move(*MeshReader::Open(file));
  const Result<SpilledMesh> spilled = SpillMesh(folder, *reader, 1 << 20);
  ASSERT_FALSE(spilled);
  EXPECT_NE(spilled.GetError().message.find("vertex 2"), std::string::npos)
    << spilled.GetError().message;
  EXPECT_EQ(folder.Counts().bytesOnDisk, 0U);
}

TEST(MeshSpill, Cancelled)
{
  const fixtures::TemporaryFolder scratch;
  const std::filesystem::path file = scratch / "mesh.ply";
  ASSERT_TRUE(WriteMesh(file, Torus(20, 10)));
  for (int most = 0; most < 2; ++most)
  {
    SpillFolder folder = MakeSpillFolder();
    const auto reader = std::move(*MeshReader::Open(file));
    Execution execution;
    int reports = 0;
    execution.progress = [&](std::string_view, double) { return reports++ < most; };
    const Result<SpilledMesh> spilled = SpillMesh(folder, *reader, 1 << 20, execution);
    ASSERT_FALSE(spilled);
    EXPECT_EQ(spilled.GetError().code, ErrorCode::Cancelled);
  }
}
