// SPDX-License-Identifier: BSD-3-Clause
// kdstream-convert: the output has the same points and triangles as the input, one by one.
#include "Testing/EndToEnd/ConvertTools.h"
#include "Testing/EndToEnd/GltfFile.h"
#include "Testing/Fixtures/Meshes.h"

#include <vtkDoubleArray.h>
#include <vtkHexahedron.h>
#include <vtkImageData.h>
#include <vtkPNGWriter.h>
#include <vtkPolyDataWriter.h>
#include <vtkSTLWriter.h>
#include <vtkStringArray.h>
#include <vtkUnsignedCharArray.h>
#include <vtkUnstructuredGrid.h>
#include <vtkUnstructuredGridWriter.h>
#include <vtkXMLPolyDataWriter.h>

using namespace kdstream;
using namespace kdstream::fixtures;

namespace
{

Attribute PointArray(const std::string& name, AttributeType type, std::uint8_t components,
  const std::vector<double>& values)
{
  Attribute attribute;
  attribute.name = name;
  attribute.type = type;
  attribute.components = components;
  attribute.values.resize(values.size() * SizeOf(type));
  for (std::size_t i = 0; i < values.size(); ++i)
  {
    attribute.Set(i / components, i % components, values[i]);
  }
  return attribute;
}

// Two triangles with every kind of array.
Mesh WithAttributes()
{
  Mesh mesh;
  mesh.points = { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 }, { 4000000.001, 5000000.002, 0.1 } };
  mesh.triangles = { { 0, 1, 2 }, { 1, 3, 2 } };
  mesh.scalarType = ScalarType::Float64;
  mesh.attributes = { PointArray("RGB", AttributeType::UInt8, 3,
                        { 255, 0, 0, 0, 255, 0, 0, 0, 255, 1, 2, 3 }),
    PointArray("Normals", AttributeType::Float32, 3, { 0, 0, 1, 0, 0, 1, 0, 0, 1, 1, 0, 0 }),
    PointArray("TCoords", AttributeType::Float32, 2, { 0, 0, 1, 0, 0, 1, 0.5, 0.5 }),
    PointArray("Height", AttributeType::Float64, 1, { 0.1, 0.2, 0.3, 1e9 + 0.001 }) };
  Attribute cell = PointArray("Part", AttributeType::Int32, 1, { 7, -8 });
  cell.association = AttributeAssociation::Cell;
  mesh.attributes.push_back(cell);
  return mesh;
}

void ExpectSameArrays(const Mesh& read, const Mesh& expected, const std::string& where)
{
  for (const Attribute& attribute : expected.attributes)
  {
    const Attribute* const found = Find(read, attribute.name);
    ASSERT_TRUE(found) << where << " has lost " << attribute.name;
    EXPECT_EQ(*found, attribute) << where << ", " << attribute.name;
  }
  EXPECT_EQ(read.attributes.size(), expected.attributes.size()) << where;
}

class TestConvert : public ConvertTest
{
protected:
  // The warning that floats are too coarse for the coordinates, if it was given;
  // TestConvertWarnings checks when it must be.
  std::string FloatWarning(const std::string& file)
  {
    const std::string said = this->Convert(file).err;
    const std::string begin =
      "kdstream-convert: warning: " + file + ": coordinates are read as floats: at ";
    return said.rfind(begin, 0) == 0 && std::count(said.begin(), said.end(), '\n') == 1 ? said : "";
  }
};

}

TEST_F(TestConvert, OwnFormatsComeBack)
{
  for (const NamedMesh& named : AllMeshes())
  {
    const Mesh& mesh = named.mesh;
    for (const char* ending : { ".vtp", ".obj", ".stl" })
    {
      SCOPED_TRACE(named.name + ending);
      const bool soup = std::string(ending) == ".stl";
      if (soup && mesh.triangles.empty())
      {
        continue;
      }
      const std::string file = std::string("in") + ending;
      ASSERT_TRUE(WriteMesh(this->Folder / file, mesh));
      const Mesh read = this->Converted(file, soup ? this->FloatWarning(file) : "");
      const Mesh expected = soup ? AsFloats(mesh) : mesh;
      EXPECT_EQ(Soup(read), Soup(expected));
      if (!soup)
      {
        EXPECT_EQ(read.points, expected.points);
        EXPECT_EQ(read.triangles, expected.triangles);
      }
      if (!soup)
      {
        EXPECT_EQ(PointMultiset(read), PointMultiset(expected));
      }
      if (std::string(ending) == ".vtp")
      {
        EXPECT_EQ(read.scalarType, mesh.scalarType);
      }
    }
  }
}

TEST_F(TestConvert, VtkFilesOfEachEncodingComeBack)
{
  for (const NamedMesh& named : AllMeshes())
  {
    const auto data = ToPolyData(named.mesh);
    for (const bool ascii : { false, true })
    {
      SCOPED_TRACE(named.name + (ascii ? " ascii" : " binary"));
      vtkNew<vtkPolyDataWriter> legacy;
      legacy->SetInputData(data);
      legacy->SetFileName((this->Folder / "in.vtk").c_str());
      legacy->SetFileType(ascii ? VTK_ASCII : VTK_BINARY);
      legacy->Write();
      vtkNew<vtkXMLPolyDataWriter> xml;
      xml->SetInputData(data);
      xml->SetFileName((this->Folder / "in.vtp").c_str());
      xml->SetDataMode(ascii ? vtkXMLWriter::Ascii : vtkXMLWriter::Binary);
      xml->Write();
      for (const char* file : { "in.vtk", "in.vtp" })
      {
        const Mesh read = this->Converted(file);
        EXPECT_EQ(read.scalarType, named.mesh.scalarType) << file;
        EXPECT_EQ(read.triangles, named.mesh.triangles) << file;
        if (!ascii) // VTK writes few digits as text
        {
          EXPECT_EQ(PointMultiset(read), PointMultiset(named.mesh)) << file;
          EXPECT_EQ(Soup(read), Soup(named.mesh)) << file;
        }
      }
    }
  }
}

TEST_F(TestConvert, StlOfBothEncodingsIsJoined)
{
  const Mesh mesh = DisplacedSphere(4);
  for (const bool ascii : { false, true })
  {
    vtkNew<vtkSTLWriter> writer;
    writer->SetInputData(ToPolyData(mesh));
    writer->SetFileName((this->Folder / "in.stl").c_str());
    writer->SetFileType(ascii ? VTK_ASCII : VTK_BINARY);
    writer->Write();
    const Mesh read = this->Converted("in.stl");
    EXPECT_EQ(read.points.size(), mesh.points.size()) << "corners were not joined";
    EXPECT_EQ(read.triangles.size(), mesh.triangles.size());
    EXPECT_TRUE(BoundaryEdges(read.triangles).empty());
    if (!ascii)
    {
      EXPECT_EQ(Soup(read), Soup(mesh));
    }
  }
}

TEST_F(TestConvert, ArraysTravel)
{
  const Mesh mesh = WithAttributes();
  ASSERT_TRUE(WriteMesh(this->Folder / "in.ply", mesh));
  ASSERT_TRUE(WriteMesh(this->Folder / "in.vtp", mesh));
  vtkNew<vtkPolyDataWriter> legacy;
  legacy->SetInputData(ToPolyData(mesh));
  legacy->SetFileName((this->Folder / "in.vtk").c_str());
  legacy->SetFileTypeToBinary();
  legacy->Write();
  for (const char* file : { "in.ply", "in.vtp", "in.vtk" })
  {
    const Mesh read = this->Converted(file);
    EXPECT_EQ(read.points, mesh.points) << file;
    EXPECT_EQ(read.triangles, mesh.triangles) << file;
    ExpectSameArrays(read, mesh, file);
  }
}

TEST_F(TestConvert, WhatCannotBeCarriedIsSaid)
{
  Mesh mesh = WithAttributes();
  mesh.attributes.clear();
  const auto data = ToPolyData(mesh);
  vtkNew<vtkStringArray> names;
  names->SetName("Names");
  names->SetNumberOfValues(4);
  data->GetPointData()->AddArray(names);
  vtkNew<vtkXMLPolyDataWriter> xml;
  xml->SetInputData(data);
  xml->SetFileName((this->Folder / "in.vtp").c_str());
  xml->Write();
  const Mesh read = this->Converted("in.vtp",
    "kdstream-convert: warning: in.vtp: dropped: point array \"Names\": is not numeric\n");
  EXPECT_TRUE(read.attributes.empty());
}

TEST_F(TestConvert, PolygonsBecomeFansAndStripsTriangles)
{
  this->WriteText("in.vtk", "# vtk DataFile Version 3.0\nt\nASCII\nDATASET POLYDATA\n"
                            "POINTS 6 double\n0 0 0 1 0 0 2 1 0 1 2 0 0 2 0 9 9 9.1\n"
                            "POLYGONS 1 6\n5 0 1 2 3 4\nTRIANGLE_STRIPS 1 5\n4 0 1 2 5\n");
  const Mesh vtk = this->Converted("in.vtk");
  EXPECT_EQ(vtk.triangles,
    (std::vector<Triangle>{ { 0, 1, 2 }, { 0, 2, 3 }, { 0, 3, 4 }, { 0, 1, 2 }, { 2, 1, 5 } }));
  EXPECT_EQ(vtk.scalarType, ScalarType::Float64);
  EXPECT_EQ(vtk.points[5][2], 9.1);
  this->WriteText("in.obj", "v 0 0 0\nv 1 0 0\nv 2 1 0\nv 1 2 0\nv 0 2 0\nf 1 2 3 4 5\n");
  EXPECT_EQ(this->Converted("in.obj").triangles,
    (std::vector<Triangle>{ { 0, 1, 2 }, { 0, 2, 3 }, { 0, 3, 4 } }));
}

TEST_F(TestConvert, AGridGivesItsSurface)
{
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  vtkNew<vtkUnstructuredGrid> grid;
  for (int i = 0; i < 12; ++i)
  {
    points->InsertNextPoint(i / 4, (i / 2) % 2, i % 2);
  }
  grid->SetPoints(points);
  for (const vtkIdType first : { 0, 4 })
  {
    const vtkIdType ids[] = { first, first + 1, first + 3, first + 2, first + 4, first + 5,
      first + 7, first + 6 };
    grid->InsertNextCell(VTK_HEXAHEDRON, 8, ids);
  }
  vtkNew<vtkUnstructuredGridWriter> writer;
  writer->SetInputData(grid);
  writer->SetFileName((this->Folder / "in.vtk").c_str());
  writer->Write();
  const Mesh read = this->Converted("in.vtk", "kdstream-convert: warning: in.vtk: holds "
                                              "vtkUnstructuredGrid, whose surface is used\n");
  EXPECT_EQ(read.triangles.size(), 20U) << "ten outer faces of two boxes";
  EXPECT_TRUE(BoundaryEdges(read.triangles).empty());
}

TEST_F(TestConvert, ObjHasColorsNormalsAndTextureCoordinates)
{
  this->WriteText("in.obj",
    "# a comment\nmtllib none.mtl\no thing\nv 4000000.001 5000000.002 0 1 0 0.5\n"
    "v 1 0 0 0 1 0\nv 0 1 0 0 0 1\nv 5 5 5 1 1 1\n"
    "vt 0.25 0.75\nvt 1 1\nvn 0 0 2\nvn 0 1 0\nusemtl m\nf 1/1/1 2/2/1 \\\n3/1/1\n"
    "f -4/-1/-1 -3/2/1 -2/1/1\nl 1 2\n");
  const Mesh read = this->Converted("in.obj",
    "kdstream-convert: warning: in.obj: line 2: the materials 'none.mtl' are not there: they are "
    "drawn white\n"
    "kdstream-convert: warning: in.obj: left out: 1 line, free-form curve or surface\n");
  // The first corner of the second face uses the first vertex with other attributes, so it is
  // another point.
  EXPECT_EQ(read.triangles, (std::vector<Triangle>{ { 0, 1, 2 }, { 4, 1, 2 } }));
  EXPECT_EQ(read.points.size(), 5U);
  EXPECT_EQ(read.points[4], (Vec3{ 4000000.001, 5000000.002, 0 }));
  EXPECT_EQ(read.scalarType, ScalarType::Float64);
  EXPECT_EQ(ValuesOf(read, "RGB"),
    (std::vector<double>{ 255, 0, 128, 0, 255, 0, 0, 0, 255, 255, 255, 255, 255, 0, 128 }));
  EXPECT_EQ(ValuesOf(read, "Normals"),
    (std::vector<double>{ 0, 0, 2, 0, 0, 2, 0, 0, 2, 0, 0, 0, 0, 1, 0 }));
  EXPECT_EQ(
    ValuesOf(read, "TCoords"), (std::vector<double>{ 0.25, 0.75, 1, 1, 0.25, 0.75, 0, 0, 1, 1 }));
}

TEST_F(TestConvert, ScenesOfGltfAreJoined)
{
  GltfBuffer buffer;
  const std::vector<float> place{ 0, 0, 0, 1, 0, 0, 0, 1, 0 }, normal{ 0, 0, 1, 0, 0, 1, 0, 0, 1 };
  const std::vector<float> colors{ 1, 0, 0, 0, 1, 0, 0, 0, 1 };
  const int position = buffer.Add(place, "VEC3", gltfFloat, ",\"min\":[0,0,0],\"max\":[1,1,0]");
  const int normals = buffer.Add(normal, "VEC3", gltfFloat);
  const int color = buffer.Add(colors, "VEC3", gltfFloat);
  const int indices =
    buffer.Add(std::vector<std::uint16_t>{ 0, 1, 2, 2, 1, 0 }, "SCALAR", gltfUnsignedShort);
  const std::string common =
    "\"POSITION\":" + std::to_string(position) + ",\"NORMAL\":" + std::to_string(normals);
  const std::string scene =
    "\"scene\":0,\"scenes\":[{\"nodes\":[0,1]}],\"nodes\":[{\"mesh\":0,\"translation\":[10,0,0]},"
    // A node that is turned by a quarter around z and twice as large, below a node that is moved.
    "{\"translation\":[0,0,5],\"children\":[2]},"
    "{\"mesh\":1,\"rotation\":[0,0,0.70710678,0.70710678],\"scale\":[2,2,2]}],"
    "\"materials\":[{\"pbrMetallicRoughness\":{\"baseColorFactor\":[1,0.2158605,0,1]}}],"
    "\"meshes\":[{\"primitives\":[{\"attributes\":{" +
    common + ",\"COLOR_0\":" + std::to_string(color) + "},\"indices\":" + std::to_string(indices) +
    "},{\"attributes\":{" + common + "}}]},{\"primitives\":[{\"material\":0,\"attributes\":{" +
    common + "}}]}]";
  this->WriteText("in.glb", buffer.Glb(scene));
  this->WriteText("buffer.bin", buffer.Bytes);
  this->WriteText("in.gltf", buffer.Json(scene, "buffer.bin"));
  for (const char* file : { "in.glb", "in.gltf" })
  {
    const Mesh read = this->Converted(file);
    ASSERT_EQ(read.points.size(), 9U) << file;
    EXPECT_EQ(
      read.triangles, (std::vector<Triangle>{ { 0, 1, 2 }, { 2, 1, 0 }, { 3, 4, 5 }, { 6, 7, 8 } }))
      << file;
    EXPECT_EQ(read.points[1], (Vec3{ 11, 0, 0 })) << file;
    EXPECT_NEAR(read.points[7][0], 0, 1e-6) << file;
    EXPECT_NEAR(read.points[7][1], 2, 1e-6) << file;
    EXPECT_NEAR(read.points[7][2], 5, 1e-6) << file;
    // Three vertices with colours, three without, and three with a material's colour: 0.2158605 of
    // light is 128 in sRGB.
    EXPECT_EQ(ValuesOf(read, "RGB"),
      (std::vector<double>{ 255, 0, 0, 0, 255, 0, 0, 0, 255, 255, 255, 255, 255, 255, 255, 255, 255,
        255, 255, 128, 0, 255, 128, 0, 255, 128, 0 }))
      << file;
    EXPECT_EQ(ValuesOf(read, "Normals").size(), 27U) << file;
  }
}

TEST_F(TestConvert, TexturesAreBakedToVertices)
{
  // A picture of two by two texels: red and green above, blue and white below.
  vtkNew<vtkImageData> image;
  image->SetDimensions(2, 2, 1);
  image->AllocateScalars(VTK_UNSIGNED_CHAR, 3);
  const unsigned char below[] = { 0, 0, 255, 255, 255, 255 }, above[] = { 255, 0, 0, 0, 255, 0 };
  std::memcpy(image->GetScalarPointer(0, 0, 0), below, 6);
  std::memcpy(image->GetScalarPointer(0, 1, 0), above, 6);
  vtkNew<vtkPNGWriter> png;
  png->SetInputData(image);
  png->SetFileName((this->Folder / "in.png").c_str());
  png->Write();
  const std::string picture = ReadWhole(this->Folder / "in.png");

  GltfBuffer buffer;
  // A triangle in each texel: upper left, upper right, lower left, and lower right by repetition.
  std::vector<float> places, texels;
  for (const auto& [u, v] : { std::pair{ 0.2F, 0.2F }, std::pair{ 0.7F, 0.2F },
         std::pair{ 0.2F, 0.7F }, std::pair{ 1.7F, -0.3F } })
  {
    const auto at = static_cast<float>(places.size());
    places.insert(places.end(), { at, 0, 0, at + 1, 0, 0, at, 1, 0 });
    texels.insert(texels.end(), { u, v, u + 0.1F, v, u, v + 0.1F });
  }
  const int position = buffer.Add(places, "VEC3", gltfFloat, ",\"min\":[0,0,0],\"max\":[28,1,0]");
  const int coordinates = buffer.Add(texels, "VEC2", gltfFloat);
  const int indices = buffer.Add(
    std::vector<std::uint8_t>{ 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11 }, "SCALAR", gltfUnsignedByte);
  const int view = buffer.AddView(picture.data(), picture.size());
  this->WriteText("in.glb",
    buffer.Glb("\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0}],\"images\":[{"
               "\"mimeType\":\"image/png\",\"bufferView\":" +
               std::to_string(view) +
               "}],\"samplers\":[{}],\"textures\":[{\"source\":0,\"sampler\":0}],\"materials\":[{"
               "\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0}}}],\"meshes\":[{"
               "\"primitives\":[{\"material\":0,\"attributes\":{\"POSITION\":" +
               std::to_string(position) + ",\"TEXCOORD_0\":" + std::to_string(coordinates) +
               "},\"indices\":" + std::to_string(indices) + "}]}]"));
  const Mesh read = this->Converted("in.glb",
    "kdstream-convert: warning: in.glb: textures are baked to the colours of vertices: about "
    "0.00667 "
    "texels a vertex; the pictures are 0.0 of 255 grey values off (RMS)\n");
  std::vector<double> expected;
  for (const std::vector<double>& color :
    { std::vector<double>{ 255, 0, 0 }, { 0, 255, 0 }, { 0, 0, 255 }, { 255, 255, 255 } })
  {
    for (int corner = 0; corner < 3; ++corner)
    {
      expected.insert(expected.end(), color.begin(), color.end());
    }
  }
  EXPECT_EQ(ValuesOf(read, "RGB"), expected);
}

TEST_F(TestConvert, XyzKnowsItsColumns)
{
  const auto read = [&](const std::string& text, const std::string& warnings = "")
  {
    this->WriteText("in.xyz", text);
    return this->Converted("in.xyz", warnings);
  };
  const Mesh plain = read("# header\n3\n1 2 3\n\n// more\r\n 4.5,5;6\t\r\n-1e3 +0.25 .5");
  EXPECT_EQ(plain.points, (std::vector<Vec3>{ { 1, 2, 3 }, { 4.5, 5, 6 }, { -1000, 0.25, 0.5 } }));
  EXPECT_EQ(plain.scalarType, ScalarType::Float32);
  EXPECT_TRUE(plain.attributes.empty());
  // Floats written with nine digits are read as floats, other numbers as doubles.
  EXPECT_EQ(read("0.100000001 16777216 1.5e-7\n").scalarType, ScalarType::Float32);
  EXPECT_EQ(read("0.123456789 0 0\n").scalarType, ScalarType::Float64);
  EXPECT_EQ(read("16777217 0 0\n").scalarType, ScalarType::Float64);
  EXPECT_EQ(read("1.00000001e2 0 0\n").scalarType, ScalarType::Float64);
  const Mesh far = read("4000000.001 5000000.002 0.003\n");
  EXPECT_EQ(far.scalarType, ScalarType::Float64);
  EXPECT_EQ(far.points[0], (Vec3{ 4000000.001, 5000000.002, 0.003 }));
  EXPECT_EQ(ValuesOf(read("1 2 3 0.5\n4 5 6 0.75\n"), "Intensity"), (std::vector{ 0.5, 0.75 }));
  EXPECT_EQ(ValuesOf(read("1 2 3 255 0 7\n"), "RGB"), (std::vector<double>{ 255, 0, 7 }));
  EXPECT_EQ(ValuesOf(read("1 2 3 0 0.6 0.8\n1 2 3 0 1 0\n"), "Normals").size(), 6U);
  const Mesh seven = read("1 2 3 0.5 255 0 7\n");
  EXPECT_EQ(ValuesOf(seven, "Intensity"), (std::vector{ 0.5 }));
  EXPECT_EQ(ValuesOf(seven, "RGB"), (std::vector<double>{ 255, 0, 7 }));
  const Mesh nine = read("1 2 3 255 0 7 0 0 1\n");
  EXPECT_EQ(ValuesOf(nine, "RGB"), (std::vector<double>{ 255, 0, 7 }));
  EXPECT_EQ(ValuesOf(nine, "Normals"), (std::vector<double>{ 0, 0, 1 }));
  EXPECT_EQ(
    read("1 2 3\nnan 1 2\n4 5 inf\n7 8 9\n",
      "kdstream-convert: warning: in.xyz: 2 points are not finite and are dropped; the first: "
      "line 2\n")
      .points,
    (std::vector<Vec3>{ { 1, 2, 3 }, { 7, 8, 9 } }));
}

TEST_F(TestConvert, TextIsRefusedWithItsLine)
{
  const struct
  {
    const char *file, *text, *error;
  } cases[] = {
    { "a.xyz", "1 2 3\n4 5\n", "line 2: has 2 columns; those before have 3" },
    { "b.xyz", "1 2 x\n", "line 1: 'x' (column 3) is not a number" },
    { "c.xyz", "1 2 3\n1e999 2 3\n", "line 2: '1e999' (column 1) is too large a number" },
    { "f.xyz", "nan nan nan\n", "holds no points; 1 point is not finite" },
    { "g.xyz", "", "is empty" },
    { "a.obj", "v 1 2 3\nf 1 1 2\n", "face 0 (line 2) names vertex 2, but there is only 1" },
    { "b.obj", "v 1 2 3\nf 1 1 -2\n",
      "face 0 (line 2) names vertex -2, but only 1 comes before it" },
    { "c.obj", "v 1 2 3\nf 1 1 0\n", "face 0 (line 2): '0' is not the number of a vertex" },
    { "f.obj", "v 1 2\n", "vertex 0 (line 1): a vertex of 2 numbers" },
    { "g.obj", "v 1 2 nan\n", "holds no points; 1 point is not finite" },
    { "i.obj", "vt 0.5 0.5\n", "holds no points" },
    { "j.obj", "hello\nworld\n", "is not an OBJ file" },
    { "k.obj", "v 1 2 3\nf 99999999999999999999 1 1\n", "is not the number of a vertex" },
    { "a.vtk",
      "# vtk DataFile Version 3.0\nt\nASCII\nDATASET POLYDATA\nPOINTS 2 float\n0 0 0 1 1 "
      "1\nPOLYGONS 1 4\n3 0 1 7\n",
      "cell 0 uses point 7, but there are 2" },
    { "b.vtk",
      "# vtk DataFile Version 3.0\nt\nASCII\nDATASET POLYDATA\nPOINTS 2 float\n0 0 0 1 two "
      "1\n",
      "POINTS (line 5) has 4 of its 6 numbers, then 'two'" },
    { "c.vtk", "# vtk DataFile Version 3.0\nt\nASCII\nFIELD f 1\na 1 1 float\n1\n",
      "has no DATASET: it contains no mesh" },
    { "a.stl", "solid nothing\nendsolid nothing\n", "holds no points" },
    { "a.gltf", "{\"asset\":{\"version\":\"2.0\"}}", "" },
    { "a.vtp", "<?xml version=\"1.0\"?><VTKFile type=\"PolyData\"><PolyData/></VTKFile>",
      "it has no <Piece>" },
    { "b.vtp",
      "<?xml version=\"1.0\"?><VTKFile type=\"PolyData\"><PolyData><Piece NumberOfPoints=\"1\"/>"
      "</PolyData></VTKFile>",
      "<Piece> has no <Points>" },
    { "c.vtp",
      "<?xml version=\"1.0\"?><VTKFile type=\"PolyData\"><PolyData><Piece NumberOfPoints=\"2\">"
      "<Points><DataArray type=\"Float32\" NumberOfComponents=\"3\" format=\"ascii\">nan 0 0 1 nan "
      "0"
      "</DataArray></Points></Piece></PolyData></VTKFile>",
      "holds no points; 2 points are not finite" },
  };
  for (const auto& c : cases)
  {
    this->WriteText(c.file, c.text);
    this->ExpectError(c.file, c.error);
  }
  this->ExpectError("missing.stl", "no such file");
  std::filesystem::create_directory(this->Folder / "folder.obj");
  this->ExpectError("folder.obj", "");
}

TEST_F(TestConvert, WrongUsage)
{
  this->WriteText("in.xyz", "1 2 3\n");
  const std::vector<std::vector<std::string>> wrong{ {}, { "in.xyz" }, { "-o", "out.ply" },
    { "in.xyz", "-o", "out.ply", "--nonsense" },
    { "in.xyz", "-o", "out.ply", "--reconstruct", "best" }, { "in.xyz", "-o", "in.xyz" } };
  for (const auto& arguments : wrong)
  {
    EXPECT_EQ(RunTool(this->Folder, "convert", arguments).exitCode, 2);
  }
  EXPECT_EQ(RunTool(this->Folder, "convert", { "in.xyz", "-o", "out.doc" }).exitCode, 2);
  EXPECT_EQ(RunTool(this->Folder, "convert", { "in.xyz", "-o", "in.xyz/out.ply" }).exitCode, 1);
  EXPECT_EQ(RunTool(this->Folder, "convert", { "--help" }).exitCode, 0);
  EXPECT_EQ(RunTool(this->Folder, "convert", { "--version" }).out, "kdstream-convert 0.9.0\n");
  EXPECT_EQ(this->Files(), (std::set<std::string>{ "in.xyz" }));
}
