// SPDX-License-Identifier: BSD-3-Clause
// Skipping in mesh files: vertices and faces after a skipped part are the same as without skipping.
#include "Testing/Fixtures/TemporaryFolder.h"
#include "filters/meshio/MeshReader.h"
#include "filters/meshio/Testing/RandomPly.h"
#include "filters/meshio/Testing/RandomStl.h"
#include "filters/meshio/Testing/ReadAll.h"

#include <gtest/gtest.h>

#include <limits>

namespace kdstream::test
{

namespace
{

constexpr std::size_t all = std::numeric_limits<std::size_t>::max();

// Reads vertices and faces from the given numbers on, after skipping or reading the earlier ones.
Mesh ReadFrom(
  const std::filesystem::path& file, std::uint64_t vertex, std::uint64_t face, bool skip)
{
  Result<std::unique_ptr<MeshReader>> reader = MeshReader::Open(file);
  EXPECT_TRUE(reader);
  Mesh mesh, dropped;
  if (skip)
  {
    // Skips in two steps: the second begins where the first one ended.
    EXPECT_EQ(*(*reader)->SkipVertices(vertex / 2), vertex / 2);
    EXPECT_EQ(*(*reader)->SkipVertices(vertex - vertex / 2), vertex - vertex / 2);
  }
  else if (vertex > 0)
  {
    EXPECT_EQ(*(*reader)->ReadVertices(dropped, vertex), vertex);
  }
  EXPECT_TRUE((*reader)->ReadVertices(mesh, 3));
  if (skip)
  {
    EXPECT_TRUE((*reader)->SkipVertices(all));
    EXPECT_EQ(*(*reader)->SkipFaces(face / 2), face / 2);
    EXPECT_EQ(*(*reader)->SkipFaces(face - face / 2), face - face / 2);
  }
  else if (face > 0)
  {
    EXPECT_EQ(*(*reader)->ReadTriangles(dropped, face), face);
  }
  EXPECT_TRUE((*reader)->ReadTriangles(mesh, 2));
  EXPECT_TRUE((*reader)->ReadTriangles(mesh, all));
  EXPECT_EQ(*(*reader)->SkipFaces(1), 0U);
  return mesh;
}

void CheckSkipping(RandomGenerator& generator, const std::string& name, const std::string& bytes)
{
  const fixtures::TemporaryFolder folder;
  const auto file = folder.Write(name, bytes);
  const Result<std::unique_ptr<MeshReader>> reader = MeshReader::Open(file);
  ASSERT_TRUE(reader);
  const std::uint64_t vertex = generator.Pick((*reader)->Info().vertices + 1);
  const std::uint64_t face = generator.Pick((*reader)->Info().faces + 1);
  const Mesh skipped = ReadFrom(file, vertex, face, true);
  const Mesh read = ReadFrom(file, vertex, face, false);
  EXPECT_TRUE(SameBits(skipped.points, read.points));
  EXPECT_EQ(skipped.triangles, read.triangles);
  EXPECT_EQ(skipped.attributes, read.attributes);
}

// A binary file of four vertices, and of faces with these corners.
std::string WithFaces(const std::vector<std::string>& faces)
{
  std::string bytes = "ply\nformat binary_little_endian 1.0\nelement vertex 4\nproperty uchar x\n"
                      "property uchar y\nproperty uchar z\nelement face " +
                      std::to_string(faces.size()) +
                      "\nproperty list uchar uchar vertex_indices\nproperty uchar red\n"
                      "end_header\n" +
                      std::string(12, '\1');
  for (const std::string& corners : faces)
  {
    bytes += char(corners.size()) + corners + '\7';
  }
  return bytes;
}

}

TEST(Skipping, LeadsWhereReadingDoes)
{
  for (unsigned seed = 0; seed < 300; ++seed)
  {
    SCOPED_TRACE("seed " + std::to_string(seed));
    RandomGenerator generator(seed);
    RandomPlyMaker ply(seed);
    CheckSkipping(generator, "random.ply", ply.Make(seed % 5 == 0 ? 3 : 300).bytes);
    RandomStlMaker stl(seed);
    CheckSkipping(generator, "random.stl", stl.Make(300).bytes);
    const std::string corners[] = { { "\0\1\2", 3 }, { "\3\2\1", 3 }, { "\1\1\0", 3 } };
    std::vector<std::string> faces;
    for (std::size_t i = 0, count = generator.Pick(40); i < count; ++i)
    {
      faces.push_back(corners[generator.Pick(3)]);
    }
    CheckSkipping(generator, "triangles.ply", WithFaces(faces));
  }
}

// A quad and a line have the same number of bytes as two triangles, so a reader that skips the quad
// continues at a wrong offset. The reader that reads the part with the quad, or with the line,
// notices.
TEST(Skipping, ReadersOfOtherPartsSeeThatFacesAreNotTriangles)
{
  const std::string triangle("\0\1\2", 3), quad("\0\1\2\3", 4), line("\1\2", 2);
  const fixtures::TemporaryFolder folder;
  const auto file = folder.Write("faces.ply", WithFaces({ triangle, quad, triangle, line }));
  for (const std::uint64_t skipped : { 0U, 1U })
  {
    Result<std::unique_ptr<MeshReader>> reader = MeshReader::Open(file);
    ASSERT_TRUE(reader);
    ASSERT_TRUE((*reader)->SkipVertices(all));
    ASSERT_TRUE((*reader)->SkipFaces(skipped));
    Mesh mesh;
    const Result<std::size_t> read = (*reader)->ReadTriangles(mesh, 2 - skipped);
    ASSERT_FALSE(read);
    EXPECT_NE(read.GetError().message.find("room only for triangles"), std::string::npos)
      << read.GetError().message;
  }
}

}
