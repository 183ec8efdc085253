// SPDX-License-Identifier: BSD-3-Clause
// MeshReader: the file's name chooses the reader.
#include "filters/meshio/MeshReader.h"
#include "filters/meshio/Testing/RandomStl.h"
#include "filters/meshio/Testing/ScratchFolder.h"

#include <gtest/gtest.h>

namespace kdstream::test
{

TEST(MeshReader, ReadsPlyWhateverTheCaseOfItsEnding)
{
  const ScratchFolder folder;
  for (const char* name : { "a.ply", "B.PLY", "c.stl.Ply" })
  {
    const auto file = folder.Write(name,
      "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
      "property float z\nproperty list uchar int parts\nelement edge 1\nproperty int "
      "vertex1\nend_header\n1 2 "
      "3 0\n0\n");
    const Result<std::unique_ptr<MeshReader>> reader = MeshReader::Open(file);
    ASSERT_TRUE(reader) << name << ": " << reader.GetError().message;
    EXPECT_EQ((*reader)->Info().vertices, 1U);
    EXPECT_EQ(
      (*reader)->Info().ignoredAttributes, (std::vector<std::string>{ "vertex.parts", "edge" }));
  }
}

TEST(MeshReader, RefusesOtherFormatsByName)
{
  const ScratchFolder folder;
  for (const std::string ending : { ".vtp", ".vtk", ".wrl", ".glb", ".gltf", ".pcd", ".xyz", ".las",
         ".laz", ".wrz", ".txt", ".csv", ".pts", ".asc" })
  {
    const Result<std::unique_ptr<MeshReader>> reader =
      MeshReader::Open(folder.Write("mesh" + ending, "ply\n"));
    ASSERT_FALSE(reader);
    EXPECT_EQ(reader.GetError().code, ErrorCode::Unsupported);
    EXPECT_EQ(reader.GetError().message,
      ending + " files are not read in chunks; kdstream-convert makes a .ply of them");
  }
  for (const std::string ending : { ".gz", "", ".ply~" })
  {
    const Result<std::unique_ptr<MeshReader>> reader =
      MeshReader::Open(folder.Write("mesh" + ending, "ply\n"));
    ASSERT_FALSE(reader);
    EXPECT_EQ(reader.GetError().code, ErrorCode::Unsupported);
    EXPECT_EQ(reader.GetError().message,
      "the ending '" + ending + "' names no known mesh format; convert it to .ply");
  }
}

TEST(MeshReader, ReadsFacesByTheirTriangles)
{
  std::string text = "v 0 0 0\n", face = "f";
  for (int i = 0; i < 100; ++i)
  {
    face += " 1";
  }
  for (int i = 0; i < 2000; ++i)
  {
    text += face + "\n";
  }
  const ScratchFolder folder;
  const Result<std::unique_ptr<MeshReader>> reader = MeshReader::Open(folder.Write("a.obj", text));
  ASSERT_TRUE(reader);
  Mesh mesh;
  ASSERT_TRUE((*reader)->ReadVertices(mesh, 1));
  const std::size_t most = 30000;
  std::size_t faces = 0;
  for (std::size_t count = 1; count > 0; faces += count)
  {
    mesh.triangles.clear();
    const Result<std::size_t> read = (*reader)->ReadFaces(mesh, most);
    ASSERT_TRUE(read);
    EXPECT_LE(mesh.triangles.size(), most + 98);
    count = *read;
  }
  EXPECT_EQ(faces, 2000U);
}

TEST(MeshReader, RefusesAPlyThatIsCutBehindItsFaces)
{
  const ScratchFolder folder;
  const Result<std::unique_ptr<MeshReader>> reader = MeshReader::Open(folder.Write("a.ply",
    "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
    "property float z\nelement face 1\nproperty list uchar int vertex_indices\n"
    "element edge 9\nproperty int vertex1\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n1\n"));
  ASSERT_TRUE(reader);
  Mesh mesh;
  ASSERT_TRUE((*reader)->ReadVertices(mesh, 9));
  const Result<std::size_t> read = (*reader)->ReadTriangles(mesh, 9);
  ASSERT_FALSE(read);
  EXPECT_NE(read.GetError().message.find("edge 1 of 9"), std::string::npos);
}

TEST(MeshReader, NamesMissingAndEmptyFiles)
{
  const ScratchFolder folder;
  EXPECT_EQ(MeshReader::Open(folder.File("missing.ply")).GetError().code, ErrorCode::NotFound);
  EXPECT_EQ(MeshReader::Open(folder.File("missing.stl")).GetError().code, ErrorCode::NotFound);
  EXPECT_EQ(
    MeshReader::Open(folder.Write("empty.ply", "")).GetError().message, "the file is empty");
}

TEST(MeshReader, ErrorsNameTheFileWhenItIsOpenedAndRead)
{
  const ScratchFolder folder;
  const auto missing = folder.File("missing.obj");
  EXPECT_EQ(MeshReader::Open(missing).GetError().file, missing.string());
  const auto cut = folder.Write("cut.ply",
    "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n"
    "property float z\nend_header\n1 2 3\n");
  const Result<std::unique_ptr<MeshReader>> reader = MeshReader::Open(cut);
  ASSERT_TRUE(reader) << reader.GetError().message;
  Mesh mesh;
  const Result<std::size_t> read = (*reader)->ReadVertices(mesh, 10);
  ASSERT_FALSE(read);
  EXPECT_EQ(read.GetError().file, cut.string());
}

TEST(MeshReader, ContentOfAnotherFormatIsTold)
{
  const ScratchFolder folder;
  const std::string ply = "ply\nformat ascii 1.0\nend_header\n" + std::string(200, '\n');
  const auto messageOf = [&](const std::string& name, const std::string& content)
  {
    const auto reader = MeshReader::Open(folder.Write(name, content));
    return reader ? std::string() : reader.GetError().message;
  };
  EXPECT_EQ(messageOf("a.stl", ply),
    "looks like a .ply file, although its name ends in .stl: rename it to end in .ply");
  EXPECT_EQ(messageOf("a.obj", ply),
    "looks like a .ply file, although its name ends in .obj: rename it to end in .ply");
  EXPECT_EQ(messageOf("a.ply", "glTF" + std::string(200, '\x02')),
    "looks like a .glb file, although its name ends in .ply: rename it to end in .glb");
  const std::string stl = BinaryStl("exported", std::vector<Vec3>(6));
  for (const std::string ending : { ".ply", ".obj", ".off" })
  {
    EXPECT_EQ(messageOf("b" + ending, stl),
      "looks like a .stl file, although its name ends in " + ending + ": rename it to end in .stl");
  }
  EXPECT_EQ(messageOf("c.ply", "# by hand\nv 1 2 3\n"),
    "looks like a .obj file, although its name ends in .ply: rename it to end in .obj");
  EXPECT_EQ(messageOf("c.stl", "COFF\n1 0 0\n"),
    "looks like a .off file, although its name ends in .stl: rename it to end in .off");
  EXPECT_EQ(messageOf("d.ply", "Kaydara FBX Binary  "),
    "looks like a .fbx file, although its name ends in .ply, and such files are not read: convert "
    "it to .ply");
  EXPECT_EQ(messageOf("b.ply", "PK\x03\x04" + std::string(200, '\x02')),
    "is compressed (.zip): unpack it first, by unzip");
  for (const std::string name : { "c.obj", "c.ply.gz", "c" })
  {
    EXPECT_EQ(messageOf(name, "\x1f\x8b\x08" + std::string(200, '\x02')),
      "is compressed (.gz): unpack it first, by gunzip");
  }
}

}
