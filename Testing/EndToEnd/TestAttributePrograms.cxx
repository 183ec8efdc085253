// SPDX-License-Identifier: BSD-3-Clause
// Attributes and large coordinates through kdstream-build and kdstream-store, file to file.
#include "Testing/EndToEnd/Process.h"
#include "Testing/Fixtures/Attributes.h"
#include "Testing/Fixtures/Meshes.h"
#include "Testing/Fixtures/ReadMeshFile.h"
#include "filters/core/Weld.h"
#include "filters/meshio/MeshReader.h"
#include "filters/meshio/MeshWriter.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <random>

using namespace kdstream;
using namespace kdstream::fixtures;
using Json = nlohmann::json;

namespace
{

class AttributePrograms : public ::testing::Test
{
protected:
  std::string Build(std::vector<std::string> arguments)
  {
    arguments.insert(arguments.begin(), { "in.ply", "-o", "m.kds", "--quiet" });
    const Outcome outcome = RunTool(this->Folder, "build", arguments);
    EXPECT_EQ(outcome.exitCode, 0) << outcome.err;
    return outcome.err;
  }
  // Extracts with kdstream-store, and returns what it writes to stderr.
  std::string Extract(std::vector<std::string> what, const std::string& output)
  {
    what.insert(what.begin(), { "extract", "m.kds", "-o", output, "--quiet" });
    const Outcome outcome = RunTool(this->Folder, "store", what);
    EXPECT_EQ(outcome.exitCode, 0) << outcome.err;
    return outcome.err;
  }
  void Write(const Mesh& mesh) { ASSERT_TRUE(WriteMesh(this->Folder / "in.ply", mesh)); }
  Mesh Read(const std::string& name) { return ReadMeshFile(this->Folder / name); }

  TemporaryFolder Folder;
};

std::vector<AttributeInfo> InfosOf(const Mesh& mesh)
{
  std::vector<AttributeInfo> infos;
  for (const Attribute& attribute : mesh.attributes)
  {
    infos.push_back(attribute.Info());
  }
  return infos;
}

// A torus of 100 m by 60 m in UTM coordinates, in metres, with details of a millimetre and less.
Mesh GeoReferenced()
{
  std::mt19937 random(4);
  std::uniform_real_distribution<double> millimetre(-0.001, 0.001);
  Mesh mesh = Torus(200, 100);
  mesh.scalarType = ScalarType::Float64;
  for (Vec3& point : mesh.points)
  {
    const Vec3 offset{ 4e6 + 512.123, 5.3e6 + 77.789, 143.25 };
    for (std::size_t k = 0; k < 3; ++k)
    {
      point[k] = offset[k] + 35 * point[k] + millimetre(random);
    }
  }
  return mesh;
}

}

TEST_F(AttributePrograms, AllOfALosslessStoreHasEveryArray)
{
  const Mesh mesh = WithAttributes(Torus(60, 30), 8);
  this->Write(mesh);
  for (const std::string weld : { "off", "on" })
  {
    EXPECT_EQ(
      this->Build({ "--precision", "lossless", "--weld", weld, "--vertices-per-partition", "150" }),
      "");
    EXPECT_EQ(this->Extract({ "--all" }, "out.ply"), "");
    const Mesh out = this->Read("out.ply");
    EXPECT_EQ(InfosOf(out), InfosOf(mesh));
    EXPECT_TRUE(ContentOf(out) == ContentOf(mesh)) << "no two points of a torus are equal";
  }
}

TEST_F(AttributePrograms, EveryKindOfExtractHasWhatItsPiecesHave)
{
  const Mesh mesh = WithAttributes(Torus(60, 30), 7);
  this->Write(mesh);
  this->Build({ "--vertices-per-partition", "150" });
  std::vector<AttributeInfo> inLevels = ArraysOfLevels(InfosOf(mesh));
  ASSERT_GE(inLevels.size(), 2U);
  const auto extracted = [this](const std::vector<std::string>& what)
  {
    EXPECT_EQ(this->Extract(what, "out.ply"), "");
    return InfosOf(this->Read("out.ply"));
  };
  EXPECT_EQ(extracted({ "--level", "6" }), inLevels);
  EXPECT_EQ(extracted({ "--partition", "3" }), InfosOf(mesh));
  EXPECT_EQ(extracted({ "--region", "19" }), InfosOf(mesh));
  auto mixed = extracted({ "--region", "19", "--in-context", "6" });
  const auto byName = [](const AttributeInfo& a, const AttributeInfo& b)
  { return a.name < b.name; };
  std::sort(mixed.begin(), mixed.end(), byName);
  std::sort(inLevels.begin(), inLevels.end(), byName);
  EXPECT_EQ(mixed, inLevels);
}

TEST_F(AttributePrograms, InfoListsThemAndExtractSaysWhatAFormatLeavesOut)
{
  Mesh mesh = Torus(60, 30);
  const auto add = [&mesh](const std::string& name, AttributeType type, AttributeAssociation to,
                     std::uint8_t components)
  {
    Attribute attribute{ { name, type, to, components }, {} };
    const bool points = to == AttributeAssociation::Point;
    attribute.values.resize(
      attribute.TupleSize() * (points ? mesh.points.size() : mesh.triangles.size()));
    mesh.attributes.push_back(std::move(attribute));
  };
  add("RGB", AttributeType::UInt8, AttributeAssociation::Point, 3);
  add("Normals", AttributeType::Float32, AttributeAssociation::Point, 3);
  add("TCoords", AttributeType::Float64, AttributeAssociation::Point, 2);
  add("part id", AttributeType::Int64, AttributeAssociation::Cell, 1);
  this->Write(mesh);
  EXPECT_EQ(this->Build({ "--stats", "s.json" }), "");
  const Json expected = {
    { { "name", "RGB" }, { "type", "uint8" }, { "association", "point" }, { "components", 3 } },
    { { "name", "Normals" }, { "type", "float32" }, { "association", "point" },
      { "components", 3 } },
    { { "name", "TCoords" }, { "type", "float64" }, { "association", "point" },
      { "components", 2 } },
    { { "name", "part id" }, { "type", "int64" }, { "association", "cell" }, { "components", 1 } }
  };
  EXPECT_EQ(Json::parse(ReadWhole(this->Folder / "s.json"))["attributes"], expected);
  const Outcome json = RunTool(this->Folder, "store", { "info", "m.kds", "--json" });
  EXPECT_EQ(Json::parse(json.out)["attributes"], expected);
  const Outcome info = RunTool(this->Folder, "store", { "info", "m.kds" });
  EXPECT_NE(info.out.find("attribute            RGB: 3 uint8 a vertex\n"), std::string::npos);
  EXPECT_NE(info.out.find("attribute            part id: 1 int64 a triangle\n"), std::string::npos);

  EXPECT_EQ(this->Extract({ "--all" }, "x.ply"), "");
  EXPECT_EQ(this->Extract({ "--all" }, "x.vtp"), "");
  const std::string warning = "kdstream-store: warning: ";
  const std::string what = ": this format cannot hold these attributes: ";
  EXPECT_EQ(this->Extract({ "--all" }, "x.obj"), warning + "x.obj" + what + "part id\n");
  EXPECT_EQ(this->Extract({ "--all" }, "x.wrl"), warning + "x.wrl" + what + "TCoords, part id\n");
  EXPECT_EQ(this->Extract({ "--all" }, "x.STL"),
    warning + "x.STL" + what + "RGB, Normals, TCoords, part id\n");
}

TEST_F(AttributePrograms, NamesWhatIsNotCarried)
{
  std::ofstream(this->Folder / "in.ply")
    << "ply\nformat ascii 1.0\ncomment TextureFile wall.png\nelement vertex 3\nproperty float x\n"
       "property float y\nproperty float z\nproperty uchar red\nelement face 1\n"
       "property list uchar int vertex_indices\nproperty list uchar float texcoord\nend_header\n"
       "0 0 0 1\n1 0 0 2\n0 1 0 3\n3 0 1 2 2 0 1\n";
  EXPECT_EQ(this->Build({ "--textures", "off" }),
    "kdstream-build: warning: in.ply: not supported by this version and left out: face.texcoord, "
    "texture "
    "'wall.png'\n");
}

TEST_F(AttributePrograms, ALosslessStoreKeepsLargeCoordinates)
{
  const Mesh mesh = GeoReferenced();
  this->Write(mesh);
  EXPECT_EQ(this->Build({ "--precision", "lossless" }), "");
  EXPECT_EQ(this->Extract({ "--all" }, "out.ply"), "");
  const Mesh out = this->Read("out.ply");
  EXPECT_EQ(out.scalarType, ScalarType::Float64);
  EXPECT_TRUE(ContentOf(out) == ContentOf(mesh));
  EXPECT_EQ(this->Extract({ "--level", "11" }, "out.ply"), "");
  EXPECT_EQ(this->Read("out.ply").scalarType, ScalarType::Float64);
}

TEST_F(AttributePrograms, AGridOfLargeCoordinatesIsAsFineAsItsBitsSay)
{
  const Mesh mesh = GeoReferenced();
  this->Write(mesh);
  const Box box = BoxOfPoints(mesh.points);
  double longest = 0;
  for (std::size_t k = 0; k < 3; ++k)
  {
    longest = std::max(longest, box.hi[k] - box.lo[k]);
  }
  for (const unsigned bits : { 20U, 24U })
  {
    EXPECT_EQ(this->Build({ "--precision", std::to_string(bits), "--weld", "off" }), "");
    EXPECT_EQ(this->Extract({ "--all" }, "out.ply"), "");
    const Mesh out = this->Read("out.ply");
    EXPECT_EQ(out.scalarType, ScalarType::Float64);
    ASSERT_EQ(out.points.size(), mesh.points.size());
    // At least millimetres are kept; floats would be wrong by a quarter of a metre there.
    const double step = longest / std::pow(2, bits);
    ASSERT_LT(step, 0.0002);
    // Each point of the input has a place of its own, and is the nearest one to its point in the
    // output.
    std::vector<Vec3> sorted = out.points;
    std::sort(sorted.begin(), sorted.end());
    for (const Vec3& point : mesh.points)
    {
      const Vec3 from{ point[0] - step, -1e9, -1e9 };
      bool found = false;
      for (auto near = std::lower_bound(sorted.begin(), sorted.end(), from);
           near != sorted.end() && (*near)[0] <= point[0] + step && !found; ++near)
      {
        found = std::abs((*near)[0] - point[0]) <= step * 0.5001 &&
                std::abs((*near)[1] - point[1]) <= step * 0.5001 &&
                std::abs((*near)[2] - point[2]) <= step * 0.5001;
      }
      ASSERT_TRUE(found) << point[0] << " " << point[1] << " " << point[2];
    }
    // Levels lie where the model does, within their coarser grid and their geometric error.
    const double off = longest / 1000;
    EXPECT_EQ(this->Extract({ "--level", "9" }, "out.ply"), "");
    for (const Vec3& point : this->Read("out.ply").points)
    {
      for (std::size_t k = 0; k < 3; ++k)
      {
        ASSERT_GE(point[k], box.lo[k] - off);
        ASSERT_LE(point[k], box.hi[k] + off);
      }
    }
  }
}
