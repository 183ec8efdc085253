// SPDX-License-Identifier: BSD-3-Clause
// Which properties of a PLY file become which arrays: names, types, values, limits.
#include "Testing/Fixtures/TemporaryFolder.h"
#include "filters/meshio/MeshReader.h"
#include "filters/meshio/ply/PlyArrays.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>

namespace kdstream::test
{

namespace
{

using Names = std::vector<std::string>;

struct Read
{
  MeshFileInfo info;
  Mesh mesh;
  std::string error;
};

Read ReadFile(const std::string& bytes)
{
  const fixtures::TemporaryFolder folder;
  Read read;
  const auto reader = MeshReader::Open(folder.Write("mesh.ply", bytes));
  if (!reader)
  {
    read.error = reader.GetError().message;
    return read;
  }
  read.info = (*reader)->Info();
  const auto vertices = (*reader)->ReadVertices(read.mesh, SIZE_MAX);
  const auto faces = (*reader)->ReadTriangles(read.mesh, SIZE_MAX);
  read.error = vertices ? faces ? "" : faces.GetError().message : vertices.GetError().message;
  return read;
}

// Reads a file of one vertex (7, 8, 9) with these further properties and values.
Read ReadVertex(const Names& properties, const std::string& values)
{
  std::string header = "ply\nformat ascii 1.0\nelement vertex 1\nproperty uchar x\n"
                       "property uchar y\nproperty uchar z\n";
  for (const std::string& property : properties)
  {
    header += "property " + property + "\n";
  }
  return ReadFile(header + "end_header\n7 8 9 " + values + "\n");
}

// Descriptions of the form "name:type:components", with "cell " before arrays of faces.
Names Described(const std::vector<AttributeInfo>& infos)
{
  Names names;
  for (const AttributeInfo& info : infos)
  {
    names.push_back((info.association == AttributeAssociation::Cell ? "cell " : "") + info.name +
                    ":" + std::string(NameOf(info.type)) + ":" + std::to_string(info.components));
  }
  return names;
}

void ExpectArrays(const Names& properties, const Names& arrays, const Names& ignored = {})
{
  std::string values;
  for (const std::string& property : properties)
  {
    values += property.starts_with("list") ? " 1 0" : " 0";
  }
  const Read read = ReadVertex(properties, values);
  EXPECT_EQ(read.error, "");
  EXPECT_EQ(Described(read.info.attributes), arrays);
  EXPECT_EQ(read.info.ignoredAttributes, ignored);
}

}

TEST(PlyArrays, PropertiesThatBelongTogetherAreOneArray)
{
  ExpectArrays({ "float nx", "float ny", "float nz" }, { "Normals:float32:3" });
  ExpectArrays({ "double nz", "double nx", "double ny" }, { "Normals:float64:3" });
  ExpectArrays({ "uchar red", "uchar green", "uchar blue" }, { "RGB:uint8:3" });
  ExpectArrays({ "uint8 alpha", "uint8 blue", "uint8 green", "uint8 red" }, { "RGBA:uint8:4" });
  ExpectArrays(
    { "uchar diffuse_red", "uchar diffuse_green", "uchar diffuse_blue" }, { "RGB:uint8:3" });
  ExpectArrays({ "uchar r", "uchar g", "uchar b", "uchar a" }, { "RGBA:uint8:4" });
  ExpectArrays({ "float u", "float v" }, { "TCoords:float32:2" });
  ExpectArrays({ "double s", "double t" }, { "TCoords:float64:2" });
  ExpectArrays({ "float texture_u", "float texture_v" }, { "TCoords:float32:2" });
  ExpectArrays({ "int q_0", "int q_1", "int q_2" }, { "q:int32:3" });
  ExpectArrays({ "uint id_int64_0", "uint id_int64_1" }, { "id:int64:1" });
  ExpectArrays({ "uint id_uint64_0", "uint id_uint64_1", "uint id_uint64_2", "uint id_uint64_3" },
    { "id:uint64:2" });
}

TEST(PlyArrays, WhatDoesNotFitTogetherStaysApart)
{
  ExpectArrays({ "float nx", "float ny" }, { "nx:float32:1", "ny:float32:1" });
  ExpectArrays(
    { "float nx", "float ny", "double nz" }, { "nx:float32:1", "ny:float32:1", "nz:float64:1" });
  ExpectArrays({ "char nx", "char ny", "char nz" }, { "nx:int8:1", "ny:int8:1", "nz:int8:1" });
  ExpectArrays({ "float red", "float green", "float blue" },
    { "red:float32:1", "green:float32:1", "blue:float32:1", "RGB:uint8:3" }); // ShownColors.h
  ExpectArrays({ "uchar Red", "uchar GREEN", "uchar blue" }, { "RGB:uint8:3" });
  ExpectArrays({ "uchar red", "uchar green", "uchar blue", "float alpha" },
    { "RGB:uint8:3", "alpha:float32:1" });
  ExpectArrays({ "float u", "double v" }, { "u:float32:1", "v:float64:1" });
  ExpectArrays({ "int q_0" }, { "q_0:int32:1" });
  ExpectArrays({ "int q_1", "int q_2" }, { "q_1:int32:1", "q_2:int32:1" });
  ExpectArrays({ "int q_0", "uint q_1" }, { "q_0:int32:1", "q_1:uint32:1" });
  ExpectArrays({ "int q_0", "int w", "int q_1" }, { "q_0:int32:1", "w:int32:1", "q_1:int32:1" });
  ExpectArrays({ "int _0", "int _1" }, { "_0:int32:1", "_1:int32:1" });
  ExpectArrays(
    { "uint id_int64_0", "uint id_int64_1", "uint id_int64_2" }, { "id_int64:uint32:3" });
  // A second group of the same kind becomes plain arrays.
  ExpectArrays({ "float s", "float t", "float u", "float v" },
    { "s:float32:1", "t:float32:1", "TCoords:float32:2" });
  ExpectArrays(
    { "uchar r", "uchar g", "uchar b", "uchar red", "uchar green", "uchar blue", "uchar alpha" },
    { "r:uint8:1", "g:uint8:1", "b:uint8:1", "RGBA:uint8:4" });
}

TEST(PlyArrays, InvalidNamesAreReported)
{
  ExpectArrays({ "int a%20b", "int 100%", "int %zz", "int %4" },
    { "a b:int32:1", "100%:int32:1", "%zz:int32:1", "%4:int32:1" });
  ExpectArrays({ "int gr\xC3\xB6\xC3\x9F"
                 "e" },
    { "gr\xC3\xB6\xC3\x9F"
      "e:int32:1" });
  ExpectArrays({ "int caf\xE9", "int %0a", "list uchar int l", "int " + std::string(300, 'n') }, {},
    { "vertex.caf\xE9", "vertex.%0a", "vertex.l", "vertex." + std::string(300, 'n') });
  // If two arrays get the same name, the first one found counts; groups are found first.
  ExpectArrays({ "float Normals", "float nx", "float ny", "float nz", "int a%62", "int ab" },
    { "Normals:float32:3", "ab:int32:1" }, { "vertex.Normals", "vertex.ab" });
}

TEST(PlyArrays, NamesAreEscapedOnlyWhereNoOthersAreLeft)
{
  const auto properties = [](const std::vector<AttributeInfo>& infos)
  {
    std::vector<Attribute> arrays;
    for (const AttributeInfo& info : infos)
    {
      arrays.push_back({ info, {} });
    }
    std::vector<const Attribute*> pointers;
    for (const Attribute& array : arrays)
    {
      pointers.push_back(&array);
    }
    PlyElement element;
    AddPlyProperties(pointers, element);
    Names names;
    for (const PlyProperty& property : element.properties)
    {
      names.push_back(property.name);
    }
    return names;
  };
  const auto number = [](const char* name) {
    return AttributeInfo{ name, AttributeType::Float32, AttributeAssociation::Point, 1 };
  };
  const AttributeInfo colors{ "RGB", AttributeType::UInt8, AttributeAssociation::Point, 3 };
  EXPECT_EQ(properties({ colors }), (Names{ "red", "green", "blue" }));
  EXPECT_EQ(properties({ number("red"), number("green"), number("blue"), colors }),
    (Names{ "red", "green", "blue", "diffuse_red", "diffuse_green", "diffuse_blue" }));
  EXPECT_EQ(properties({ number("red"), number("diffuse_green"), colors }),
    (Names{ "red", "diffuse_green", "r", "g", "b" }));
  EXPECT_EQ(properties({ number("red"), number("diffuse_red"), number("r"), colors }),
    (Names{ "red", "diffuse_red", "r", "%52G%42_0", "%52G%42_1", "%52G%42_2" }));
  EXPECT_EQ(properties({ number("Dist (mm)") }), (Names{ "Dist%20(mm)" }));
}

TEST(PlyArrays, AtMost255AreRead)
{
  Names properties, arrays, ignored;
  for (int i = 0; i < 3000; ++i)
  {
    const std::string name = "p" + std::to_string(i);
    properties.push_back("uchar " + name);
    (i < 255 ? arrays : ignored).push_back(i < 255 ? name + ":uint8:1" : "vertex." + name);
  }
  ExpectArrays(properties, arrays, ignored);
  // An array with more components than a component number can count becomes many arrays of one
  // component.
  Names numbered, apart;
  for (int i = 0; i < 256; ++i)
  {
    numbered.push_back("uchar w_" + std::to_string(i));
    if (i < 255)
    {
      apart.push_back("w_" + std::to_string(i) + ":uint8:1");
    }
  }
  ExpectArrays(numbered, apart, { "vertex.w_255" });
  numbered.pop_back();
  ExpectArrays(numbered, { "w:uint8:255" });
}

TEST(PlyArrays, ValuesOfTextsHaveTheirPropertysType)
{
  const Read read =
    ReadVertex({ "float f", "double d", "char c", "ushort s", "float n", "double i" },
      "0.1 0.1 -128 65535 nan -inf");
  ASSERT_EQ(read.error, "");
  const std::vector<Attribute>& a = read.mesh.attributes;
  EXPECT_EQ(a.at(0).Get(0, 0), 0.1F);
  EXPECT_EQ(a.at(1).Get(0, 0), 0.1);
  EXPECT_EQ(a.at(2).Get(0, 0), -128);
  EXPECT_EQ(a.at(3).Get(0, 0), 65535);
  EXPECT_TRUE(std::isnan(a.at(4).Get(0, 0)));
  EXPECT_EQ(a.at(5).Get(0, 0), -std::numeric_limits<double>::infinity());
  EXPECT_EQ(ReadVertex({ "uchar red" }, "256").error,
    "vertex 0 (line 9): red '256' is out of range of the type uchar");
  EXPECT_EQ(ReadVertex({ "int red" }, "1.5").error,
    "vertex 0 (line 9): red '1.5' is not a number of type int");
  EXPECT_EQ(ReadVertex({ "int red" }, "").error.substr(0, 30), "truncated: vertex 0 of 1 expec");
}

TEST(PlyArrays, TruncatedRecordsAreErrors)
{
  for (const std::string order : { "little", "big" })
  {
    for (const std::string list : { "", "property list uchar uchar l\n" })
    {
      const std::string head = "ply\nformat binary_" + order +
                               "_endian 1.0\nelement vertex 2\nproperty uchar x\nproperty uchar y\n"
                               "property uchar z\n" +
                               list + "property double quality\nend_header\n";
      const std::string record = "abc" + std::string(list.empty() ? "" : "\1q") + "12345678";
      EXPECT_EQ(ReadFile(head + record + record).error, "");
      for (std::size_t missing = 1; missing < record.size(); ++missing)
      {
        const std::string bytes = head + record + record;
        EXPECT_EQ(ReadFile(bytes.substr(0, bytes.size() - missing)).error.substr(0, 24),
          "truncated: vertex 1 of 2")
          << missing;
      }
    }
  }
}

TEST(PlyArrays, FacesGiveTheirValuesToEachTriangle)
{
  const std::string vertices =
    "element vertex 5\nproperty uchar x\nproperty uchar y\nproperty uchar z\n";
  const std::string head = "ply\nformat ascii 1.0\n" + vertices +
                           "element face 2\nproperty uchar red\nproperty list uchar int "
                           "vertex_indices\nproperty uchar green\nproperty uchar blue\n"
                           "property short part\nelement tristrips 1\nproperty short part\n"
                           "property list uchar int vertex_indices\nproperty float only\n"
                           "end_header\n";
  const Read read =
    ReadFile(head + "0 0 0\n1 0 0\n2 0 0\n3 0 0\n4 0 0\n"
                    "9 5 0 1 2 3 4 8 7 -5\n1 3 0 1 2 2 3 -6\n-7 6 0 1 2 -1 3 4 1\n");
  ASSERT_EQ(read.error, "");
  EXPECT_EQ(Described(read.info.attributes), Names{ "cell part:int16:1" });
  EXPECT_EQ(read.info.ignoredAttributes,
    (Names{ "face.red", "face.green", "face.blue", "tristrips.only" }));
  ASSERT_EQ(read.mesh.triangles.size(), 5U);
  const int parts[] = { -5, -5, -5, -6, -7 };
  for (std::size_t i = 0; i < 5; ++i)
  {
    EXPECT_EQ(read.mesh.attributes.at(0).Get(i, 0), parts[i]);
  }
  // Without strips, the colours are read, for each triangle.
  const Read faces =
    ReadFile("ply\nformat ascii 1.0\n" + vertices +
             "element face 1\nproperty uchar red\nproperty list uchar int vertex_indices\n"
             "property uchar green\nproperty uchar blue\nend_header\n"
             "0 0 0\n1 0 0\n2 0 0\n3 0 0\n4 0 0\n9 4 0 1 2 3 8 7\n");
  EXPECT_EQ(Described(faces.info.attributes), Names{ "cell RGB:uint8:3" });
  EXPECT_EQ(faces.mesh.attributes.at(0).values, (std::vector<std::uint8_t>{ 9, 8, 7, 9, 8, 7 }));
  EXPECT_EQ(RoleOf(faces.info.attributes[0]), AttributeRole::Other);
}

// A few bytes must not take much memory: a polygon's properties are repeated for each of its
// triangles.
TEST(PlyArrays, APolygonRepeatsNoMoreThanTheFileWarrants)
{
  for (const std::string index : { "uint", "uchar" }) // the fast path and the slow one
  {
    for (const auto& [corners, faces] :
      { std::pair{ 40, 1 }, std::pair{ 60, 1 }, std::pair{ 60, 12 }, std::pair{ 5000, 1 } })
    {
      std::string bytes = "ply\nformat binary_little_endian 1.0\nelement vertex 1\n"
                          "property uchar x\nproperty uchar y\nproperty uchar z\n"
                          "element face " +
                          std::to_string(faces) + "\nproperty list uint " + index +
                          " vertex_indices\n";
      for (int i = 0; i < 1000; ++i)
      {
        bytes +=
          "property double p_" + std::to_string(i / 250) + "x_" + std::to_string(i % 250) + "\n";
      }
      bytes += "end_header\n123";
      const auto count = static_cast<std::uint32_t>(corners);
      for (int face = 0; face < faces; ++face)
      {
        bytes.append(reinterpret_cast<const char*>(&count), 4);
        bytes += std::string(static_cast<std::size_t>(corners) * (index == "uint" ? 4 : 1), '\0');
        bytes += std::string(8000, '\1');
      }
      const Read read = ReadFile(bytes);
      const std::size_t repeated = static_cast<std::size_t>(corners - 3) * 8000;
      // The face at which the limit is exceeded.
      const std::size_t last = 16 * bytes.size() / repeated;
      EXPECT_EQ(read.error, last >= static_cast<std::size_t>(faces)
                              ? ""
                              : "face " + std::to_string(last) +
                                  ": its properties, repeated for each of its triangles, take "
                                  "more than the file warrants")
        << corners << " " << index;
      EXPECT_EQ(read.error.empty(), corners != 5000 && faces == 1) << bytes.size();
    }
  }
}

TEST(PlyArrays, TexturesAreNamed)
{
  const Read read = ReadFile(
    "ply\nformat ascii 1.0\ncomment TextureFile wall.png\ncomment made by TextureFile\nelement "
    "vertex 1\nproperty float x\nproperty float y\nproperty float z\nend_header\n0 0 0\n");
  EXPECT_EQ(read.info.ignoredAttributes, Names{ "texture 'wall.png'" });
}

}
