// SPDX-License-Identifier: BSD-3-Clause
// A .glb of kdstream-store extract has the orientation of the format, y up and +z in front,
// whatever the model's orientation is. Its coordinates stay those of the store.
#include "Testing/EndToEnd/ProgramsTest.h"
#include "Testing/Fixtures/Meshes.h"
#include "filters/core/VectorMath.h"
#include "filters/model/JsonReader.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>

using namespace kdstream;
using namespace kdstream::fixtures;

namespace
{

using Rows = std::array<Vec3, 3>;
using Floats = std::array<float, 3>;

Vec3 Turned(const Rows& rows, const Vec3& p)
{
  return { Dot(rows[0], p), Dot(rows[1], p), Dot(rows[2], p) };
}

struct GlbFile
{
  Rows rotation{ { { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 } } };
  Vec3 translation{};
  std::set<Floats> points; // as stored in the file
};

class TestExtractedGlb : public ProgramsTest
{
protected:
  void BuildAndExtract(
    const Mesh& mesh, const std::string& up, const std::vector<std::string>& what)
  {
    ASSERT_TRUE(WriteMesh(this->Folder / "in.ply", mesh));
    const Outcome built = this->Build({ "in.ply", "-o", "m.kds", "--quiet", "--precision",
      "lossless", "--vertices-per-partition", "100", "--up=" + up });
    ASSERT_EQ(built.exitCode, 0) << built.err;
    for (const char* output : { "out.glb", "out.ply" })
    {
      std::vector<std::string> arguments{ "extract", "m.kds", "-o", output, "--quiet" };
      arguments.insert(arguments.end(), what.begin(), what.end());
      const Outcome extracted = this->Store(arguments);
      ASSERT_EQ(extracted.exitCode, 0) << extracted.err;
    }
  }

  // Reads a file with one primitive.
  GlbFile ReadGlb(const std::string& name)
  {
    GlbFile read;
    const std::string bytes = ReadWhole(this->Folder / name);
    std::uint32_t size = 0;
    std::memcpy(&size, bytes.data() + 12, sizeof size);
    const auto json = ParseJson(bytes.substr(20, size));
    if (!json)
    {
      ADD_FAILURE() << json.GetError().message;
      return read;
    }
    const auto& node = (*json)["nodes"][0];
    EXPECT_FALSE(FindMember(node, "matrix") && FindMember(node, "translation"));
    if (FindMember(node, "matrix"))
    {
      const auto& matrix = node["matrix"];
      EXPECT_EQ(matrix.Size(), 16U);
      for (unsigned row = 0; row < 3; ++row)
      {
        for (unsigned column = 0; column < 3; ++column)
        {
          read.rotation[row][column] = matrix[4 * column + row].GetDouble();
        }
        read.translation[row] = matrix[12 + row].GetDouble();
        EXPECT_EQ(matrix[4 * row + 3].GetDouble(), 0);
      }
      EXPECT_EQ(matrix[15].GetDouble(), 1);
    }
    else if (FindMember(node, "translation"))
    {
      for (unsigned k = 0; k < 3; ++k)
      {
        read.translation[k] = node["translation"][k].GetDouble();
      }
    }
    const auto& accessor =
      (*json)["accessors"]
             [(*json)["meshes"][0]["primitives"][0]["attributes"]["POSITION"].GetUint()];
    const auto& view = (*json)["bufferViews"][accessor["bufferView"].GetUint()];
    const std::size_t begin = 20 + size + 8 + view["byteOffset"].GetUint();
    for (std::size_t i = 0; i < accessor["count"].GetUint(); ++i)
    {
      Floats point{};
      std::memcpy(point.data(), bytes.data() + begin + i * sizeof point, sizeof point);
      read.points.insert(point);
    }
    return read;
  }

  // Expects that kdstream-convert reads the mesh in the format's axes.
  void ExpectReadsTurned(const Mesh& extracted, const GlbFile& glb, double tolerance)
  {
    const Outcome converted = RunTool(this->Folder, "convert", { "out.glb", "-o", "back.ply" });
    ASSERT_EQ(converted.exitCode, 0) << converted.err;
    const auto sorted = [&](const std::vector<Vec3>& points)
    {
      std::vector<Vec3> all = points;
      std::sort(all.begin(), all.end());
      return all;
    };
    std::vector<Vec3> turned;
    for (const Vec3& point : extracted.points)
    {
      Vec3 place = Turned(glb.rotation, point);
      for (double& value : place)
      {
        value = tolerance > 0 ? value : double(float(value)) + 0.0;
      }
      turned.push_back(place);
    }
    const Mesh back = this->Read("back.ply");
    ASSERT_EQ(back.triangles.size(), extracted.triangles.size());
    if (tolerance == 0)
    {
      EXPECT_EQ(sorted(back.points), sorted(turned));
    }
    ASSERT_EQ(back.points.size(), turned.size());
    for (std::size_t i = 0; i < turned.size(); ++i)
    {
      EXPECT_LE(Length(Minus(this->Nearest(back.points, turned[i]), turned[i])), tolerance);
    }
  }

  static Vec3 Nearest(const std::vector<Vec3>& points, const Vec3& to)
  {
    return *std::min_element(points.begin(), points.end(),
      [&](const Vec3& a, const Vec3& b)
      { return SquaredDistance(a, to) < SquaredDistance(b, to); });
  }
};

const std::vector<std::string> all{ "--all" };

Mesh AsFloats(Mesh mesh)
{
  mesh.scalarType = ScalarType::Float32;
  for (Vec3& point : mesh.points)
  {
    point = { double(float(point[0])), double(float(point[1])), double(float(point[2])) };
  }
  return mesh;
}

}

TEST_F(TestExtractedGlb, StandsOnItsFeetWhateverIsUp)
{
  const Mesh mesh = AsFloats(DisplacedSphere(3));
  const std::map<std::string, std::pair<Vec3, Vec3>> ups{ // the directions that are up and in front
    { "0,1,0", { { 0, 1, 0 }, { 0, 0, 1 } } }, { "0,0,1", { { 0, 0, 1 }, { 0, -1, 0 } } },
    { "0,0,-1", { { 0, 0, -1 }, { 0, -1, 0 } } }, { "1,0,0", { { 1, 0, 0 }, { 0, 0, 1 } } },
    { "-1,0,0", { { -1, 0, 0 }, { 0, 0, 1 } } }, { "0,-1,0", { { 0, -1, 0 }, { 0, 0, 1 } } }
  };
  for (const auto& [up, axes] : ups)
  {
    SCOPED_TRACE(up);
    this->BuildAndExtract(mesh, up, all);
    const GlbFile glb = this->ReadGlb("out.glb");
    EXPECT_EQ(Turned(glb.rotation, axes.first), (Vec3{ 0, 1, 0 }));
    EXPECT_EQ(Turned(glb.rotation, axes.second), (Vec3{ 0, 0, 1 }));
    EXPECT_EQ(Turned(glb.rotation, Cross(axes.first, axes.second)), (Vec3{ 1, 0, 0 }));
    EXPECT_EQ(glb.translation, Vec3{});
    const Mesh extracted = this->Read("out.ply");
    std::set<Floats> points;
    for (const Vec3& p : extracted.points)
    {
      points.insert({ float(p[0]), float(p[1]), float(p[2]) });
    }
    EXPECT_EQ(glb.points, points) << "bit for bit as they are";
    this->ExpectReadsTurned(extracted, glb, 0);
  }
}

// glTF is in metres: the node scales the model, and the coordinates stay.
TEST_F(TestExtractedGlb, AKnownUnitBecomesMetres)
{
  const Mesh mesh = AsFloats(DisplacedSphere(4));
  for (const std::string up : { "0,1,0", "0,0,1" })
  {
    SCOPED_TRACE(up);
    this->BuildAndExtract(mesh, up, { "--all" });
    const GlbFile plain = this->ReadGlb("out.glb");
    ASSERT_EQ(this->Store({ "edit", "m.kds", "--unit", "mm", "--quiet" }).exitCode, 0);
    ASSERT_EQ(this->Store({ "extract", "m.kds", "--all", "-o", "out.glb", "--quiet" }).exitCode, 0);
    EXPECT_EQ(this->ReadGlb("out.glb").points, plain.points);
    for (const std::string file : { "out.glb", "small.glb" })
    {
      ASSERT_EQ(this
                  ->Store({ "export", "m.kds", "small.glb", "--format", "glb", "--compression",
                    "none", "--quiet" })
                  .exitCode,
        0);
      ASSERT_EQ(RunTool(this->Folder, "convert", { file, "-o", "back.ply" }).exitCode, 0);
      Box box, metres;
      for (const Vec3& point : mesh.points)
      {
        box.Add(point);
      }
      for (const Vec3& point : this->Read("back.ply").points)
      {
        metres.Add(point);
      }
      EXPECT_NEAR(Length(Minus(metres.hi, metres.lo)), Length(Minus(box.hi, box.lo)) / 1000, 1e-6)
        << file;
    }
  }
}

TEST_F(TestExtractedGlb, LevelsAndRegionsStandSoToo)
{
  const Mesh mesh = AsFloats(DisplacedSphere(4));
  for (const std::vector<std::string>& what : { std::vector<std::string>{ "--level", "5" },
         { "--partition", "1" }, { "--region", "9", "--rings", "0" } })
  {
    SCOPED_TRACE(what[0]);
    this->BuildAndExtract(mesh, "0,0,1", what);
    const GlbFile glb = this->ReadGlb("out.glb");
    EXPECT_EQ(glb.rotation, (Rows{ { { 1, 0, 0 }, { 0, 0, 1 }, { 0, -1, 0 } } }));
    this->ExpectReadsTurned(this->Read("out.ply"), glb, 0);
  }
}

TEST_F(TestExtractedGlb, DirectionsBetweenTheAxesTurnDoublesAboutTheirMiddle)
{
  Mesh mesh = DisplacedSphere(3);
  mesh.scalarType = ScalarType::Float64;
  for (Vec3& point : mesh.points)
  {
    point = Plus(point, Vec3{ 1000, -2000, 500 });
  }
  for (const char* const up : { "1,2,3", "-1,-1,0.5", "0.001,-1,0", "0,1,1e-9" })
  {
    SCOPED_TRACE(up);
    this->BuildAndExtract(mesh, up, all);
    const GlbFile glb = this->ReadGlb("out.glb");
    const auto info = ParseJson(this->Store({ "info", "m.kds", "--json" }).out);
    ASSERT_TRUE(info);
    const auto& reported = (*info)["pose"]["up"];
    const Vec3 turned = Turned(
      glb.rotation, { reported[0].GetDouble(), reported[1].GetDouble(), reported[2].GetDouble() });
    EXPECT_LE(Length(Minus(turned, Vec3{ 0, 1, 0 })), 1e-14);
    for (std::size_t k = 0; k < 3; ++k)
    {
      EXPECT_NEAR(Length(glb.rotation[k]), 1, 1e-14);
    }
    EXPECT_LE(Length(Minus(Cross(glb.rotation[0], glb.rotation[1]), glb.rotation[2])), 1e-14);
    this->ExpectReadsTurned(this->Read("out.ply"), glb, 0.002); // floats near 2000 are this coarse
  }
}

// Another build of the file knows that y is up, because the format says so.
TEST_F(TestExtractedGlb, ABuildOfItKnowsWhatIsUp)
{
  this->BuildAndExtract(AsFloats(Torus(40, 20)), "0,0,1", all);
  const Outcome built = this->Build({ "out.glb", "-o", "again.kds", "--quiet" });
  ASSERT_EQ(built.exitCode, 0) << built.err;
  const auto info = ParseJson(this->Store({ "info", "again.kds", "--json" }).out);
  ASSERT_TRUE(info);
  EXPECT_EQ((*info)["pose"]["up"][1].GetDouble(), 1);
  EXPECT_EQ((*info)["pose"]["view"][2].GetDouble(), 1);
  EXPECT_TRUE((*info)["pose"]["guessed"].GetBool());
}
