// SPDX-License-Identifier: BSD-3-Clause
// The tolerance of the programs. Data that is dropped or repaired is reported, counted in the
// statistics, and refused by --strict; in memory, out of core and by kdstream-convert alike. Also
// texts as other programs write them.
#include "Testing/EndToEnd/ConvertTools.h"
#include "Testing/Fixtures/Meshes.h"

#include <nlohmann/json.hpp>

#include <vtkXMLPolyDataWriter.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>

using namespace kdstream;
using namespace kdstream::fixtures;

namespace
{

class TestTolerance : public ConvertTest
{
protected:
  nlohmann::json Stats() const
  {
    std::ifstream file(this->Folder / "stats.json");
    return nlohmann::json::parse(file);
  }

  // Builds the input, and returns the build's warnings without the names of the program and the
  // input. `forgiven`: all counts in the statistics that must not be 0, by name.
  std::vector<std::string> Built(const std::string& input, const nlohmann::json& forgiven,
    const std::vector<std::string>& more = {})
  {
    std::vector<std::string> all{ input, "-o", "m.kds", "--quiet", "--stats", "stats.json" };
    all.insert(all.end(), more.begin(), more.end());
    const Outcome built = this->Build(all);
    EXPECT_EQ(built.exitCode, 0) << built.err;
    nlohmann::json counted = nlohmann::json::object();
    if (built.exitCode == 0)
    {
      const nlohmann::json stats = this->Stats();
      for (const auto& [key, number] : stats["forgiven"].items())
      {
        if (number != 0)
        {
          counted[key] = number;
        }
      }
    }
    EXPECT_EQ(counted, forgiven);
    std::vector<std::string> warnings;
    std::istringstream lines(built.err);
    const std::string begin = "kdstream-build: warning: " + input + ": ";
    for (std::string line; std::getline(lines, line);)
    {
      EXPECT_EQ(line.rfind(begin, 0), 0U) << line;
      warnings.push_back(line.substr(std::min(begin.size(), line.size())));
    }
    // With --strict, inputs with such counts are refused; inputs that only cause reports are
    // allowed.
    all.push_back("--strict");
    const Outcome strict = this->Build(all);
    EXPECT_EQ(strict.exitCode, forgiven.empty() ? 0 : 1) << strict.err;
    if (!forgiven.empty())
    {
      EXPECT_EQ(strict.err.rfind("kdstream-build: error: " + input + ": ", 0), 0U) << strict.err;
      EXPECT_NE(strict.err.find(", which --strict does not allow"), std::string::npos)
        << strict.err;
    }
    return warnings;
  }

  Mesh Extracted()
  {
    EXPECT_EQ(
      RunTool(this->Folder, "store", { "extract", "m.kds", "--all", "-o", "back.ply" }).exitCode,
      0);
    return this->Read("back.ply");
  }
};

using Warnings = std::vector<std::string>;

const std::string cube =
  "v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\n"
  "v -1 1 1\nf 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\n"
  "f 4 1 5 8\n";

// A torus as PLY with arrays of vertices and faces; some vertices are not finite.
std::string Spoiled(const Mesh& mesh, std::size_t every)
{
  std::ostringstream text;
  text << "ply\nformat ascii 1.0\nelement vertex " << mesh.points.size()
       << "\nproperty float x\nproperty float y\nproperty float z\nproperty float mark\n"
          "element face "
       << mesh.triangles.size() + 2
       << "\nproperty list uchar int vertex_indices\nproperty int number\nend_header\n";
  for (std::size_t i = 0; i < mesh.points.size(); ++i)
  {
    const Vec3& p = mesh.points[i];
    text << float(p[0]) << ' ';
    if (i % every == every / 2)
    {
      text << "nan ";
    }
    else
    {
      text << float(p[1]) << ' ';
    }
    text << float(p[2]) << ' ' << float(p[0]) << '\n';
  }
  text << "2 0 1 -1\n";
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
  {
    const Triangle& t = mesh.triangles[i];
    text << "3 " << t[0] << ' ' << t[1] << ' ' << t[2] << ' ' << i << '\n';
  }
  text << "1 0 -1\n";
  return text.str();
}

}

TEST_F(TestTolerance, PointsThatAreNotFiniteGoWithTheirFaces)
{
  const Mesh mesh = Torus(80, 60);
  constexpr std::size_t every = 400;
  this->WriteText("nan.ply", Spoiled(mesh, every));
  std::size_t faces = 0;
  for (const Triangle& t : mesh.triangles)
  {
    faces +=
      std::any_of(t.begin(), t.end(), [](VertexId v) { return v % every == every / 2; }) ? 1 : 0;
  }
  const std::size_t points = (mesh.points.size() + every / 2 - 1) / every;
  const nlohmann::json forgiven{ { "points_not_finite", points },
    { "faces_of_dropped_points", faces }, { "faces_too_small", 2 } };
  const Warnings warnings = this->Built("nan.ply", forgiven, { "--precision", "lossless" });
  ASSERT_EQ(warnings.size(), 3U);
  EXPECT_EQ(warnings[0].rfind(std::to_string(points) + " points ", 0), 0U) << warnings[0];
  EXPECT_NE(warnings[0].find(": vertex 200, "), std::string::npos) << "the first";
  const Mesh back = this->Extracted();
  EXPECT_EQ(back.points.size(), mesh.points.size() - points);
  EXPECT_EQ(back.triangles.size(), mesh.triangles.size() - faces);
  const Attribute* const mark = Find(back, "mark");
  ASSERT_TRUE(mark);
  for (std::size_t i = 0; i < back.points.size(); ++i)
  {
    ASSERT_EQ(mark->Get(i, 0), back.points[i][0]);
  }
  const Attribute* const number = Find(back, "number");
  ASSERT_TRUE(number);
  for (std::size_t i = 0; i < back.triangles.size(); ++i)
  {
    const Triangle& was = mesh.triangles[std::size_t(number->Get(i, 0))];
    Vec3 sum{}, expected{};
    for (std::size_t k = 0; k < 3; ++k)
    {
      sum[0] += back.points[back.triangles[i][k]][0];
      expected[0] += double(float(mesh.points[was[k]][0]));
    }
    ASSERT_NEAR(sum[0], expected[0], 1e-3) << i; // the text has only six digits
  }
  // The build out of core makes the same store, and its last line reports the same.
  const std::string inMemory = ReadWhole(this->Folder / "m.kds");
  const Outcome external =
    this->Build({ "nan.ply", "-o", "m.kds", "--precision", "lossless", "--memory", "64M" });
  EXPECT_EQ(external.exitCode, 0) << external.err;
  EXPECT_NE(external.err.find(": " + std::to_string(points) + " points dropped, " +
                              std::to_string(faces) + " faces of them dropped, 2 faces too small"),
    std::string::npos)
    << external.err;
  EXPECT_TRUE(ReadWhole(this->Folder / "m.kds") == inMemory);
}

TEST_F(TestTolerance, ObjFacesLoseWhatDoesNotExist)
{
  this->WriteText("two.obj", cube + "f 1 2\n");
  EXPECT_EQ(this->Built("two.obj", { { "faces_too_small", 1 } }),
    (Warnings{ "1 face has fewer than three corners and is dropped: face 6 (line 15)" }));
  EXPECT_EQ(this->Extracted().triangles.size(), 12U);
  this->WriteText("zero.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nvt 0 0\nvn 0 0 1\n"
                              "f 1/0/1 2/0/1 3/0/1\nf 2/1/1 4/1/1 3/1/1\n");
  EXPECT_EQ(this->Built("zero.obj", { { "faces_without_attribute", 1 } }).size(), 1U);
  const Mesh back = this->Extracted();
  EXPECT_EQ(back.triangles.size(), 2U);
  EXPECT_EQ(ValuesOf(back, "Normals")[2], 1);
  this->WriteText("no.obj", cube + "f 1 2 9\n");
  EXPECT_EQ(this->Build({ "no.obj", "-o", "m.kds" }).exitCode, 1) << "places that do not exist";
}

TEST_F(TestTolerance, OneRuleForTexturedMeshes)
{
  std::ofstream(this->Folder / "m.mtl") << "newmtl red\nKd 1 0 0\nnewmtl blue\nKd 0 0 1\n";
  this->WriteText("m.obj",
    "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 5 0 0\nv 6 0 0\nv 5 1 0\nv nan 0 0\nvt 0 0\n"
    "usemtl red\nf 1 7 2 3\nf 1 2\nf 1/9 2/1 3/1\nusemtl blue\nf 4 5 6\nf 7 5 6\n");
  this->Built("m.obj", { { "points_not_finite", 1 }, { "faces_of_dropped_points", 2 },
                         { "faces_too_small", 1 }, { "faces_without_attribute", 1 } });
  const Mesh back = this->Extracted();
  EXPECT_EQ(back.triangles.size(), 2U);
  ASSERT_EQ(back.points.size(), 6U);
  const std::vector<double> colors = ValuesOf(back, "RGB");
  for (std::size_t i = 0; i < 6; ++i)
  {
    EXPECT_EQ(colors[3 * i], back.points[i][0] < 3 ? 255 : 0);
    EXPECT_EQ(colors[3 * i + 2], back.points[i][0] < 3 ? 0 : 255);
  }
}

TEST_F(TestTolerance, ConvertReportsTheSame)
{
  this->WriteText("nan.ply", Spoiled(Torus(20, 10), 50));
  const Outcome reported = this->Convert("nan.ply");
  EXPECT_EQ(reported.exitCode, 0);
  EXPECT_NE(
    reported.err.find("warning: nan.ply: 4 points are not finite and are dropped; the first: "
                      "vertex 25, whose y is nan\n"),
    std::string::npos)
    << reported.err;
  const Outcome strict = this->Convert("nan.ply", { "--strict" });
  EXPECT_EQ(strict.exitCode, 1);
  EXPECT_EQ(std::count(strict.err.begin(), strict.err.end(), '\n'), 1) << strict.err;
}

TEST_F(TestTolerance, TextsBeginAndEndAsEditorsDo)
{
  const auto box = [this](const std::string& name, const std::string& text)
  {
    this->WriteText(name, text);
    EXPECT_EQ(this->Built(name, nlohmann::json::object()), Warnings{});
    const Mesh back = this->Extracted();
    EXPECT_EQ(back.points.size(), 8U);
    EXPECT_EQ(back.triangles.size(), 12U);
  };
  std::string returns = cube;
  std::replace(returns.begin(), returns.end(), '\n', '\r');
  box("bom.obj", "\xEF\xBB\xBF" + cube);
  box("cr.obj", returns);
  box("z.obj", cube + "\x1A");
  this->WriteText("wide.obj", std::string("\xFF\xFEv\0 \0", 6));
  const Outcome wide = this->Build({ "wide.obj", "-o", "m.kds" });
  EXPECT_EQ(wide.exitCode, 1);
  EXPECT_NE(wide.err.find("is text in UTF-16"), std::string::npos) << wide.err;
  this->WriteText("zeros.obj", cube + std::string(40, '\0'));
  EXPECT_EQ(this->Built("zeros.obj", { { "padding_bytes", 40 } }),
    (Warnings{ "40 zeros after the end are padding" }));
}

TEST_F(TestTolerance, MaterialsAreFoundByTheirNames)
{
  struct Case
  {
    std::string library, red, blue;
  };
  const Case cases[] = { { "newmtl paint#1\nKd 1 0 0\nnewmtl paint#2\nKd 0 0 1\n", "paint#1",
                           "paint#2" },
    { "newmtl paint #1\nKd 1 0 0\nnewmtl paint #2\nKd 0 0 1\n", "paint #1", "paint #2" },
    { "\xEF\xBB\xBFnewmtl red\nKd 1 0 0\nnewmtl blue\nKd 0 0 1\n", "red", "blue" },
    { "newmtl \"my red\"\nKd 1 0 0\nnewmtl blue # cold\nKd 0 0 1\n", "my red", "blue" },
    { "newmtl Red\nKd 1 0 0 # warm\nnewmtl a\\b\nKd 0 0 1\n", "RED # it is", "A/B" } };
  for (const Case& c : cases)
  {
    SCOPED_TRACE(c.red);
    this->WriteText("My Lib.MTL", c.library);
    for (const std::string library : { "My Lib.MTL", "my lib.mtl", "\"My Lib.MTL\"",
           "C:\\scans\\My Lib.MTL", "My Lib.MTL # mine" })
    {
      this->WriteText("m.obj", "mtllib " + library +
                                 "\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 5 0 0\nv 6 0 0\nv 5 1 0\nusemtl " +
                                 c.red + "\nf 1 2 3\nusemtl " + c.blue + "\nf 4 5 6\n");
      EXPECT_EQ(this->Built("m.obj", nlohmann::json::object()), Warnings{}) << library;
      const Mesh back = this->Extracted();
      ASSERT_EQ(back.points.size(), 6U);
      const std::vector<double> colors = ValuesOf(back, "RGB");
      ASSERT_EQ(colors.size(), 18U);
      for (std::size_t i = 0; i < 6; ++i)
      {
        EXPECT_EQ(colors[3 * i], back.points[i][0] < 3 ? 255 : 0);
        EXPECT_EQ(colors[3 * i + 2], back.points[i][0] < 3 ? 0 : 255);
      }
    }
  }
}

TEST_F(TestTolerance, DecimalCommas)
{
  const auto read = [this](const std::string& text)
  {
    this->WriteText("in.xyz", text);
    const Outcome outcome = this->Convert("in.xyz");
    EXPECT_EQ(outcome.exitCode, 0) << outcome.err;
    EXPECT_NE(
      outcome.err.find(": commas are taken as decimal commas, as in 1,5\n"), std::string::npos)
      << outcome.err;
    return this->Read("out.ply");
  };
  const std::vector<Vec3> points{ { -3.25, 0.75, 1 }, { 1.5, 3, 1.125 } };
  for (const std::string text : { "-3,25 0,75 1,00\n1,5 3 1,125\n", "-3,25;0,75;1\n1,5;3;1,125\n",
         "-3,25\t0,75\t1,00\r\n1,5\t3\t1,125\r\n", "-3,25, 0,75, 1,00\n1,5, 3,0, 1,125\n",
         "2\n-3,25 0,75 1 # c\n1,5 3 1,125\n" })
  {
    SCOPED_TRACE(text);
    EXPECT_EQ(read(text).points, points);
  }
  EXPECT_EQ(read("0 0 0\n-3,25 0,75 1,5\n").points.size(), 2U) << "after a line without commas";
  const Mesh colored = read("1,5 2,5 3,5 255 0 7\n1,5 2,5 3 255 0 7\n");
  EXPECT_EQ(ValuesOf(colored, "RGB"), (std::vector<double>{ 255, 0, 7, 255, 0, 7 }));
  // Here commas separate columns.
  const auto separated = [this](const std::string& text)
  {
    this->WriteText("in.xyz", text);
    return this->Converted("in.xyz").points;
  };
  EXPECT_EQ(separated("1.5,2,3\n4,5,6\n"), (std::vector<Vec3>{ { 1.5, 2, 3 }, { 4, 5, 6 } }));
  EXPECT_EQ(separated("1.5, 2, 3\n"), (std::vector<Vec3>{ { 1.5, 2, 3 } }));
  EXPECT_EQ(separated("1,2,3 255,0,0\n").size(), 1U);
  // Texts that can be read in two ways.
  for (const std::string text : { "1,234.5 2,345.5 3,456.5\n", "1,5 2.5 3\n",
         "1,5 2,5 3,5\n1.5 2,5 3,5\n", "1,5 2,5 3,5\n1.5 2 3\n", "1.5 2 3\n1,5 2,5 3,5\n" })
  {
    this->WriteText("in.xyz", text);
    this->ExpectError("in.xyz", "can be read in two ways");
  }
  this->WriteText("in.xyz", "1,2,3,4,5,6\n");
  EXPECT_NE(
    this->Convert("in.xyz").err.find("as decimal commas they would leave 3"), std::string::npos);
}

TEST_F(TestTolerance, ColumnsOfAnXyzByTheirValues)
{
  struct Case
  {
    std::vector<std::string> columns; // the columns after x y z, in each line
    std::string names;                // in the report; empty: nothing must be reported
    std::vector<double> rgb;          // colour of the first point
    std::string number;               // name of an array; `value` is its first value
    double value = 0;
  };
  const Case cases[] = {
    // A class after colours. In front of colours it could be an intensity.
    { { "255 0 0 3", "255 0 0 1" }, "x y z r g b column7", { 255, 0, 0 }, "column7", 3 },
    { { "200 90 80 2", "100 40 50 31" }, "x y z r g b column7", { 200, 90, 80 }, "column7", 2 },
    { { "17 200 90 80", "3 100 40 50" }, "x y z intensity r g b", { 200, 90, 80 }, "Intensity",
      17 },
    // The three colours vary together; the fourth number does not.
    { { "10 20 30 200", "100 110 120 90", "200 210 220 150", "50 60 70 60" }, "x y z r g b column7",
      { 10, 20, 30 }, "column7", 200 },
    { { "200 10 20 30", "90 100 110 120", "150 200 210 220", "60 50 60 70" },
      "x y z intensity r g b", { 10, 20, 30 }, "Intensity", 200 },
    // Only one layout is possible.
    { { "0.5 200 90 80", "0.25 1 2 3" }, "", { 200, 90, 80 }, "Intensity", 0.5 },
    { { "200 90 80 -0.5", "1 2 3 7" }, "", { 200, 90, 80 }, "column7", -0.5 },
    { { "0.6 0 -0.8 200 90 80", "0 0 -1 1 2 3" }, "", { 200, 90, 80 }, "", 0 },
    { { "200 90 80 12.5 0.6 0 -0.8", "1 2 3 -2 0 0 -1" }, "", { 200, 90, 80 }, "column7", 12.5 },
    // Colours from 0 to 1.
    { { "1 0.2 0", "0.5 0.5 0.5" }, "from 0 to 1", { 255, 51, 0 }, "", 0 },
  };
  for (const Case& c : cases)
  {
    SCOPED_TRACE(c.columns[0]);
    std::string text;
    for (std::size_t i = 0; i < c.columns.size(); ++i)
    {
      text += std::to_string(i) + " 0.5 2 " + c.columns[i] + "\n";
    }
    this->WriteText("in.xyz", text);
    const Outcome outcome = this->Convert("in.xyz");
    ASSERT_EQ(outcome.exitCode, 0) << outcome.err;
    EXPECT_NE(outcome.err.find(c.names), std::string::npos) << outcome.err;
    EXPECT_EQ(outcome.err.find("could be") == std::string::npos,
      c.names.empty() || c.names == "from 0 to 1")
      << outcome.err;
    const Mesh mesh = this->Read("out.ply");
    const std::vector<double> rgb = ValuesOf(mesh, "RGB");
    ASSERT_GE(rgb.size(), 3U);
    EXPECT_EQ(std::vector<double>(rgb.begin(), rgb.begin() + 3), c.rgb);
    if (!c.number.empty())
    {
      const std::vector<double> values = ValuesOf(mesh, c.number);
      ASSERT_FALSE(values.empty());
      EXPECT_EQ(values[0], c.value);
    }
  }
}

TEST_F(TestTolerance, ColumnsOfAnXyzByTheirNames)
{
  this->WriteText("in.xyz", "7 1 2 3 255 0 9 4\n8 1 2 4 254 1 8 5\n");
  const auto named = [this](const std::string& names)
  {
    const Outcome outcome = this->Convert("in.xyz", { "--columns", names });
    EXPECT_EQ(outcome.exitCode, 0) << outcome.err;
    EXPECT_EQ(outcome.err, "");
    return this->Read("out.ply");
  };
  const Mesh mesh = named("time x y z r g b class");
  EXPECT_EQ(mesh.points[1], (Vec3{ 1, 2, 4 }));
  EXPECT_EQ(ValuesOf(mesh, "RGB"), (std::vector<double>{ 255, 0, 9, 254, 1, 8 }));
  EXPECT_EQ(ValuesOf(mesh, "time"), (std::vector<double>{ 7, 8 }));
  EXPECT_EQ(ValuesOf(mesh, "classification"), (std::vector<double>{ 4, 5 }));
  const Mesh turned = named("z,Y,X,-,-,-,-,I");
  EXPECT_EQ(turned.points[0], (Vec3{ 2, 1, 7 }));
  EXPECT_EQ(turned.attributes.size(), 1U);
  EXPECT_EQ(ValuesOf(turned, "Intensity"), (std::vector<double>{ 4, 5 }));
  this->WriteText("words.csv", "name,x,y,z,class\nA1,1,2,3,ground\nA2,4,5,6,tree\n");
  const Outcome ofWords = this->Convert("words.csv");
  EXPECT_EQ(ofWords.exitCode, 0);
  EXPECT_NE(ofWords.err.find("words.csv: left out: columns of text: 'name', 'classification'\n"),
    std::string::npos)
    << ofWords.err;
  EXPECT_EQ(this->Read("out.ply").points, (std::vector<Vec3>{ { 1, 2, 3 }, { 4, 5, 6 } }));
  // Other columns keep their names, even if the names of the coordinates are unknown.
  this->WriteText("units.csv", "X_m,Y_m,Z_m,T_degC\n1.5,2.5,3.5,21\n4.5,5.5,6.5,22\n");
  this->WriteText("odd.csv", "Alpha,Beta,Gamma,T_degC\n1.5,2.5,3.5,21\n4.5,5.5,6.5,22\n");
  for (const char* file : { "units.csv", "odd.csv" })
  {
    EXPECT_EQ(this->Convert(file).exitCode, 0);
    EXPECT_EQ(ValuesOf(this->Read("out.ply"), "T_degC"), (std::vector<double>{ 21, 22 })) << file;
  }
  this->WriteText("later.csv", "x,y,z,height\n1,2,3,4\n4,5,6,tree\n");
  this->ExpectError("later.csv", "line 3: 'tree' (column 4) is not a number");
  this->WriteText("bare.csv", "A1,1,2,3,ground\nA2,4,5,6,tree\n");
  this->ExpectError("bare.csv",
    "line 1: 'A1' (column 1) is not a number; --columns \"- x y z -\" leaves out what is called -");
  const Outcome words = this->Convert("words.csv", { "--columns", "- x y z -" });
  EXPECT_EQ(words.exitCode, 0) << words.err;
  EXPECT_EQ(this->Read("out.ply").points, (std::vector<Vec3>{ { 1, 2, 3 }, { 4, 5, 6 } }));
  // The option also works in a build; and a line of the file may name the columns, too.
  EXPECT_EQ(
    this->Build({ "in.xyz", "-o", "m.kds", "--quiet", "--columns", "- x y z r g b -" }).err, "");
  EXPECT_EQ(ValuesOf(this->Extracted(), "RGB").size(), 6U);
  for (const std::string header :
    { "//X Y Z R G B Class\n", "# x y z r g b class\n1\n", "X,Y,Z,R,G,B,Classification\n" })
  {
    this->WriteText("head.xyz", header + "1 2 3 20 30 40 50\n");
    EXPECT_EQ(ValuesOf(this->Converted("head.xyz"), "classification"), (std::vector{ 50.0 }))
      << header;
  }
  this->WriteText("remark.xyz", "# x y z of my house\n1 2 3\n");
  EXPECT_EQ(this->Converted("remark.xyz").points.size(), 1U);
  // Lists of names that are not allowed.
  for (const auto& [names, error] : { std::pair{ "x y", "x, y and z are needed" },
         { "x y z r g 4 5 6", "of r g b all three are needed" },
         { "x y z a a 5 6 7", "'a' is named twice" }, { "x y z", "--columns names 3" } })
  {
    const Outcome outcome = this->Convert("in.xyz", { "--columns", names });
    EXPECT_EQ(outcome.exitCode == 0, false);
    EXPECT_NE(outcome.err.find(error), std::string::npos) << outcome.err;
  }
  this->WriteText("m.obj", cube);
  EXPECT_EQ(this->Build({ "m.obj", "-o", "m.kds", "--columns", "x y z" }).exitCode, 2);
  EXPECT_EQ(this->Convert("m.obj", { "--columns", "x y z" }).exitCode, 2);
}

TEST_F(TestTolerance, TheFirstColumnOfPointsMayBeANumberOrATime)
{
  const auto lines = [](auto first, const std::string& after)
  {
    std::ostringstream text;
    text.precision(15);
    for (int i = 0; i < 30; ++i)
    {
      text << first(i) << ' ' << 500013.436 + (i * 7) % 11 << ' ' << 5400084.743 + (i * 5) % 13
           << ' ' << 4000207.638 + (i * 3) % 7 << after << '\n';
    }
    return text.str();
  };
  const auto counter = [](int i) { return 17. + i; };
  const auto time = [](int i) { return 1.6e9 + i / 2 * 0.25; };
  const auto shuffled = [](int i) { return 90. + (7 * i + 3) % 30; };
  for (const auto& [text, names] :
    { std::pair{ lines(counter, ""), "number x y z" },
      { lines(counter, " 0.5"), "number x y z intensity" },
      { lines(counter, " 12.5 300 -7"), "number x y z column5 column6 column7" },
      { lines(counter, " 0 128 9"), "number x y z r g b" },
      { lines(counter, " 0 128 9 0.5"), "number x y z r g b column8" },
      { lines(shuffled, " 0.5"), "number x y z intensity" },
      { lines(shuffled, " 0 128 9"), "number x y z r g b" }, { lines(time, ""), "number x y z" } })
  {
    SCOPED_TRACE(names);
    this->WriteText("in.xyz", text);
    const Warnings warnings =
      this->Built("in.xyz", { { "columns_guessed", 1 } }, { "--precision", "lossless" });
    ASSERT_FALSE(warnings.empty());
    EXPECT_NE(warnings[0].find("are read as \"" + std::string(names) + "\""), std::string::npos)
      << warnings[0];
    EXPECT_NE(warnings[0].find("--columns"), std::string::npos);
    std::string all;
    for (const std::string& warning : warnings)
    {
      all += "kdstream-convert: warning: in.xyz: " + warning + "\n";
    }
    const Mesh read = this->Converted("in.xyz", all);
    ASSERT_EQ(read.points.size(), 30U);
    EXPECT_EQ(read.points[1], (Vec3{ 500020.436, 5400089.743, 4000210.638 }));
    EXPECT_EQ(ValuesOf(read, "number")[29], text.starts_with("17 ")   ? 46
                                            : text.starts_with("93 ") ? 116
                                                                      : 1.6e9 + 3.5);
  }
  this->WriteText("in.xyz", "9 1.5 2 3\n8 2.5 3 3\n7 3.5 2 3\n");
  EXPECT_EQ(ValuesOf(this->Read(this->Convert("in.xyz").exitCode == 0 ? "out.ply" : ""), "number"),
    (std::vector<double>{ 9, 8, 7 }));
  this->WriteText("in.xyz", "101 1.5 2 3\n105 2.5 3 3\n106 3.5 2 3\n");
  EXPECT_NE(this->Convert("in.xyz").err.find("\"number x y z\" too"), std::string::npos);
  // Numbers of points after thinning, in no order, are recognized; but not in front of integer
  // coordinates.
  this->WriteText("in.xyz", lines([](int i) { return 5 * ((7 * i) % 31); }, ""));
  EXPECT_NE(this->Built("in.xyz", { { "columns_guessed", 1 } })[0].find("has no number twice"),
    std::string::npos);
  // A path along x, there and back, is not ordered in this way.
  this->WriteText("in.xyz", lines([](int i) { return i < 15 ? 2 * i : 59 - 2 * i; }, ""));
  {
    const Outcome way = this->Convert("in.xyz");
    EXPECT_EQ(way.exitCode, 0) << way.err;
    EXPECT_EQ(this->Read("out.ply").points[1][0], 2);
  }
  this->WriteText("in.xyz", "5 1 2 9\n7 2 2 8\n6 3 2 9\n");
  EXPECT_EQ(this->Built("in.xyz", nlohmann::json::object()), Warnings{});
  // A point cloud that is ordered along x.
  this->WriteText("in.xyz", lines([](int i) { return i * i; }, ""));
  EXPECT_NE(this->Built("in.xyz", { { "columns_guessed", 1 } })[0].find("they could be"),
    std::string::npos);
  EXPECT_EQ(this->Convert("in.xyz", { "--strict", "--columns", "x y z i" }).err, "");
  // Names decide. In a raster x grows slowly, as a class might do. Colours show that the columns in
  // front of them are x y z.
  this->WriteText("in.xyz", lines([](int i) { return i; }, "").insert(0, "x y z i\n"));
  EXPECT_EQ(this->Built("in.xyz", nlohmann::json::object()), Warnings{});
  this->WriteText("in.xyz", lines([](int i) { return i / 10; }, ""));
  EXPECT_NE(this->Built("in.xyz", { { "columns_guessed", 1 } })[0].find("could be a class"),
    std::string::npos);
  this->WriteText("in.xyz", "1 2 3 9 8 7\n2 5 4 9 8 7\n3 6 9 1 2 3\n");
  EXPECT_EQ(ValuesOf(this->Converted("in.xyz"), "RGB").size(), 9U);
}

TEST_F(TestTolerance, SurveyorsNamesOfColumns)
{
  this->WriteText("in.csv",
    "Point,Northing,Easting,Elevation (m)\n7,5400084.743,500013.436,207.5\n9,1.5,2.5,3.5\n");
  const Mesh read = this->Converted("in.csv");
  EXPECT_EQ(
    read.points, (std::vector<Vec3>{ { 500013.436, 5400084.743, 207.5 }, { 2.5, 1.5, 3.5 } }));
  EXPECT_EQ(ValuesOf(read, "Point"), (std::vector<double>{ 7, 9 }));
}

TEST_F(TestTolerance, CountsOfPointsAsText)
{
  const std::string points = "10 20 30\n11 20 30\n10 22 30\n";
  for (const std::string& text :
    { "4\n" + points, "3\n" + points + "2\n1 2 3\n", "5\n" + points + "3\n" + points })
  {
    this->WriteText("in.pts", text);
    this->ExpectError("in.pts", "truncated: line ");
  }
  this->WriteText("in.pts", "3\n" + points + "1\n1 2 3\n");
  EXPECT_EQ(this->Converted("in.pts").points.size(), 4U);
  this->WriteText("in.pts", "2\n" + points + "1\n" + points);
  EXPECT_EQ(this->Built("in.pts", { { "not_counted", 3 } }),
    Warnings{
      "3 points or faces are in the file but its header does not count them; the first: line 1 "
      "counts 2 points" });
}

TEST_F(TestTolerance, CountsOfVtpThatFallShort)
{
  const auto vtp = [](const std::string& points, const std::string& polys)
  {
    return "<VTKFile type=\"PolyData\" version=\"0.1\" "
           "byte_order=\"LittleEndian\"><PolyData><Piece "
           "NumberOfPoints=\"" +
           points +
           "\" NumberOfVerts=\"0\" NumberOfLines=\"0\" NumberOfStrips=\"0\" NumberOfPolys=\"" +
           polys +
           "\"><Points><DataArray type=\"Float32\" NumberOfComponents=\"3\" format=\"ascii\">0 0 0 "
           "1 "
           "0 0 0 1 0 1 1 0 9 9 9</DataArray></Points><Polys><DataArray type=\"Int32\" "
           "Name=\"connectivity\" format=\"ascii\">0 1 2 1 3 2</DataArray><DataArray "
           "type=\"Int32\" "
           "Name=\"offsets\" format=\"ascii\">3 "
           "6</DataArray></Polys></Piece></PolyData></VTKFile>\n";
  };
  this->WriteText("in.vtp", vtp("5", "2"));
  EXPECT_EQ(this->Converted("in.vtp").triangles.size(), 2U);
  for (const auto& [points, polys, name] :
    { std::tuple{ "5", "1", "NumberOfPolys is 1" }, { "4", "2", "NumberOfPoints is 4" } })
  {
    this->WriteText("in.vtp", vtp(points, polys));
    const Warnings warnings = this->Built("in.vtp", { { "not_counted", 1 } });
    ASSERT_FALSE(warnings.empty());
    EXPECT_NE(warnings[0].find(name), std::string::npos) << warnings[0];
  }
  for (const int mode : { vtkXMLWriter::Ascii, vtkXMLWriter::Binary, vtkXMLWriter::Appended })
  {
    const Mesh mesh = Torus(70, 80);
    vtkNew<vtkXMLPolyDataWriter> writer;
    writer->SetInputData(ToPolyData(mesh));
    writer->SetFileName((this->Folder / "in.vtp").c_str());
    writer->SetDataMode(mode);
    writer->Write();
    EXPECT_EQ(this->Converted("in.vtp").triangles.size(), mesh.triangles.size());
    std::string text = ReadWhole(this->Folder / "in.vtp");
    const std::string count = "NumberOfPolys=\"" + std::to_string(mesh.triangles.size()) + "\"";
    ASSERT_NE(text.find(count), std::string::npos);
    text.replace(text.find(count), count.size(), "NumberOfPolys=\"0005\"");
    this->WriteText("in.vtp", text);
    EXPECT_NE(this->Convert("in.vtp").err.find(
                std::to_string(mesh.triangles.size() - 5) + " points or faces are in the file but"),
      std::string::npos);
  }
  this->WriteText("in.vtp", vtp("5", "3"));
  this->ExpectError("in.vtp",
    "<Polys> of piece 0 (line 1): its array 'offsets' has fewer numbers than the piece counts");
}

TEST_F(TestTolerance, VrmlOfOtherPrograms)
{
  if (!hasVrml)
  {
    GTEST_SKIP() << "VRML needs Coin";
  }
  const std::string first = "#VRML V1.0 ascii\n", second = "#VRML V2.0 utf8\n";
  const std::string pictures = "its pictures are not read";
  const std::string field = "1 field is unknown in the format and is left out: ";
  for (const auto& [text, warning] :
    {
      std::pair{
        first + "Separator { Texture2 { filename a.jpg wrapS REPEAT } Cube { } }", pictures },
      { first + "Separator { Texture2 { filename } Cube { } }", pictures },
      { second +
          "Shape { appearance Appearance { texture ImageTexture { url a.png } } geometry Box { } }",
        pictures },
      { first + "Separator { Background { skyColor 0 0 1 } Cube { } }", std::string() },
      { first + "Separator { Knob { turn 1 } Cube { parts (SIDES | TOP | BOTTOM) } }",
        "1 node cannot be read and is left out: 'Knob', which VRML does not have (line 2)" },
      { first + "Separator { glow 1 DEF c Cube { width 2 shine [ 1, 2 ] } ShapeHints { shapeType "
                "SOLID faceType CONVEX } }",
        std::string("2 fields are unknown in the format and are left out; the first: 'glow' of "
                    "'Separator' (line 2)") },
      { second + "Shape { geometry Box { solid2 TRUE size 2 2 2 } }",
        field + "'solid2' of 'Box' (line 2)" },
      { second + "Shape { glow Sphere { radius 9 } geometry Box { } }",
        field + "'glow' of 'Shape' (line 2)" },
      { second + "PROTO P [ field SFVec3f s 2 2 2 ] { Shape { geometry Box { size IS s far [ 1 2 ] "
                 "} } } P { }",
        field + "'far' of 'Box' (line 2)" },
    })
  {
    SCOPED_TRACE(text);
    this->WriteText("in.wrl", text + "\n");
    const Outcome outcome = this->Convert("in.wrl");
    EXPECT_EQ(outcome.exitCode, 0) << outcome.err;
    EXPECT_NE(outcome.err.find(warning), std::string::npos) << outcome.err;
    EXPECT_EQ(outcome.err.empty(), warning.empty()) << outcome.err;
    EXPECT_EQ(this->Read("out.ply").triangles.size(), 12U);
  }
  // Also after brackets and strings.
  this->WriteText("in.wrl",
    second + "Shape { geometry IndexedFaceSet { coord Coordinate { point [ 0 0 0, 1 0 0, 0 1 0 ] } "
             "coordIndex [ 0 1 2 ] glow 1 2 3 foo \"a b\" bar [ \"x\" ] } }\n");
  EXPECT_EQ(this->Built("in.wrl", { { "fields_not_known", 3 } }).size(), 1U);
  this->WriteText("in.wrl", second + "Shape { glow 1 geometry Box { solid2 TRUE } }\n");
  EXPECT_EQ(this->Built("in.wrl", { { "fields_not_known", 2 } }).size(), 1U);
  // A misspelt node, a missing PROTO, a missing file, a node that is not a shape.
  const std::string box = "Shape { geometry Box { } }";
  for (const std::string& node :
    { std::string("Transfrom { translation 5 0 0 children [ " + box + " ] }"),
      std::string("Chair { legs 4 }"), std::string("EXTERNPROTO Chair [ ] \"chair.wrl\" Chair { }"),
      std::string("Inline { url \"chair.wrl\" }"),
      std::string("Shape { geometry Sphere { radius -1 } }"),
      std::string("File { name \"chair.iv\" }") })
  {
    SCOPED_TRACE(node);
    this->WriteText("in.wrl", second + box + "\n" + node + "\n");
    EXPECT_EQ(this->Built("in.wrl", { { "nodes_left_out", 1 } }).size(), 1U);
  }
}

// VTK supports none of these. Attributes that are not numbers stay texts.
TEST_F(TestTolerance, TextsOfVtkAreTexts)
{
  const std::string text = "# vtk DataFile Version 3.0\nt\nASCII\nDATASET POLYDATA\nPOINTS 4 "
                           "float\n0 0 0\n1 0 0\n0 1 0\n0 0 1\nPOLYGONS 2 8\n3 0 1 2\n3 0 1 3\n";
  const auto replaced = [](std::string in, const std::string& from, const std::string& to)
  {
    for (std::size_t at = 0; (at = in.find(from, at)) != std::string::npos; at += to.size())
    {
      in.replace(at, from.size(), to);
    }
    return in;
  };
  for (const std::string& other :
    { "\xEF\xBB\xBF" + text, replaced(text, "\n", "\r"), text + "\n\x1A" })
  {
    this->WriteText("in.vtk", other);
    EXPECT_EQ(this->Converted("in.vtk").triangles.size(), 2U);
  }
  this->WriteText("in.vtk", text + std::string(10, '\0'));
  EXPECT_EQ(this->Built("in.vtk", { { "padding_bytes", 10 } }).size(), 1U);
  for (const std::string number : { "nan", "-nan(ind)", "1.#QNAN", "-inf" })
  {
    this->WriteText("in.vtk", replaced(text, "0 0 1\n", "0 " + number + " 1\n") +
                                "POINT_DATA 4\nSCALARS s float\nLOOKUP_TABLE default\n1 " + number +
                                " 3 4\n");
    EXPECT_EQ(this
                ->Built("in.vtk", { { "points_not_finite", 1 }, { "faces_of_dropped_points", 1 } },
                  { "--precision", "lossless" })
                .size(),
      2U);
    const Mesh read = this->Extracted();
    EXPECT_EQ(read.triangles.size(), 1U);
    const std::vector<double> values = ValuesOf(read, "s");
    ASSERT_EQ(values.size(), 3U);
    EXPECT_EQ(
      std::count_if(values.begin(), values.end(), [](double v) { return std::isnan(v); }), 1);
  }
  std::string utf16;
  for (const char c : text)
  {
    utf16 += { c, '\0' };
  }
  this->WriteText("in.vtk", utf16);
  this->ExpectError("in.vtk", "is text in UTF-16 or UTF-32");
  this->WriteText("in.vtp",
    "<VTKFile type=\"PolyData\"><PolyData><Piece NumberOfPoints=\"3\" NumberOfPolys=\"1\"><Points>"
    "<DataArray type=\"Float32\" NumberOfComponents=\"3\" format=\"ascii\">0 0 0 1 0 0 0 1 0"
    "</DataArray></Points><Polys><DataArray type=\"Int32\" Name=\"connectivity\" format=\"ascii\">"
    "0 1 2</DataArray><DataArray type=\"Int32\" Name=\"offsets\" format=\"ascii\">3</DataArray>"
    "</Polys></Piece></PolyData></VTKFile>\n" +
      std::string(10, '\0'));
  EXPECT_EQ(this->Built("in.vtp", { { "padding_bytes", 10 } }).size(), 1U);
}

TEST_F(TestTolerance, AnStlMayLackItsEnd)
{
  const std::string facet = "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 "
                            "1 0.5\nendloop\nendfacet\n";
  this->WriteText("in.stl", "solid a\n" + facet + facet);
  EXPECT_EQ(this->Built("in.stl", { { "end_missing", 1 } }),
    (Warnings{ "1 end of a part is missing: the part may be truncated: 'endsolid'" }));
}

TEST_F(TestTolerance, OffGoesThroughTheProgramsAsPlyDoes)
{
  const std::string off = "COFF\n4 2 0\n0 0 0 255 0 0 255\n1 0 0 0 255 0 255\n1 1 0 0 0 255 255\n"
                          "0 1 0.5 9 9 9 255\n3 0 1 2 # first\n4 0 1 2 3\n";
  this->WriteText("in.off", off);
  EXPECT_EQ(
    this->Built("in.off", nlohmann::json::object(), { "--precision", "lossless" }), Warnings{});
  EXPECT_EQ(this->Extracted().triangles.size(), 3U);
  const Mesh read = this->Converted("in.off");
  EXPECT_EQ(read.points.size(), 4U);
  EXPECT_EQ(ValuesOf(read, "RGBA").size(), 16U);
  this->WriteText("in.off", off + "3 1 2 3\n");
  EXPECT_EQ(this->Built("in.off", { { "bytes_behind_end", 9 } }).size(), 1U);
}

TEST_F(TestTolerance, FloatsAreReportedWhereTheyLoseDecimals)
{
  const std::string begin =
    "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 "
    "1\nWIDTH 2\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 2\nDATA ascii\n";
  for (const auto& [x, reported] :
    { std::pair{ "5000000.25", true }, { "5000000.5", false }, { "5000000.1234", true } })
  {
    this->WriteText("in.pcd", begin + x + " 0 0\n5000001 1 1\n");
    const Outcome outcome = this->Convert("in.pcd");
    const bool isReported = outcome.err.find("are read as floats") != std::string::npos;
    if (outcome.err.find("needs PCL") == std::string::npos)
    {
      EXPECT_EQ(isReported, reported) << outcome.err;
    }
    if (hasVrml)
    {
      this->WriteText("in.wrl",
        std::string("#VRML V2.0 utf8\nShape { geometry PointSet { coord Coordinate { point [ ") +
          x + " 0 0, 5000001 1 1 ] } } }\n");
      EXPECT_EQ(
        this->Convert("in.wrl").err.find("are read as floats") != std::string::npos, reported);
    }
  }
}

TEST_F(TestTolerance, CausesAreNamed)
{
  const std::string comma = "'10,5' is not a number (a decimal comma: write 1.5 for 1,5)";
  const std::string lfs =
    "version https://git-lfs.github.com/spec/v1\noid sha256:4d7a2\nsize 12345\n";
  for (const auto& [file, text, what] : { std::tuple{ "a.obj", std::string("v 10,5 2 3\n"), comma },
         { "a.stl",
           "solid s\nfacet normal 0 0 1\nouter loop\nvertex 10,5 2 3\nvertex 1 2 3\nvertex 1 2 "
           "4\nendloop\nendfacet\nendsolid s\n",
           comma },
         { "a.ply", lfs, "run git lfs pull" }, { "b.obj", lfs, "run git lfs pull" },
         { "b.stl", lfs, "run git lfs pull" }, { "a.vtp", lfs, "run git lfs pull" },
         { "a.vtk", lfs, "run git lfs pull" }, { "a.gltf", lfs, "run git lfs pull" },
         { "a.glb", lfs, "run git lfs pull" }, { "a.xyz", lfs, "run git lfs pull" },
         { "b.ply", "\x89PNG\r\n\x1a\n...", "is a PNG picture, and no mesh" },
         { "b.gltf", std::string("\xFF\xFE{\0}\0", 6), "UTF-16" },
         { "c.gltf",
           "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{"
           "\"matrix\":[1,0,0,5,0,1,0,6,0,0,1,7,0,0,0,1]}]}",
           "node 0 has a matrix whose last row is not 0 0 0 1" } })
  {
    SCOPED_TRACE(file);
    this->WriteText(file, text);
    this->ExpectError(file, what);
  }
}

TEST_F(TestTolerance, NamesBeyondAscii)
{
  const std::string obj =
    "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl m\n"
    "f 1/1 2/2 3/3\n";
  this->WriteText("a.obj", obj);
  this->WriteText("a.mtl", "newmtl m\nmap_Kd C:\\tex\\größe.png\n");
  EXPECT_NE(this->Convert("a.obj").err.find("größe.png' (a.mtl, line 2)"), std::string::npos);
  this->WriteText("größe.png", "no picture");
  this->WriteText("a.mtl", "newmtl m\nmap_Kd GRÖßE.PNG\n");
  EXPECT_EQ(this->Convert("a.obj").err.find("is not there"), std::string::npos);
}
