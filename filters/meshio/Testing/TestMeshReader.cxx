// SPDX-License-Identifier: BSD-3-Clause
// MeshReader: the file's name chooses the reader.
#include "Testing/Fixtures/ErrorAt.h"
#include "Testing/Fixtures/TemporaryFolder.h"
#include "filters/meshio/MeshReader.h"
#include "filters/meshio/Testing/RandomStl.h"

#include <gtest/gtest.h>

namespace kdstream::test
{

using fixtures::FailsAt, fixtures::Mentions;

TEST(MeshReader, ReadsPlyWhateverTheCaseOfItsEnding)
{
  const fixtures::TemporaryFolder folder;
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
  const fixtures::TemporaryFolder folder;
  for (const std::string ending : { ".vtp", ".vtk", ".wrl", ".glb", ".gltf", ".pcd", ".xyz", ".las",
         ".laz", ".wrz", ".txt", ".csv", ".pts", ".asc" })
  {
    const Result<std::unique_ptr<MeshReader>> reader =
      MeshReader::Open(folder.Write("mesh" + ending, "ply\n"));
    EXPECT_TRUE(FailsAt(reader, ErrorCode::Unsupported, ending + " files"));
  }
  for (const std::string ending : { ".dat", "", ".ply~" })
  {
    const Result<std::unique_ptr<MeshReader>> reader =
      MeshReader::Open(folder.Write("mesh" + ending, "who knows\n"));
    EXPECT_TRUE(FailsAt(reader, ErrorCode::Unsupported, "'" + ending + "'"));
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
  const fixtures::TemporaryFolder folder;
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

TEST(MeshReader, RefusesAPlyThatIsCutAfterItsFaces)
{
  const fixtures::TemporaryFolder folder;
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
  const fixtures::TemporaryFolder folder;
  EXPECT_EQ(MeshReader::Open(folder / "missing.ply").GetError().code, ErrorCode::NotFound);
  EXPECT_EQ(MeshReader::Open(folder / "missing.stl").GetError().code, ErrorCode::NotFound);
  EXPECT_TRUE(FailsAt(MeshReader::Open(folder.Write("empty.ply", "")), ErrorCode::InvalidInput));
}

TEST(MeshReader, ErrorsNameTheFileWhenItIsOpenedAndRead)
{
  const fixtures::TemporaryFolder folder;
  const auto missing = folder / "missing.obj";
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

TEST(MeshReader, ContentOfAnotherFormatIsReported)
{
  const fixtures::TemporaryFolder folder;
  const std::string ply = "ply\nformat ascii 1.0\nend_header\n" + std::string(200, '\n');
  const auto messageOf = [&](const std::string& name, const std::string& content)
  {
    const auto reader = MeshReader::Open(folder.Write(name, content));
    return reader ? std::string() : reader.GetError().message;
  };
  EXPECT_TRUE(Mentions(messageOf("a.stl", ply), { "a .ply file", "ends in .stl", ".ply" }));
  EXPECT_TRUE(Mentions(messageOf("a.obj", ply), { "a .ply file", "ends in .obj", ".ply" }));
  EXPECT_TRUE(Mentions(messageOf("a.ply", "glTF" + std::string(200, '\x02')),
    { "a .glb file", "ends in .ply", ".glb" }));
  const std::string stl = BinaryStl("exported", std::vector<Vec3>(6));
  for (const std::string ending : { ".ply", ".obj", ".off" })
  {
    EXPECT_TRUE(
      Mentions(messageOf("b" + ending, stl), { "a .stl file", "ends in " + ending, ".stl" }));
  }
  EXPECT_TRUE(Mentions(
    messageOf("c.ply", "# by hand\nv 1 2 3\n"), { "a .obj file", "ends in .ply", ".obj" }));
  EXPECT_TRUE(
    Mentions(messageOf("c.stl", "COFF\n1 0 0\n"), { "a .off file", "ends in .stl", ".off" }));
  EXPECT_TRUE(Mentions(messageOf("d.ply", "Kaydara FBX Binary  "), { "FBX", ".ply" }));
  EXPECT_TRUE(Mentions(messageOf("e.dat", ply), { "a .ply file", "ends in .dat", ".ply" }));
  EXPECT_TRUE(Mentions(messageOf("e", ply), { "a .ply file", "no ending", ".ply" }));
  EXPECT_EQ(messageOf("b.ply", "PK\x03\x04" + std::string(200, '\x02')),
    "is compressed (.zip): unpack it first, by unzip");
  for (const std::string name : { "c.obj", "c.ply.gz", "c" })
  {
    EXPECT_EQ(messageOf(name, "\x1f\x8b\x08" + std::string(200, '\x02')),
      "is compressed (.gz): unpack it first, by gunzip");
  }
}

// A ZIP archive of uncompressed files with these names, each holding one byte.
std::string ZipOf(const std::vector<std::string>& names)
{
  const auto number = [](std::size_t value, std::size_t bytes)
  {
    std::string text;
    for (; bytes > 0; --bytes, value >>= 8U)
    {
      text += static_cast<char>(value & 255U);
    }
    return text;
  };
  std::string files, directory;
  for (const std::string& name : names)
  {
    const std::string sizes = number(0, 12) + number(1, 4) + number(1, 4) + number(name.size(), 2);
    directory += "PK\x01\x02" + number(20, 2) + number(20, 2) + sizes + number(0, 12) +
                 number(files.size(), 4) + name;
    files += "PK\x03\x04" + number(20, 2) + sizes + number(0, 2) + name + "x";
  }
  return files + directory + "PK\x05\x06" + number(0, 4) + number(names.size(), 2) +
         number(names.size(), 2) + number(directory.size(), 4) + number(files.size(), 4) +
         number(0, 2);
}

// They are recognised by their content, whatever their names are, or else by their names.
TEST(MeshReader, FormatsThatAreNotReadAreNamed)
{
  const fixtures::TemporaryFolder folder;
  const auto messageOf = [&](const std::string& name, const std::string& content)
  {
    const auto reader = MeshReader::Open(folder.Write(name, content));
    return reader ? "it was read" : reader.GetError().message;
  };
  const std::string compound = "\xD0\xCF\x11\xE0\xA1\xB1\x1A\xE1" + std::string(600, '\0');
  const std::string sketchUp("\xFF\xFE\xFF\x0ES\0k\0e\0t\0c\0h\0U\0p\0 \0M\0", 24);
  const std::string iges = std::string(72, ' ') + "S      1\n" + std::string(72, '1') + "G";
  const std::string begin3ds("MM\x08\0\0\0\x02\0", 8);
  const std::string step = "ISO-10303-21;\nHEADER;\nFILE_SCHEMA(('";
  const struct
  {
    std::string content, name;
  } formats[] = { { ZipOf({ "[Content_Types].xml", "Metadata/thumbnail.png", "3D/3dmodel.model" }),
                    "3MF" },
    { ZipOf({ "scene.usdc", "0/wood.png" }), "USD" }, { ZipOf({ "doc.kml" }), "KMZ" },
    { ZipOf({ "Document.xml", "PartShape.brp" }), "FreeCAD" }, { ZipOf({ "points.npy" }), "NumPy" },
    { "; FBX 7.3.0 project file\n", "FBX" }, { "BLENDER-v279RENDH", "Blender" },
    { compound, "3ds Max" }, { sketchUp, "SketchUp" },
    { "ASTM-E57" + std::string(100, '\0'), "E57" }, { step + "AUTOMOTIVE_DESIGN'));", "STEP" },
    { step + "IFC4'));", "IFC" }, { iges, "IGES" }, { begin3ds, "3DS" },
    { "3D Geometry File Format        50", "Rhino" }, { "AC1032" + std::string(100, '\0'), "DWG" },
    { "  0\r\nSECTION\r\n  2\r\n", "DXF" },
    { "<?xml version=\"1.0\"?>\n<COLLADA xmlns=\"x\">", "COLLADA" },
    { "<?xml version=\"1.0\"?>\n<X3D profile=\"Immersive\">", "X3D" },
    { "<?xml version=\"1.0\"?>\n<amf unit=\"mm\">", "AMF" },
    { "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\">", "VTK" },
    { "#usda 1.0\n", "USD" }, { "#Inventor V2.1 ascii\n", "Inventor" },
    { "{\"type\":\"CityJSON\",\"version\":\"2.0\"", "JSON" },
    { "{\"metadata\":{\"version\":4.5,\"type\":\"Object\"", "JSON" },
    { std::string("FORM\0\0\x01\0LWO2TAGS", 16), "LightWave" }, { "b3dm", "3D Tiles" },
    { "$MeshFormat\n2.2 0 8\n", "Gmsh" }, { "\x89PNG\r\n", "PNG picture, and no mesh" },
    { std::string("II*\0\x08\0\0\0", 8), "TIFF" }, { "<!DOCTYPE html>", "HTML" },
    { "%PDF-1.6", "PDF" } };
  for (const auto& format : formats)
  {
    for (const std::string name : { "a.ply", "a.stl", "a.obj", "a.off", "a.max", "a" })
    {
      const std::string message = messageOf(name, format.content);
      EXPECT_TRUE(message.starts_with("is a") && message.find(format.name) != message.npos)
        << name << " of " << format.name << ": " << message;
    }
  }
  EXPECT_EQ(messageOf("a.zip", ZipOf({ "read me.txt", "model/statue.obj", "model/statue.mtl" })),
    "is compressed (.zip), and holds 'model/statue.obj': unpack it first, by unzip");
  EXPECT_EQ(messageOf("a.zip", ZipOf({})), "is compressed (.zip): unpack it first, by unzip");
  EXPECT_EQ(
    messageOf("a.rar", "Rar!\x1A\x07"), "is compressed (.rar): unpack it first, by unrar x");
  EXPECT_EQ(messageOf("a.tar", std::string(257, 'a') + "ustar" + std::string(300, '\0')),
    "is an archive (.tar): unpack it first, by tar xf");
  // An archive with a damaged directory.
  std::string damaged = ZipOf({ "3D/3dmodel.model" });
  damaged[damaged.size() - 4] = '\x7f';
  EXPECT_EQ(messageOf("a.zip", damaged), "is compressed (.zip): unpack it first, by unzip");
  EXPECT_NE(messageOf("a.3mf", damaged).find("is a 3MF file"), std::string::npos);
  EXPECT_EQ(messageOf("a.fbx", "who knows"),
    "the ending '.fbx' is that of an FBX file, which is not "
    "read: open it in Blender and export it as .ply, .glb "
    "or .obj");
}

}
