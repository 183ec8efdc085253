// SPDX-License-Identifier: BSD-3-Clause
// MeshWriter: for every format, a few lines of independent code here read the file back exactly.
#include "Testing/Fixtures/Attributes.h"
#include "Testing/Fixtures/ErrorAt.h"
#include "Testing/Fixtures/TemporaryFolder.h"
#include "filters/meshio/MeshReader.h"
#include "filters/meshio/MeshWriter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cctype>
#include <cmath>
#include <cstring>
#include <iterator>
#include <locale>
#include <random>
#include <sstream>

namespace kdstream::test
{

namespace
{

Mesh RandomMesh(unsigned seed, ScalarType type, std::size_t points, std::size_t triangles)
{
  std::mt19937_64 random(seed);
  Mesh mesh;
  mesh.scalarType = type;
  for (std::size_t i = 0; i < points; ++i)
  {
    Vec3 point{};
    for (double& value : point)
    {
      const float single = std::bit_cast<float>(static_cast<std::uint32_t>(random()));
      const double wide = std::bit_cast<double>(random());
      value = type == ScalarType::Float32 ? static_cast<double>(single) : wide;
      value = std::isfinite(value) ? value : -0.0;
    }
    mesh.points.push_back(point);
  }
  for (std::size_t i = 0; i < triangles; ++i)
  {
    Triangle& triangle = mesh.triangles.emplace_back();
    for (VertexId& corner : triangle)
    {
      corner = static_cast<VertexId>(random() % points);
    }
  }
  return mesh;
}

std::vector<Mesh> Meshes()
{
  std::vector<Mesh> meshes;
  for (const ScalarType type : { ScalarType::Float32, ScalarType::Float64 })
  {
    meshes.push_back(RandomMesh(1, type, 0, 0));
    meshes.push_back(RandomMesh(2, type, 1, 0));
    meshes.push_back(RandomMesh(3, type, 1, 1));
    meshes.push_back(RandomMesh(4, type, 500, 0));
    meshes.push_back(RandomMesh(5, type, 50000, 120000));
    for (const std::size_t points : { 1, 7, 300 })
    {
      meshes.push_back(fixtures::WithAttributes(RandomMesh(6, type, points, 2 * points), 1));
      meshes.push_back(fixtures::WithAttributes(RandomMesh(7, type, points, 1), 2));
    }
  }
  return meshes;
}

void ExpectSame(const Mesh& a, const Mesh& b)
{
  EXPECT_EQ(a.scalarType, b.scalarType);
  ASSERT_EQ(a.points.size(), b.points.size());
  EXPECT_TRUE(a.points.empty() ||
              std::memcmp(a.points.data(), b.points.data(), a.points.size() * sizeof(Vec3)) == 0);
  EXPECT_EQ(a.triangles, b.triangles);
}

std::string Written(const Mesh& mesh, const std::string& name)
{
  const fixtures::TemporaryFolder folder;
  const Status written = WriteMesh(folder / name, mesh);
  EXPECT_TRUE(written) << written.GetError().message;
  EXPECT_EQ(folder.Names().size(), 1U);
  return written ? fixtures::ReadWhole(folder / name) : "";
}

// Parses a number in the scalar type of the mesh.
double FromText(const std::string& word, ScalarType type)
{
  return type == ScalarType::Float32 ? static_cast<double>(std::strtof(word.c_str(), nullptr))
                                     : std::strtod(word.c_str(), nullptr);
}

template <class T>
T FromBytes(const std::string& bytes, std::size_t at)
{
  EXPECT_LE(at + sizeof(T), bytes.size());
  T value{};
  std::memcpy(&value, bytes.data() + at, at + sizeof(T) <= bytes.size() ? sizeof(T) : 0);
  return value;
}

std::size_t After(const std::string& text, const std::string& what, std::size_t from = 0)
{
  const std::size_t at = text.find(what, from);
  EXPECT_NE(at, std::string::npos) << what;
  return at == std::string::npos ? text.size() : at + what.size();
}

const Attribute* RoleIn(const Mesh& mesh, AttributeRole role)
{
  const auto found = std::find_if(mesh.attributes.begin(), mesh.attributes.end(),
    [role](const Attribute& attribute) { return RoleOf(attribute) == role; });
  return found == mesh.attributes.end() ? nullptr : &*found;
}

// Expects the tuple as the last words of a line; zeros if a value of it is not finite.
void ExpectTextTuple(
  const std::vector<std::string>& words, const Attribute& array, std::size_t tuple)
{
  ASSERT_GE(words.size(), array.components);
  bool finite = true;
  for (std::size_t k = 0; k < array.components; ++k)
  {
    finite = finite && std::isfinite(array.Get(tuple, k));
  }
  for (std::size_t k = 0; k < array.components; ++k)
  {
    const auto type =
      array.type == AttributeType::Float32 ? ScalarType::Float32 : ScalarType::Float64;
    const double value = FromText(words[words.size() - array.components + k], type);
    ASSERT_EQ(value, finite ? array.Get(tuple, k) : 0);
  }
}

}

TEST(MeshWriter, WritesPlyThatReadsBack)
{
  for (const Mesh& mesh : Meshes())
  {
    const fixtures::TemporaryFolder folder;
    const auto file = folder / "mesh.ply";
    ASSERT_TRUE(WriteMesh(file, mesh));
    Result<std::unique_ptr<MeshReader>> reader = MeshReader::Open(file);
    ASSERT_TRUE(reader) << reader.GetError().message;
    Mesh back;
    ASSERT_TRUE((*reader)->ReadVertices(back, SIZE_MAX));
    ASSERT_TRUE((*reader)->ReadTriangles(back, SIZE_MAX));
    ExpectSame(back, mesh);
    EXPECT_EQ(back.attributes, mesh.attributes);
    EXPECT_TRUE((*reader)->Info().ignoredAttributes.empty());
    EXPECT_TRUE(AttributesLeftOut(file, mesh).empty());
    EXPECT_EQ((*reader)->Position(), (*reader)->FileSize());
  }
}

TEST(MeshWriter, WritesObjThatReadsBack)
{
  for (const Mesh& mesh : Meshes())
  {
    const Attribute* const colors = RoleIn(mesh, AttributeRole::Colors);
    const Attribute* const normals = RoleIn(mesh, AttributeRole::Normals);
    const Attribute* const texture = RoleIn(mesh, AttributeRole::TextureCoordinates);
    std::istringstream text(Written(mesh, "mesh.OBJ"));
    Mesh back;
    back.scalarType = mesh.scalarType;
    std::size_t normal = 0, coordinate = 0;
    for (std::string line; std::getline(text, line);)
    {
      std::istringstream words(line);
      std::vector<std::string> word(std::istream_iterator<std::string>(words), {});
      if (word[0] == "v")
      {
        ASSERT_EQ(word.size(), colors ? 7U : 4U);
        for (std::size_t k = 0; colors && k < 3; ++k)
        {
          ASSERT_EQ(std::lround(std::stod(word[4 + k]) * 255), colors->Get(back.points.size(), k));
        }
        back.points.push_back({ FromText(word[1], mesh.scalarType),
          FromText(word[2], mesh.scalarType), FromText(word[3], mesh.scalarType) });
      }
      else if (word[0] == "vn" || word[0] == "vt")
      {
        const Attribute* const array = word[0] == "vn" ? normals : texture;
        ASSERT_NE(array, nullptr);
        ExpectTextTuple(word, *array, word[0] == "vn" ? normal++ : coordinate++);
      }
      else
      {
        ASSERT_EQ(word[0], "f");
        Triangle& triangle = back.triangles.emplace_back();
        for (std::size_t k = 0; k < 3; ++k)
        {
          const std::string number = word[1 + k].substr(0, word[1 + k].find('/'));
          triangle[k] = static_cast<VertexId>(std::stoul(number) - 1);
          ASSERT_EQ(word[1 + k], number + (normals ? "/" + number + "/" + number : ""));
        }
      }
    }
    ExpectSame(back, mesh);
    EXPECT_EQ(normal, normals ? mesh.points.size() : 0);
    EXPECT_EQ(coordinate, texture ? mesh.points.size() : 0);
  }
}

TEST(MeshWriter, WritesVrmlThatReadsBack)
{
  for (const Mesh& mesh : Meshes())
  {
    const std::string text = Written(mesh, "mesh.wrl");
    EXPECT_TRUE(text.starts_with("#VRML V2.0 utf8\n"));
    EXPECT_EQ(text.find("PointSet") != std::string::npos, mesh.triangles.empty());
    Mesh back;
    back.scalarType = mesh.scalarType;
    std::istringstream points(text.substr(After(text, "point [")));
    std::string word;
    for (std::size_t k = 0; points >> word && word != "]"; ++k)
    {
      if (k % 3 == 0)
      {
        back.points.emplace_back();
      }
      back.points.back()[k % 3] = FromText(word, mesh.scalarType);
    }
    if (const Attribute* const colors = RoleIn(mesh, AttributeRole::Colors))
    {
      std::istringstream values(text.substr(After(text, "color [")));
      for (std::size_t i = 0; i < mesh.points.size() * 3; ++i)
      {
        ASSERT_TRUE(values >> word);
        ASSERT_EQ(std::lround(std::stod(word) * 255), colors->Get(i / 3, i % 3));
      }
      ASSERT_TRUE(values >> word);
      EXPECT_EQ(word, "]");
    }
    if (const Attribute* const normals = RoleIn(mesh, AttributeRole::Normals))
    {
      std::istringstream values(text.substr(After(text, "vector [\n")));
      std::string line;
      for (std::size_t i = 0; i < mesh.points.size(); ++i)
      {
        std::getline(values, line);
        std::istringstream words(line);
        ExpectTextTuple({ std::istream_iterator<std::string>(words), {} }, *normals, i);
      }
      std::getline(values, line);
      EXPECT_EQ(line, "] }");
    }
    if (!mesh.triangles.empty())
    {
      std::istringstream corners(text.substr(After(text, "coordIndex [")));
      VertexId a = 0;
      VertexId b = 0;
      VertexId c = 0;
      int end = 0;
      while (corners >> a >> b >> c >> end)
      {
        EXPECT_EQ(end, -1);
        back.triangles.push_back({ a, b, c });
      }
    }
    EXPECT_EQ(std::count(text.begin(), text.end(), '{'), std::count(text.begin(), text.end(), '}'));
    ExpectSame(back, mesh);
  }
}

TEST(MeshWriter, WritesStlWithCornersAndNormals)
{
  for (const Mesh& mesh : Meshes())
  {
    if (mesh.triangles.empty() && !mesh.points.empty())
    {
      continue; // the writer refuses this
    }
    const std::string bytes = Written(mesh, "mesh.stl");
    ASSERT_EQ(bytes.size(), 84 + 50 * mesh.triangles.size());
    EXPECT_FALSE(bytes.starts_with("solid"));
    EXPECT_EQ(FromBytes<std::uint32_t>(bytes, 80), mesh.triangles.size());
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
    {
      for (std::size_t corner = 0; corner < 3; ++corner)
      {
        for (std::size_t k = 0; k < 3; ++k)
        {
          const float value = FromBytes<float>(bytes, 84 + 50 * i + 12 * (corner + 1) + 4 * k);
          ASSERT_EQ(value, static_cast<float>(mesh.points[mesh.triangles[i][corner]][k]));
        }
      }
    }
  }
  Mesh mesh;
  mesh.points = { { 0, 0, 0 }, { 2, 0, 0 }, { 0, 3, 0 } };
  mesh.triangles = { { 0, 1, 2 }, { 0, 2, 1 }, { 0, 1, 1 } };
  const std::string bytes = Written(mesh, "mesh.stl");
  for (std::size_t i = 0; i < 3; ++i)
  {
    EXPECT_EQ(FromBytes<float>(bytes, 84 + 50 * i), 0);
    EXPECT_EQ(FromBytes<float>(bytes, 84 + 50 * i + 4), 0);
    EXPECT_EQ(FromBytes<float>(bytes, 84 + 50 * i + 8), (std::array{ 1.0F, -1.0F, 0.0F })[i]);
  }
}

// Also checks that the appended arrays lie where the XML says.
TEST(MeshWriter, WritesVtpThatReadsBack)
{
  for (const Mesh& mesh : Meshes())
  {
    const std::string text = Written(mesh, "mesh.vtp");
    const bool cloud = mesh.triangles.empty();
    const bool single = mesh.scalarType == ScalarType::Float32;
    const std::size_t data = After(text, "<AppendedData encoding=\"raw\">\n_");
    // Returns where an array's bytes are, and checks the number of bytes that is written before
    // them.
    const auto arrayOf = [&](const std::string& name, std::uint64_t bytes)
    {
      const std::size_t tag = text.find("Name=\"" + name + "\"");
      const std::size_t at = data + std::stoul(text.substr(After(text, "offset=\"", tag)));
      EXPECT_EQ(FromBytes<std::uint64_t>(text, at), bytes) << name;
      return at + sizeof(std::uint64_t);
    };
    EXPECT_NE(text.find("header_type=\"UInt64\""), std::string::npos);
    EXPECT_NE(text.find("NumberOfPoints=\"" + std::to_string(mesh.points.size()) + "\""),
      std::string::npos);
    EXPECT_NE(text.find("NumberOfPolys=\"" + std::to_string(mesh.triangles.size()) + "\""),
      std::string::npos);
    const std::size_t cells = cloud ? mesh.points.size() : mesh.triangles.size();
    EXPECT_NE(
      text.find("NumberOfVerts=\"" + std::to_string(cloud ? cells : 0) + "\""), std::string::npos);

    Mesh back;
    back.scalarType = mesh.scalarType;
    const std::size_t scalarSize = single ? 4 : 8;
    const std::size_t points = arrayOf("Points", mesh.points.size() * 3 * scalarSize);
    for (std::size_t i = 0; i < mesh.points.size() * 3; ++i)
    {
      if (i % 3 == 0)
      {
        back.points.emplace_back();
      }
      back.points.back()[i % 3] = single
                                    ? static_cast<double>(FromBytes<float>(text, points + 4 * i))
                                    : FromBytes<double>(text, points + 8 * i);
    }
    const std::size_t corners = cloud ? 1 : 3;
    const std::size_t connectivity = arrayOf("connectivity", cells * corners * 8);
    const std::size_t offsets = arrayOf("offsets", cells * 8);
    for (std::size_t i = 0; i < cells; ++i)
    {
      ASSERT_EQ(FromBytes<std::uint64_t>(text, offsets + 8 * i), (i + 1) * corners);
      const auto corner = [&](std::size_t k)
      {
        return static_cast<VertexId>(
          FromBytes<std::uint64_t>(text, connectivity + 8 * (i * corners + k)));
      };
      if (cloud)
      {
        ASSERT_EQ(corner(0), i);
      }
      else
      {
        back.triangles.push_back({ corner(0), corner(1), corner(2) });
      }
    }
    ExpectSame(back, mesh);
    for (const Attribute& attribute : mesh.attributes)
    {
      const bool isPoint = attribute.association == AttributeAssociation::Point;
      const std::string name =
        attribute.name.starts_with('<') ? "&lt;&quot;Größe&quot; &amp; 'mehr'&gt;" : attribute.name;
      std::string type(NameOf(attribute.type));
      type[type[0] == 'u'] = static_cast<char>(std::toupper(type[type[0] == 'u']));
      type[0] = static_cast<char>(std::toupper(type[0]));
      const std::string tag = "<DataArray type=\"" + type + "\" Name=\"" + name +
                              "\" NumberOfComponents=\"" +
                              std::to_string(int{ attribute.components }) + "\"";
      const std::size_t section = text.find(isPoint ? "<PointData" : "<CellData");
      const std::size_t declared = text.find(tag, section);
      ASSERT_LT(declared, text.find(isPoint ? "</PointData" : "</CellData")) << tag;
      const std::size_t at = data + std::stoul(text.substr(After(text, "offset=\"", declared)));
      ASSERT_EQ(FromBytes<std::uint64_t>(text, at), attribute.values.size());
      ASSERT_EQ(text.compare(at + 8, attribute.values.size(),
                  reinterpret_cast<const char*>(attribute.values.data()), attribute.values.size()),
        0);
    }
    EXPECT_TRUE(text.ends_with("</VTKFile>\n"));
  }
}

TEST(MeshWriter, WritesTheSameInEveryLocale)
{
  struct Comma : std::numpunct<char>
  {
    char do_decimal_point() const override { return ','; }
    char do_thousands_sep() const override { return '.'; }
    std::string do_grouping() const override { return "\3"; }
  };
  const Mesh mesh = RandomMesh(8, ScalarType::Float32, 2000, 3000);
  const std::string plain = Written(mesh, "mesh.obj");
  const std::locale before = std::locale::global(std::locale(std::locale::classic(), new Comma));
  const std::string other = Written(mesh, "mesh.obj");
  std::locale::global(before);
  EXPECT_EQ(plain, other);
}

TEST(MeshWriter, NamesWhatAFormatLeavesOut)
{
  Mesh mesh;
  for (const char* name : { "Normals", "RGB", "TCoords", "RGBA", "any" })
  {
    Attribute attribute;
    attribute.name = name;
    const bool color = attribute.name.starts_with("RGB");
    attribute.type = color ? AttributeType::UInt8 : AttributeType::Float32;
    attribute.components = attribute.name == "TCoords" ? 2 : attribute.name == "RGBA" ? 4 : 3;
    mesh.attributes.push_back(attribute);
  }
  using Names = std::vector<std::string>;
  EXPECT_EQ(AttributesLeftOut("a.ply", mesh), Names{});
  EXPECT_EQ(AttributesLeftOut("a.VTP", mesh), Names{});
  EXPECT_EQ(AttributesLeftOut("a.obj", mesh), (Names{ "RGBA", "any" }));
  EXPECT_EQ(AttributesLeftOut("a.wrl", mesh), (Names{ "TCoords", "RGBA", "any" }));
  EXPECT_EQ(
    AttributesLeftOut("a.stl", mesh), (Names{ "Normals", "RGB", "TCoords", "RGBA", "any" }));
}

TEST(MeshWriter, RefusesWhatItCannotWrite)
{
  const fixtures::TemporaryFolder folder;
  Mesh mesh = RandomMesh(9, ScalarType::Float32, 8, 4);
  for (const std::string name : { "mesh.glb", "mesh", "mesh.ply.gz" })
  {
    const Status written = WriteMesh(folder / name, mesh);
    ASSERT_FALSE(written);
    EXPECT_EQ(written.GetError().code, ErrorCode::InvalidArgument);
    EXPECT_NE(
      written.GetError().message.find("names no format that can be written"), std::string::npos);
  }
  const Status missing = WriteMesh(folder / "no/mesh.ply", mesh);
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.GetError().code, ErrorCode::InputOutput);
  mesh.triangles[2][1] = 8;
  for (const std::string ending : { ".ply", ".stl", ".obj", ".vtp", ".wrl" })
  {
    const Status written = WriteMesh(folder / ("mesh" + ending), mesh);
    ASSERT_FALSE(written);
    EXPECT_TRUE(fixtures::FailsAt(written, ErrorCode::InvalidInput, "triangle 2"));
  }
  mesh.triangles[2][1] = 7;
  Mesh cloud = mesh;
  cloud.triangles.clear();
  const Status pointsAlone = WriteMesh(folder / "mesh.stl", cloud);
  ASSERT_FALSE(pointsAlone);
  EXPECT_EQ(pointsAlone.GetError().code, ErrorCode::InvalidArgument);
  for (const std::string ending : { ".ply", ".stl", ".obj", ".vtp", ".wrl" })
  {
    const auto expectRefused = [&](const Attribute& attribute, const std::string& what)
    {
      mesh.attributes = { attribute };
      const Status written = WriteMesh(folder / ("mesh" + ending), mesh);
      EXPECT_TRUE(fixtures::FailsAt(written, ErrorCode::InvalidInput, "attribute 0"));
      EXPECT_TRUE(fixtures::FailsAt(written, ErrorCode::InvalidInput, what));
    };
    Attribute attribute;
    attribute.name = "caf\xE9";
    attribute.values.resize(8 * 4);
    expectRefused(attribute, "name");
    attribute.name = "short";
    attribute.values.pop_back();
    expectRefused(attribute, "31 bytes");
  }
  EXPECT_EQ(folder.Names().size(), 0U);
}

}
