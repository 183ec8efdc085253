// SPDX-License-Identifier: BSD-3-Clause
// Concave polygons of OBJ and PLY files are cut correctly. The cut is the same whether the mesh is
// read as a whole, or faces are read into a mesh without vertices.
#include "Testing/Fixtures/Invariants.h"
#include "Testing/Fixtures/TemporaryFolder.h"
#include "filters/core/VectorMath.h"
#include "filters/meshio/Testing/RandomObj.h"
#include "filters/meshio/Testing/RandomPly.h"
#include "filters/meshio/Testing/ReadAll.h"

#include <gtest/gtest.h>

namespace kdstream::test
{

namespace
{

// Reads as an out-of-core build does: first vertices and then faces, a few at a time, each time
// into a new mesh.
Mesh ReadApart(const std::filesystem::path& file, std::size_t limit)
{
  const Result<std::unique_ptr<MeshReader>> reader = MeshReader::Open(file);
  EXPECT_TRUE(reader);
  Mesh whole;
  for (const bool vertices : { true, false })
  {
    for (;;)
    {
      Mesh part;
      const Result<std::size_t> read =
        vertices ? (*reader)->ReadVertices(part, limit) : (*reader)->ReadTriangles(part, limit);
      EXPECT_TRUE(read) << read.GetError().message;
      if (!read || *read == 0)
      {
        break;
      }
      whole.points.insert(whole.points.end(), part.points.begin(), part.points.end());
      whole.triangles.insert(whole.triangles.end(), part.triangles.begin(), part.triangles.end());
    }
  }
  return whole;
}

const std::string objPlaces = "v 0 0 0\nv 4 0 0\nv 4 4 0\nv 2 1 0\nv 0 4 0\n";
const std::string plyHeader =
  " 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n"
  "property list uchar int vertex_indices\nend_header\n";
const std::string plyPlaces = "0 0 0\n4 0 0\n4 4 0\n2 1 0\n0 4 0\n";

std::string BinaryPly()
{
  std::string bytes = "ply\nformat binary_little_endian" + plyHeader;
  const std::array<float, 15> places{ 0, 0, 0, 4, 0, 0, 4, 4, 0, 2, 1, 0, 0, 4, 0 };
  const std::array<std::int32_t, 5> corners{ 0, 1, 2, 3, 4 };
  bytes.append(reinterpret_cast<const char*>(places.data()), sizeof(places));
  bytes += '\5';
  bytes.append(reinterpret_cast<const char*>(corners.data()), sizeof(corners));
  return bytes;
}

}

// The area is right; a fan would give 14.
TEST(PolygonFaces, ANotchedSquareHasItsArea)
{
  const fixtures::TemporaryFolder folder;
  const std::pair<std::string, std::string> files[] = {
    { "plain.obj", objPlaces + "f 1 2 3 4 5\n" },
    { "first.obj", "f 1 2 3 4 5\n" + objPlaces },
    { "turned.obj", objPlaces + "f 2 3 4 5 1\n" },
    { "normals.obj", objPlaces + "vn 0 0 1\nvt 0 0\nf 1/1/1 2//1 3/1/1 4/1 5/1/1\n" },
    { "ascii.ply", "ply\nformat ascii" + plyHeader + plyPlaces + "5 0 1 2 3 4\n" },
    { "binary.ply", BinaryPly() },
  };
  for (const auto& [name, bytes] : files)
  {
    SCOPED_TRACE(name);
    const auto file = folder.Write(name, bytes);
    const Contents read = ReadAll(file, [] { return everything; });
    ASSERT_TRUE(read.status) << read.status.GetError().message;
    ASSERT_EQ(read.mesh.triangles.size(), 3U);
    EXPECT_EQ(fixtures::AreaOf(read.mesh), 10);
    EXPECT_EQ(ReadApart(file, 2).triangles, read.mesh.triangles);
  }
}

TEST(PolygonFaces, RandomFilesAreTheSameInPieces)
{
  const fixtures::TemporaryFolder folder;
  for (unsigned seed = 0; seed < 40; ++seed)
  {
    SCOPED_TRACE(seed);
    RandomObjMaker objMaker(seed);
    const RandomFile obj = objMaker.Make(300);
    const Mesh ofObj = ReadApart(folder.Write("a.obj", obj.bytes), 1 + seed % 70);
    EXPECT_TRUE(SameBits(ofObj.points, obj.points));
    EXPECT_EQ(ofObj.triangles, obj.triangles);
    RandomPlyMaker plyMaker(seed);
    const RandomFile ply = plyMaker.Make(seed == 20 ? 20000 : 300);
    const Mesh ofPly = ReadApart(folder.Write("a.ply", ply.bytes), 1 + seed * 50);
    EXPECT_TRUE(SameBits(ofPly.points, ply.points));
    EXPECT_EQ(ofPly.triangles, ply.triangles);
  }
}

// The triangles of a convex polygon are its fan.
TEST(PolygonFaces, ConvexOnesAreFans)
{
  const fixtures::TemporaryFolder folder;
  const Contents read =
    ReadAll(folder.Write("a.obj", "v 0 0 0\nv 4 0 1\nv 5 3 1\nv 4 4 0\nv 0 4 0\nf 2 3 4 5 1\n"),
      [] { return everything; });
  EXPECT_EQ(read.mesh.triangles, (std::vector<Triangle>{ { 1, 2, 3 }, { 1, 3, 4 }, { 1, 4, 0 } }));
}

}
