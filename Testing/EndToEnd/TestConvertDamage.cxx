// SPDX-License-Identifier: BSD-3-Clause
// kdstream-convert with truncated or changed files: it never crashes visibly, a header's claims
// never take memory, and no file is left.
#include "Testing/EndToEnd/ConvertTools.h"
#include "Testing/EndToEnd/GltfFile.h"
#include "Testing/Fixtures/Meshes.h"

#include <vtkPolyDataWriter.h>
#include <vtkSTLWriter.h>
#include <vtkXMLPolyDataWriter.h>

#include <map>
#include <random>

using namespace kdstream;
using namespace kdstream::fixtures;

namespace
{

// Of a process that reads a small file.
constexpr std::uint64_t mostMemory = std::uint64_t{ 1200 } << 20;

class TestConvertDamage : public ConvertTest
{
protected:
  // Writes a small mesh with normals in every format. The second value says whether every
  // truncation must be noticed.
  std::map<std::string, bool> WriteAll()
  {
    Mesh mesh = AsFloats(DisplacedSphere(2));
    Attribute normals;
    normals.name = "Normals";
    normals.type = AttributeType::Float32;
    normals.components = 3;
    for (const Vec3& p : mesh.points)
    {
      for (const double v : p)
      {
        const auto value = static_cast<float>(v);
        const auto* const bytes = reinterpret_cast<const std::uint8_t*>(&value);
        normals.values.insert(normals.values.end(), bytes, bytes + 4);
      }
    }
    mesh.attributes.push_back(normals);
    const auto data = ToPolyData(mesh);
    for (const bool ascii : { false, true })
    {
      const std::string kind = ascii ? "ascii" : "binary";
      vtkNew<vtkPolyDataWriter> legacy;
      legacy->SetInputData(data);
      legacy->SetFileName((this->Folder / (kind + ".vtk")).c_str());
      legacy->SetFileType(ascii ? VTK_ASCII : VTK_BINARY);
      legacy->Write();
      vtkNew<vtkSTLWriter> stl;
      stl->SetInputData(data);
      stl->SetFileName((this->Folder / (kind + ".stl")).c_str());
      stl->SetFileType(ascii ? VTK_ASCII : VTK_BINARY);
      stl->Write();
      vtkNew<vtkXMLPolyDataWriter> xml;
      xml->SetInputData(data);
      xml->SetFileName((this->Folder / (kind + ".vtp")).c_str());
      xml->SetDataMode(ascii ? vtkXMLWriter::Ascii : vtkXMLWriter::Appended);
      xml->Write();
    }
    EXPECT_TRUE(WriteMesh(this->Folder / "text.obj", mesh));
    this->WriteGltf(mesh);
    std::string xyz;
    for (const Vec3& p : mesh.points)
    {
      xyz += std::to_string(p[0]) + " " + std::to_string(p[1]) + " " + std::to_string(p[2]) + "\n";
    }
    this->WriteText("text.xyz", xyz);
    std::map<std::string, bool> files{ { "binary.vtk", true }, { "ascii.vtk", true },
      { "binary.stl", true }, { "ascii.stl", false }, { "binary.vtp", true }, { "ascii.vtp", true },
      { "text.obj", false }, { "whole.glb", true }, { "text.gltf", true }, { "text.xyz", false } };
    if (hasVrml)
    {
      EXPECT_TRUE(WriteMesh(this->Folder / "text.wrl", mesh));
      files["text.wrl"] = true;
    }
    return files;
  }

  void WriteGltf(const Mesh& mesh)
  {
    GltfBuffer buffer;
    std::vector<float> places;
    for (const Vec3& p : mesh.points)
    {
      places.insert(places.end(), { float(p[0]), float(p[1]), float(p[2]) });
    }
    std::vector<std::uint16_t> corners;
    for (const Triangle& t : mesh.triangles)
    {
      for (const VertexId corner : t)
      {
        corners.push_back(static_cast<std::uint16_t>(corner));
      }
    }
    const int position =
      buffer.Add(places, "VEC3", gltfFloat, ",\"min\":[-2,-2,-2],\"max\":[2,2,2]");
    const int indices = buffer.Add(corners, "SCALAR", gltfUnsignedShort);
    const std::string scene =
      "\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0}],\"meshes\":[{"
      "\"primitives\":[{\"attributes\":{\"POSITION\":" +
      std::to_string(position) + "},\"indices\":" + std::to_string(indices) + "}]}]";
    this->WriteText("whole.glb", buffer.Glb(scene));
    this->WriteText("text.gltf", buffer.Json(scene, "buffer.bin"));
    this->WriteText("buffer.bin", buffer.Bytes);
  }

  // Converts the file. The outcome must be reported properly. Returns whether the file was refused.
  bool Refused(const std::string& file, const std::string& how)
  {
    std::filesystem::remove(this->Folder / "out.ply");
    const Outcome outcome = this->Convert(file);
    EXPECT_LE(outcome.peakBytes, mostMemory) << file << " " << how;
    const bool refused = outcome.exitCode == 1;
    EXPECT_TRUE(refused || outcome.exitCode == 0)
      << file << " " << how << ": " << outcome.exitCode << " " << outcome.err;
    if (refused)
    {
      EXPECT_EQ(outcome.err.rfind("kdstream-convert: error: " + file + ": ", 0), 0U)
        << how << ": " << outcome.err;
      EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1)
        << how << ": " << outcome.err;
    }
    EXPECT_EQ(std::filesystem::exists(this->Folder / "out.ply"), !refused) << file << " " << how;
    return refused;
  }
};

}

TEST_F(TestConvertDamage, CutFiles)
{
  for (const auto& [name, everyCutShows] : this->WriteAll())
  {
    ASSERT_FALSE(this->Refused(name, "whole"));
    const std::string whole = ReadWhole(this->Folder / name);
    const std::string file = "cut" + std::filesystem::path(name).extension().string();
    constexpr std::size_t cuts = 16;
    std::set<std::size_t> sizes{ 0, 1, whole.size() - 1, whole.size() - 20 };
    for (std::size_t i = 1; i < cuts; ++i)
    {
      sizes.insert(whole.size() * i / cuts);
    }
    for (const std::size_t size : sizes)
    {
      this->WriteText(file, whole.substr(0, size));
      const bool refused = this->Refused(file, "cut to " + std::to_string(size));
      // The last bytes of a text may be only the end of its last line.
      EXPECT_TRUE(refused || !everyCutShows || size + 20 >= whole.size())
        << name << " cut to " << size << " of " << whole.size();
      EXPECT_TRUE(refused || size > 1) << name << " cut to " << size;
    }
  }
}

TEST_F(TestConvertDamage, ChangedBytes)
{
  std::mt19937 random(6);
  for (const auto& [name, everyCutShows] : this->WriteAll())
  {
    const std::string whole = ReadWhole(this->Folder / name);
    const std::string file = "bad" + std::filesystem::path(name).extension().string();
    for (unsigned draw = 0; draw < 24; ++draw)
    {
      std::string bad = whole;
      // Half of the changes are in the first bytes, which contain the claims.
      const std::size_t range = draw % 2 == 0 ? std::min<std::size_t>(400, bad.size()) : bad.size();
      for (unsigned change = 0; change <= draw / 8; ++change)
      {
        bad[random() % range] = static_cast<char>(draw % 3 == 0 ? '9' : char(random() % 256));
      }
      this->WriteText(file, bad);
      this->Refused(file, "draw " + std::to_string(draw));
    }
  }
}

TEST_F(TestConvertDamage, LiesAboutSizesTakeNoMemory)
{
  const auto number = [](std::uint32_t value)
  { return std::string(reinterpret_cast<const char*>(&value), 4); };
  this->WriteText("lie.stl", std::string(80, 'x') + number(0xFFFFFFFF) + std::string(500, '\0'));
  this->ExpectError("lie.stl", "the header claims 4294967295 triangles, 214748364834 bytes with "
                               "it; the file has 584");
  const std::string vtk = "# vtk DataFile Version 3.0\nt\nBINARY\nDATASET POLYDATA\n";
  this->WriteText("points.vtk", vtk + "POINTS 100000000000 float\n");
  this->WriteText("cells.vtk",
    vtk + "POINTS 1 float\n" + std::string(12, '\0') + "\nPOLYGONS 1000000000 4000000000\n");
  this->WriteText("huge.vtp",
    "<?xml version=\"1.0\"?><VTKFile type=\"PolyData\" version=\"1.0\" "
    "byte_order=\"LittleEndian\"><PolyData><Piece NumberOfPoints=\"900000000000\"><Points>"
    "<DataArray type=\"Float32\" NumberOfComponents=\"3\" format=\"ascii\">0 0 0</DataArray>"
    "</Points></Piece></PolyData></VTKFile>");
  GltfBuffer buffer;
  buffer.Add(std::vector<float>(9, 1.0F), "VEC3", gltfFloat);
  std::string gltf =
    buffer.Glb("\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0}],"
               "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}]");
  const std::size_t count = gltf.find("\"count\":3,");
  ASSERT_NE(count, std::string::npos);
  gltf.replace(count, 10, "\"count\":2e9,").erase(gltf.find("\"version\":\"2.0\"") - 2, 0);
  this->WriteText("count.glb", gltf);
  for (const char* file : { "points.vtk", "cells.vtk", "huge.vtp", "count.glb" })
  {
    EXPECT_TRUE(this->Refused(file, "lies"));
  }
}

// VTK's readers of these files do not check offsets, cells and arrays.
TEST_F(TestConvertDamage, CellsOfVtkFilesAreNotBelieved)
{
  const std::string head = "# vtk DataFile Version 5.1\nt\nASCII\nDATASET ";
  const std::string points = "POINTS 3 float\n0 0 0 1 0 0 0 1 0\n";
  const auto cells = [](const std::string& kind, const std::string& offsets, const std::string& ids)
  {
    const auto count = [](const std::string& list)
    { return std::to_string(1 + std::count(list.begin(), list.end(), ' ')); };
    return kind + " " + count(offsets) + " " + count(ids) + "\nOFFSETS vtktypeint64\n" + offsets +
           "\nCONNECTIVITY vtktypeint64\n" + ids + "\n";
  };
  const std::string grid = head + "UNSTRUCTURED_GRID\n" + points;
  const std::vector<std::pair<std::string, std::string>> cases{
    { head + "POLYDATA\n" + points + cells("POLYGONS", "0 1000000", "0 1 2"),
      "cell 0 uses corners 0 to 1000000 of a list of 3" },
    { head + "POLYDATA\n" + points + cells("LINES", "0 3 1 3", "0 1 2"),
      "cell 1 uses corners 3 to 1 of a list of 3" },
    { grid + cells("CELLS", "0 1000000", "0 1 2") + "CELL_TYPES 1\n5\n",
      "cell 0 uses corners 0 to 1000000 of a list of 3" },
    { grid + cells("CELLS", "0 3", "0 1 7") + "CELL_TYPES 1\n5\n",
      "cell 0 uses point 7, but there are 3" },
    { grid + cells("CELLS", "0 3", "0 1 2") + "CELL_TYPES 1\n10\n",
      "cell 0 of the type 10 has 3 points" },
    { grid + cells("CELLS", "0 3", "0 1 2") + "CELL_TYPES 1\n200\n",
      "cell 0 of the type 200 has 3 points" },
  };
  for (const auto& [text, message] : cases)
  {
    this->WriteText("lie.vtk", text);
    this->ExpectError("lie.vtk", message);
  }
  this->WriteText("array.vtk", grid + cells("CELLS", "0 3", "0 1 2") +
                                 "CELL_TYPES 1\n5\nPOINT_DATA 3\nFIELD f 1\nshort 1 1 float\n7\n");
  const Mesh read = this->Converted("array.vtk",
    "kdstream-convert: warning: array.vtk: dropped: point array \"short\": has 1 tuples for 3 "
    "points\nkdstream-convert: warning: array.vtk: holds vtkUnstructuredGrid, whose surface is "
    "used\n");
  EXPECT_EQ(read.triangles.size(), 1U);
  EXPECT_TRUE(read.attributes.empty());
}

// VTK's messages seldom say where the damage is.
TEST_F(TestConvertDamage, DamagedPartsOfVtkFilesAreNamed)
{
  const std::string head = "# vtk DataFile Version 3.0\nt\nASCII\nDATASET ";
  const std::string mesh = head + "POLYDATA\n", grid = head + "UNSTRUCTURED_GRID\n";
  const std::string points = "POINTS 4 float\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n";
  const std::string bytes(12, '\0');
  const std::vector<std::pair<std::string, std::string>> cases{
    { mesh + "POINTS 4 float\n0 0 0\n1 0 0\n0 1 0\nPOLYGONS 1 4\n3 0 1 2\n",
      "POINTS (line 5) has 9 of its 12 numbers, then 'POLYGONS' (line 9)" },
    { mesh + "POINTS 4 float\n0 0 0\n1 0 x\n",
      "POINTS (line 5) has 5 of its 12 numbers, then 'x' (line 7)" },
    { mesh + points + "POLYGONS 1 4\n3 0 1 nan\n",
      "POLYGONS (line 10) has 'nan' (line 11), which names no point" },
    { mesh + "POINTZ 4 float\n0 0 0\n", "'POINTZ' (line 5) is not the name of a part" },
    { mesh + "POINTS 4 float\n0 0 0\n1 0 1,5\n0 1 0\n0 0 1\n",
      "POINTS (line 5) has 5 of its 12 numbers, then '1,5' (line 7)" },
    { mesh + points + "POLYGONS 1 4\n3 0 1 1e300\n",
      "POLYGONS (line 10) has a cell 0 (line 11) that names point '1e300', but there are 4" },
    { mesh + points + "POLYGONS 2 8\n3 0 1 2\n3 0 1 4294967298\n",
      "POLYGONS (line 10) has a cell 1 (line 12) that names point '4294967298', but there are 4" },
    { mesh + points + "POLYGONS 1 4\n3 0 1 -4294967296\n",
      "POLYGONS (line 10) has a cell 0 (line 11) that names point '-4294967296', but there are 4" },
    { mesh + points + "POLYGONS 1 4\n3 0 1-2\n",
      "POLYGONS (line 10) has 2 of its 4 numbers, then '1-2' (line 11)" },
    { mesh + "FIELD f 3\nNULL_ARRAY\nnames 1 2 string\nPOLYGONS%201\nb\nc 1 1 int\n7\n" + points +
        "POLYGONS 1 4\n3 0 1\n",
      "POLYGONS (line 17) has 3 of its 4 numbers, then the file ends" },
    { mesh + points + "POINT_DATA 4\nFIELD f 1\nnames 1 4 string\na\nb\n",
      "FIELD (line 11), array 'names' has 2 of its 4 values, then the file ends" },
    { mesh + points + "POLYGONS 2 8\n3 0 1 2\n3 0 1\n",
      "POLYGONS (line 10) has 7 of its 8 numbers, then the file ends" },
    { mesh + points +
        "LINES 1 3\n2 0 1\nPOINT_DATA 4\nSCALARS s float 1\nLOOKUP_TABLE default\n1 2 3\n",
      "SCALARS (line 13) has 3 of its 4 numbers, then the file ends" },
    { mesh + points + "POINT_DATA 4\nFIELD f 2\na 1 4 float\n1 2 3 4\nb 2 4 float\n1 2 3\n",
      "FIELD (line 11), array 'b' has 3 of its 8 numbers, then the file ends" },
    { grid + points + "CELLS 1 5\n4 0 1 2\nCELL_TYPES 1\n10\n",
      "CELLS (line 10) has 4 of its 5 numbers, then 'CELL_TYPES' (line 12)" },
    { grid + points + "CELLS 1 5\n4 0 1 2 3\nCELL_TYPES 1\n",
      "CELL_TYPES (line 12) has 0 of its 1 numbers, then the file ends" },
    { "# vtk DataFile Version 3.0\nt\nBINARY\nDATASET POLYDATA\nPOINTS 4 float\n" + bytes,
      "POINTS (byte 53) has 3 of its 12 numbers, then the file ends" },
    { mesh + points + "POLYGONS 2 10\n3 0 1 2\n3 0 1 2\n7 3\n",
      "POLYGONS (line 10) has 10 numbers and ends inside cell 2 (line 13)" },
    { "# vtk DataFile Version 3.0\nt\nBINARY\nDATASET POLYDATA\nPOINTS 1 float\n" + bytes +
        "\nPOLYGONS 1 4\n\3" + std::string(15, '\0'),
      "POLYGONS (byte 81) has 4 numbers and ends inside cell 0 (byte 94)" },
    { grid + points + "CELLS 1 5\n4 0 1", "CELLS (line 10) has 3 of its 5 numbers, then the file" },
    { grid + points + "CELLS 1 5\n4 0 1 2 9\nCELL_TYPES 1\n10\n",
      "CELLS: cell 0 uses point 9, but there are 4 (it is a tetra)" },
    { grid + points + "CELLS 1 4\n3 0 1 2\nCELL_TYPES 1\n10\n",
      "CELLS: cell 0 of the type 10 has 3 points, not 4 as a tetra has" },
    { mesh + points + "LINES 2 6\n2 0 1\n2 1 7\nPOLYGONS 1 4\n3 0 1 2\n",
      "LINES: cell 1 uses point 7, but there are 4" },
  };
  for (const auto& [text, message] : cases)
  {
    this->WriteText("in.vtk", text);
    this->ExpectError("in.vtk", message);
  }
  // A complete binary file of version 3. Its numbers may look like blanks and line ends.
  this->WriteText(
    "in.vtk", "# vtk DataFile Version 3.0\nt\nBINARY\nDATASET POLYDATA\nPOINTS 11 float\n" +
                std::string(132, '\0') + "\nPOLYGONS 1 4\n" +
                std::string("\0\0\0\3\0\0\0\n\0\0\0\t\0\0\0\1", 16) + "\n");
  EXPECT_EQ(this->Converted("in.vtk").triangles, (std::vector<Triangle>{ { 10, 9, 1 } }));
}

// A file that VTK can read must not be refused because the search for damage misunderstands it.
TEST_F(TestConvertDamage, VtkFilesOfOtherProgramsAreNotDamaged)
{
  const std::string head = "# vtk DataFile Version 3.0\nt\nASCII\nDATASET POLYDATA\n";
  const std::string triangle = "POLYGONS 1 4\n3 0 1 2\n";
  const std::string points = "POINTS 3 float\n1 -2 3 0 1 0 0 0 1\n";
  const std::string binary = "# vtk DataFile Version 3.0\nt\nBINARY\nDATASET POLYDATA\n";
  for (const std::string& text :
    { head + "POINTS 3 float\n0.100E+01-0.200E+01 0.300E+01\n0. 1.-0. 0.0+0.0 1.0\n" + triangle,
      head + "POINTS 3 double\n1.0-2.0 3.0\n0 1 0 0-0 1\n" + triangle,
      head + points + triangle + "POINT_DATA 3\nFIELD f 3\nnames 1 3 string\na b\n\nLINES\n" +
        "NULL_ARRAY\nnumber 1 3 int\n7 8 9\n",
      head + points + triangle + "POINT_DATA 3\nFIELD f 2\nany 1 3 variant\n6 1\n6 2\n6 3\n" +
        "number 1 3 int\n7 8 9\n",
      binary +
        "FIELD f 1\nnames 1 2 string\n\xC3"
        "abc\xC1"
        "d\nPOINTS 3 float\n" +
        std::string("\x3F\x80\0\0\xC0\0\0\0\x40\x40\0\0", 12) + std::string(24, '\0') +
        "\nPOLYGONS 1 4\n" + std::string("\0\0\0\3\0\0\0\0\0\0\0\1\0\0\0\2", 16) + "\n" })
  {
    SCOPED_TRACE(text);
    this->WriteText("in.vtk", text);
    const Outcome outcome = this->Convert("in.vtk");
    ASSERT_EQ(outcome.exitCode, 0) << outcome.err;
    const Mesh read = this->Read("out.ply");
    ASSERT_EQ(read.triangles.size(), 1U);
    EXPECT_EQ(read.points[0], (Vec3{ 1, -2, 3 }));
  }
}

TEST_F(TestConvertDamage, NestingWithoutEndDoesNotCrash)
{
  std::string json = "{\"asset\":{\"version\":\"2.0\"},\"x\":" + std::string(2000000, '[');
  this->WriteText("deep.gltf", json);
  EXPECT_TRUE(this->Refused("deep.gltf", "deep"));
  // A node that is its own child.
  GltfBuffer buffer;
  buffer.Add(std::vector<float>(9, 1.0F), "VEC3", gltfFloat);
  this->WriteText("loop.glb",
    buffer.Glb("\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0,\"children\":[0]}],"
               "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}]"));
  EXPECT_TRUE(this->Refused("loop.glb", "loop"));
}
