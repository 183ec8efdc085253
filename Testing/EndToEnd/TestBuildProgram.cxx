// SPDX-License-Identifier: BSD-3-Clause
// kdstream-build as doc/cli.md describes it: its output, its messages and its exit codes.
#include "Testing/EndToEnd/ProgramsTest.h"
#include "Testing/Fixtures/Invariants.h"
#include "Testing/Fixtures/Meshes.h"

#include <nlohmann/json.hpp>

#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <csignal>
#include <sstream>
#include <thread>

using namespace kdstream;
using namespace kdstream::fixtures;
using Json = nlohmann::json;

namespace
{

class BuildProgram : public ProgramsTest
{
};

std::string Ply(const std::string& vertices, const std::string& faces, const std::string& body)
{
  return "ply\nformat ascii 1.0\nelement vertex " + vertices +
         "\nproperty float x\nproperty float y\nproperty float z\nelement face " + faces +
         "\nproperty list uchar int vertex_indices\nend_header\n" + body;
}

}

TEST_F(BuildProgram, HelpAndVersion)
{
  for (const std::string name : { "build", "generate" })
  {
    const Outcome help = RunTool(this->Folder, name, { "--help" });
    EXPECT_EQ(help.exitCode, 0);
    EXPECT_NE(help.out.find("\nExample:\n  kdstream-" + name), std::string::npos) << help.out;
    EXPECT_NE(
      help.out.find(name == "build" ? "\nUsage: kdstream-build INPUT -o STORE.kds [options]\n"
                                    : "\nUsage: kdstream-generate KIND FILE [options]\n"),
      std::string::npos)
      << help.out;
    std::istringstream lines(help.out);
    for (std::string line; std::getline(lines, line);)
    {
      EXPECT_LE(line.size(), 100U) << line;
    }
    EXPECT_EQ(RunTool(this->Folder, name, { "--version" }).out, "kdstream-" + name + " 0.9.0\n");
  }
}

TEST_F(BuildProgram, AllOfALosslessStoreIsTheInput)
{
  for (const NamedMesh& named : AllMeshes())
  {
    SCOPED_TRACE(named.name);
    this->Write("in.ply", named.mesh);
    const Outcome built = this->Build({ "in.ply", "-o", "m.kds", "--precision", "lossless",
      "--weld", "off", "--vertices-per-partition", "150", "--stats", "s.json", "--quiet" });
    ASSERT_EQ(built.exitCode, 0) << built.err;
    const std::string unused = named.name == "isolated vertices" ? "1026 vertices"
                               : named.name == "repeated cube"   ? "1743 vertices"
                                                                 : "";
    EXPECT_EQ((built.out + built.err).empty(), unused.empty()) << built.err;
    EXPECT_NE(built.err.find(unused), std::string::npos) << built.err;
    ASSERT_EQ(this->Store({ "extract", "m.kds", "--all", "-o", "out.ply" }).exitCode, 0);
    const Mesh out = this->Read("out.ply");
    EXPECT_EQ(PointMultiset(out), PointMultiset(named.mesh));
    EXPECT_EQ(TriangleMultiset(out), TriangleMultiset(named.mesh));
    const Json stats = Json::parse(ReadWhole(this->Folder / "s.json"));
    EXPECT_EQ(stats["vertices"].get<std::size_t>() +
                (unused.empty() ? 0 : stats["unused"]["vertices"].get<std::size_t>()),
      named.mesh.points.size());
    EXPECT_EQ(stats["triangles"], named.mesh.triangles.size());
    EXPECT_LE(
      stats["partition_vertices"]["max"].get<int>() - stats["partition_vertices"]["min"].get<int>(),
      1);
  }
}

// A survey in map coordinates has a vertex at the origin that no triangle uses.
TEST_F(BuildProgram, WhatNoTriangleUsesIsNamedAndComesBack)
{
  Mesh survey = Shuffled(HeightField(40), 3);
  survey.scalarType = ScalarType::Float64;
  for (Vec3& point : survey.points)
  {
    point = { point[0] * 100 + 412345.25, point[1] * 100 + 5312345.5, point[2] * 100 };
  }
  this->Write("without.ply", survey);
  survey.points.push_back({ 0, 0, 0 });
  this->Write("one.ply", survey);
  survey.points.push_back({ 412400, 5312400, 1 });
  this->Write("two.ply", survey);
  const auto build = [&](const std::string& name, std::vector<std::string> options = {})
  {
    options.insert(options.begin(),
      { name + ".ply", "-o", name + ".kds", "--stats", name + ".json", "--quiet" });
    const Outcome built = this->Build(options);
    EXPECT_EQ(built.exitCode, 0) << built.err;
    return built.err;
  };
  EXPECT_EQ(build("without"), "");
  EXPECT_EQ(build("one"),
    "kdstream-build: warning: one.ply: 1 vertex that no triangle uses, at (0, 0, "
    "0): kept in the original, not shown\n");
  const auto stats = [&](const std::string& name)
  { return Json::parse(ReadWhole(this->Folder / (name + ".json"))); };
  EXPECT_FALSE(stats("without").contains("unused"));
  EXPECT_EQ(stats("one")["unused"]["vertices"], 1);
  for (const char* key : { "vertices", "box", "levels", "pose", "merged_by_grid" })
  {
    EXPECT_EQ(stats("one")[key], stats("without")[key]) << key;
  }
  Mesh within = survey;
  within.points.erase(within.points.end() - 2); // the last vertex stays; it is in the middle
  this->Write("within.ply", within);
  EXPECT_EQ(build("within"),
    "kdstream-build: warning: within.ply: 1 vertex that no triangle uses, within "
    "the model's box: kept in the original, not shown\n");
  EXPECT_EQ(build("two", { "--precision", "lossless", "--weld", "off" }),
    "kdstream-build: warning: two.ply: 2 vertices that no triangle uses, the farthest at (0, 0, "
    "0): kept in the original, not shown\n");
  EXPECT_NE(this->Store({ "info", "two.kds" })
              .out.find("2 vertices that no triangle uses, the "
                        "farthest at (0, 0, 0)"),
    std::string::npos);
  EXPECT_EQ(this->Store({ "verify", "two.kds" }).exitCode, 0);
  for (const std::string ending : { ".ply", ".obj" })
  {
    ASSERT_EQ(this->Store({ "extract", "two.kds", "--all", "-o", "out" + ending }).exitCode, 0);
    const Mesh out = this->Read("out" + ending);
    EXPECT_EQ(PointMultiset(out), PointMultiset(survey)) << ending;
    EXPECT_EQ(TriangleMultiset(out), TriangleMultiset(survey)) << ending;
  }
  for (const std::string ending : { ".stl", ".glb" })
  {
    const Outcome outcome = this->Store({ "extract", "two.kds", "--all", "-o", "out" + ending });
    EXPECT_EQ(outcome.exitCode, 0);
    EXPECT_NE(outcome.err.find("this format cannot hold 2 vertices that no triangle uses"),
      std::string::npos)
      << outcome.err;
  }
  const auto distance = [&](const std::string& against)
  {
    return Json::parse(
      this->Store({ "distance", "one.kds", "--level", "9", "--against", against, "--json" }).out);
  };
  EXPECT_EQ(distance("one.ply"), distance("without.ply"));
}

TEST_F(BuildProgram, StatsHaveTheContractsKeys)
{
  this->Write("in.ply", Torus(96, 48));
  ASSERT_EQ(this->Build({ "in.ply", "-o", "m.kds", "--stats", "s.json" }).exitCode, 0);
  const Json stats = Json::parse(ReadWhole(this->Folder / "s.json"));
  for (const char* key :
    { "input", "vertices", "triangles", "partitions", "partition_depth", "stitch_depth", "welded",
      "inconsistent_edges", "passes", "peak_rss_bytes", "temp_bytes", "store_bytes", "digest" })
  {
    EXPECT_TRUE(stats.contains(key)) << key;
  }
  for (const char* key : { "read", "tree", "faces", "levels", "encode", "write", "total" })
  {
    EXPECT_TRUE(stats["seconds"].contains(key)) << key;
  }
  ASSERT_EQ(stats["levels"].size(), 12U);
  for (const char* key : { "depth", "vertices", "triangles", "pieces", "bytes", "deviation" })
  {
    EXPECT_TRUE(stats["levels"][5].contains(key)) << key;
  }
  EXPECT_EQ(stats["store_bytes"], std::filesystem::file_size(this->Folder / "m.kds"));
  const Json info = Json::parse(this->Store({ "info", "m.kds", "--json" }).out);
  EXPECT_EQ(info["digest"], stats["digest"]);
  EXPECT_EQ(info["levels"], stats["levels"]);
  EXPECT_NE(this->Store({ "info", "m.kds" }).out.find(stats["digest"].get<std::string>()),
    std::string::npos);
}

TEST_F(BuildProgram, EveryOptionChangesSomething)
{
  this->Write("in.ply", Shuffled(DisplacedSphere(5), 4));
  const auto stats = [&](std::vector<std::string> options)
  {
    options.insert(options.begin(), { "in.ply", "-o", "m.kds", "--stats", "s.json" });
    const Outcome built = this->Build(options);
    EXPECT_EQ(built.exitCode, 0) << built.err;
    return Json::parse(ReadWhole(this->Folder / "s.json"));
  };
  const Json plain = stats({});
  EXPECT_EQ(stats({ "--vertices-per-partition", "100" })["partitions"], 64);
  EXPECT_EQ(stats({ "--partitions", "16" })["partitions"], 16);
  EXPECT_EQ(stats({ "--cell-vertices", "1" })["levels"].size(), 14U);
  const Json cluster = stats({ "--levels", "cluster" });
  EXPECT_NE(cluster["digest"], plain["digest"]);
  EXPECT_EQ(cluster["level_maker"], "cluster");
  EXPECT_EQ(plain["level_maker"], "collapse");
  EXPECT_EQ(stats({ "--levels", "cluster", "--sheets", "off" })["levels"][8]["vertices"], 256);
  EXPECT_NE(stats({ "--sheets", "off" })["digest"], plain["digest"]);
  EXPECT_NE(stats({ "--representative", "mean" })["digest"], plain["digest"]);
  EXPECT_EQ(stats({ "--precision", "8" })["precision"], 8);
  EXPECT_EQ(stats({ "--precision", "lossless" })["precision"], "lossless");
  const Json named = stats(
    { "--title", "T", "--credit", "C", "--license", "L", "--unit", "mm", "--description", "D" });
  EXPECT_EQ(named["title"], "T");
  EXPECT_EQ(named["credit"], "C");
  EXPECT_EQ(named["license"], "L");
  EXPECT_EQ(named["unit"], "mm");
  EXPECT_EQ(named["description"], "D");
  for (const char* threads : { "1", "2", "8" })
  {
    EXPECT_EQ(stats({ "--threads", threads, "--partitioner", "kdtree", "--levels", "collapse",
                "--memory", "1G" })["digest"],
      plain["digest"]);
  }
  Mesh doubled = Torus(40, 20);
  doubled.points.insert(doubled.points.end(), doubled.points.begin(), doubled.points.end());
  this->Write("in.ply", doubled);
  EXPECT_EQ(stats({})["welded"], 800);
  EXPECT_EQ(stats({ "--weld", "off" })["welded"], 0);
}

TEST_F(BuildProgram, BaselinesHavePartitionsAndNoLevels)
{
  const Mesh torus = Torus(40, 20);
  this->Write("in.ply", torus);
  for (const std::string partitioner : { "octree", "kmeans" })
  {
    SCOPED_TRACE(partitioner);
    ASSERT_EQ(this
                ->Build({ "in.ply", "-o", "m.kds", "--partitioner", partitioner, "--partitions",
                  "100", "--precision", "lossless", "--weld", "off" })
                .exitCode,
      0);
    const Json info = Json::parse(this->Store({ "info", "m.kds", "--json" }).out);
    EXPECT_EQ(info["partitioner"], partitioner);
    EXPECT_TRUE(info["levels"].empty());
    EXPECT_GE(info["partitions"], 50);
    EXPECT_EQ(this->Store({ "verify", "m.kds" }).exitCode, 0);
    ASSERT_EQ(this->Store({ "extract", "m.kds", "--all", "-o", "all.ply" }).exitCode, 0);
    EXPECT_EQ(TriangleMultiset(this->Read("all.ply")), TriangleMultiset(torus));
    ASSERT_EQ(this->Store({ "extract", "m.kds", "--region", "133", "-o", "some.ply" }).exitCode, 0);
    const Mesh region = this->Read("some.ply");
    EXPECT_GT(region.triangles.size(), 0U);
    EXPECT_LT(region.triangles.size(), torus.triangles.size());
    for (const std::vector<std::string>& level :
      { std::vector<std::string>{ "--level", "3" }, { "--region", "1", "--in-context", "3" } })
    {
      std::vector<std::string> arguments{ "extract", "m.kds", "-o", "x.ply" };
      arguments.insert(arguments.end(), level.begin(), level.end());
      const Outcome outcome = this->Store(arguments);
      EXPECT_EQ(outcome.exitCode, 2);
      EXPECT_NE(outcome.err.find("a store by --partitioner " + partitioner + " has no levels"),
        std::string::npos)
        << outcome.err;
    }
  }
}

TEST_F(BuildProgram, WrongUsageExitsWith2)
{
  this->Write("in.ply", Torus(40, 20));
  const std::vector<std::vector<std::string>> wrong{ {}, { "in.ply" },
    { "in.ply", "-o", "m.kds", "--nonsense" }, { "in.ply", "-o", "m.kds", "--levels", "quadrics" },
    { "in.ply", "-o", "m.kds", "--partitioner", "grid" },
    { "in.ply", "-o", "m.kds", "--partitioner", "octree", "--levels", "cluster" },
    { "in.ply", "-o", "m.kds", "--partitioner", "kmeans", "--sheets", "on" },
    { "in.ply", "-o", "m.kds", "--partitioner", "octree", "--partitions", "801" },
    { "in.ply", "-o", "m.kds", "--precision", "7" },
    { "in.ply", "-o", "m.kds", "--precision", "25" },
    { "in.ply", "-o", "m.kds", "--precision", "fine" },
    { "in.ply", "-o", "m.kds", "--partitions", "3" },
    { "in.ply", "-o", "m.kds", "--partitions", "1024" },
    { "in.ply", "-o", "m.kds", "--partitions", "0" },
    { "in.ply", "-o", "m.kds", "--partitions", "4", "--vertices-per-partition", "10" },
    { "in.ply", "-o", "m.kds", "--vertices-per-partition", "0" },
    { "in.ply", "-o", "m.kds", "--memory", "lots" }, { "in.ply", "-o", "m.kds", "--memory", "64" },
    { "in.ply", "-o", "m.kds", "--sheets", "maybe" },
    { "in.ply", "-o", "m.kds", "--cell-vertices", "0" },
    { "in.ply", "-o", "m.kds", "--threads", "0" } };
  for (const auto& arguments : wrong)
  {
    const Outcome outcome = this->Build(arguments);
    const std::string last = arguments.empty() ? "" : arguments.back();
    EXPECT_EQ(outcome.exitCode, 2) << last;
    EXPECT_EQ(outcome.err.rfind("kdstream-build: error: ", 0), 0U) << outcome.err;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  }
  EXPECT_EQ(this->Files(), (std::set<std::string>{ "in.ply" }));
}

TEST_F(BuildProgram, MemoryWithoutAUnitIsExplained)
{
  this->Write("in.ply", Torus(40, 20));
  this->ExpectError(this->Build({ "in.ply", "-o", "m.kds", "--memory", "64" }), 2,
    "kdstream-build: error: --memory: ");
  this->ExpectError(this->Build({ "in.ply", "-o", "m.kds", "--memory", "64K" }), 2,
    "kdstream-build: error: --memory: ");
  this->ExpectError(this->Build({ "in.ply", "-o", "m.kds", "--memory", "lots" }), 2,
    "kdstream-build: error: --memory: ");
  EXPECT_EQ(this->Build({ "in.ply", "-o", "m.kds", "--memory", "67108864" }).exitCode, 0);
}

TEST_F(BuildProgram, AStoreOfAnotherEndingIsWarnedOf)
{
  this->Write("in.ply", Torus(40, 20));
  for (const char* output : { "m.xyz", "m", "m.KDS" })
  {
    const Outcome outcome = this->Build({ "in.ply", "-o", output, "--quiet" });
    EXPECT_EQ(outcome.exitCode, 0);
    EXPECT_EQ(outcome.err, "kdstream-build: warning: " + std::string(output) +
                             ": kdstream-serve only serves files that end in .kds\n");
    EXPECT_EQ(this->Store({ "verify", output }).exitCode, 0);
  }
  EXPECT_EQ(this->Build({ "in.ply", "-o", "m.kds", "--quiet" }).err, "");
}

TEST_F(BuildProgram, BadInputIsNamedWithItsPlace)
{
  const std::string cube = "0 0 0\n1 0 0\n0 1 0\n1 1 0\n";
  this->WriteText("empty.ply", "");
  this->WriteText("text.ply", "no mesh at all\n");
  this->WriteText("range.ply", Ply("4", "2", cube + "3 0 1 2\n3 1 2 99\n"));
  this->WriteText("nan.ply", Ply("4", "1", "0 0 0\n1 0 nan\n0 1 0\n1 1 0\n3 0 1 2\n"));
  this->WriteText("none.ply", Ply("0", "0", ""));
  this->WriteText("model.ifc", "1 2 3\n");
  Mesh wide = Torus(40, 20);
  wide.scalarType = ScalarType::Float64;
  for (Vec3& p : wide.points)
  {
    p[1] *= 1e306; // levels would hold NaN
  }
  this->Write("wide.ply", wide);
  this->Write("whole.ply", Torus(40, 20));
  const std::string whole = ReadWhole(this->Folder / "whole.ply");
  std::ofstream(this->Folder / "cut.ply", std::ios::binary) << whole.substr(0, whole.size() - 5);
  std::ofstream(this->Folder / "cut2.ply", std::ios::binary) << whole.substr(0, 1000);

  const auto error = [&](const std::string& file)
  {
    const Outcome outcome = this->Build({ file, "-o", "m.kds" });
    EXPECT_EQ(outcome.exitCode, 1) << file;
    EXPECT_EQ(outcome.err.rfind("kdstream-build: error: " + file + ": ", 0), 0U) << outcome.err;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    EXPECT_FALSE(std::filesystem::exists(this->Folder / "m.kds"));
    return outcome.err;
  };
  const auto expect = [&](const std::string& file, const std::string& what)
  { EXPECT_NE(error(file).find(what), std::string::npos) << error(file) << "\nlacks: " << what; };
  expect("missing.ply", "no such file");
  expect("empty.ply", "empty");
  expect("text.ply", "not a PLY");
  expect("range.ply", "face 1 (line 15) names vertex 99, but there are only 4, counted from 0");
  expect("none.ply", "the mesh has no vertices");
  expect("model.ifc", ".ifc");
  // Each partitioner checks this by itself.
  for (const char* partitioner : { "kdtree", "octree", "kmeans" })
  {
    this->ExpectError(this->Build({ "wide.ply", "-o", "m.kds", "--partitioner", partitioner }), 1,
      "kdstream-build: error: wide.ply: ");
    EXPECT_FALSE(std::filesystem::exists(this->Folder / "m.kds")) << partitioner;
  }
  expect("cut.ply", "face 1599");
  expect("cut2.ply", "vertex ");
}

// A build's input may be unusable in the same ways as its output, for example because it is a link
// to itself.
TEST_F(BuildProgram, AnUnreadableInputIsNamed)
{
  for (const std::string input : { "in.ply", "in.stl", "in.obj" })
  {
    std::filesystem::create_symlink(input, this->Folder / input); // even root cannot open it
    this->ExpectError(
      this->Build({ input, "-o", "m.kds" }), 1, "kdstream-build: error: " + input + ": ");
  }
}

TEST_F(BuildProgram, ContentOfAnotherFormatThanTheEndingIsReported)
{
  this->Write("mesh.ply", Torus(40, 20));
  this->Write("text.obj", Torus(40, 20));
  this->WriteText("solid.txt", "solid a\nendsolid a\n");
  for (const auto& [content, name, expected] :
    { std::array<std::string, 3>{ "mesh.ply", "x.stl",
        "a .ply file, although its name ends in .stl: rename it to end in .ply" },
      { "mesh.ply", "x.obj",
        "a .ply file, although its name ends in .obj: rename it to end in .ply" },
      { "solid.txt", "y.ply",
        "a .stl file, although its name ends in .ply: rename it to end in .stl" } })
  {
    std::filesystem::copy(this->Folder / content, this->Folder / name);
    this->ExpectError(this->Build({ name, "-o", "m.kds" }), 1,
      "kdstream-build: error: " + name + ": looks like " + expected);
  }
}

TEST_F(BuildProgram, WarnsOfFloatsFarFromTheOrigin)
{
  // A ground of a hundred metres with one vertex for each metre, in UTM coordinates.
  Mesh ground;
  constexpr unsigned side = 100;
  for (unsigned i = 0; i < side * side; ++i)
  {
    ground.points.push_back({ 430000.0 + i % side, 5400000.0 + i / side, 0.1 * (i % 7) });
  }
  const auto warning = [&](ScalarType type, double north)
  {
    Mesh mesh = ground;
    mesh.scalarType = type;
    for (Vec3& p : mesh.points)
    {
      p[1] -= 5400000.0 - north;
    }
    this->Write("in.ply", mesh);
    return this->Build({ "in.ply", "-o", "m.kds", "--unit", "m", "--quiet" }).err;
  };
  EXPECT_EQ(warning(ScalarType::Float32, 5400000.0),
    "kdstream-build: warning: in.ply: the coordinates are so far from 0 that floats only hold "
    "multiples of 0.5 m: if they were rounded, the surface shows steps; subtract an offset before "
    "writing floats, or write doubles\n");
  EXPECT_EQ(warning(ScalarType::Float64, 5400000.0), "");
  EXPECT_EQ(warning(ScalarType::Float32, 0), "") << "0.03 m at 430 km, a thirtieth of the spacing";
}

TEST_F(BuildProgram, TheLastLineReportsWhatIsWritten)
{
  this->Write("in.ply", Torus(40, 20));
  const Outcome built = this->Build({ "in.ply", "-o", "m.kds" });
  const std::string start = "kdstream-build: wrote m.kds: ";
  EXPECT_EQ(built.err.rfind(start, 0), 0U) << built.err;
  EXPECT_NE(built.err.find(" kB in 0."), std::string::npos) << built.err;
  EXPECT_EQ(built.err.find('\n'), built.err.size() - 1) << built.err;
  EXPECT_EQ(this->Build({ "in.ply", "-o", "m.kds", "--quiet" }).err, "");
}

TEST_F(BuildProgram, WrongOptionsAreReportedWithTheNearest)
{
  this->ExpectError(this->Build({ "in.ply", "-o", "m.kds", "--tittle", "x" }), 2,
    "kdstream-build: error: there is no option --tittle; did you mean --title? (see --help)");
}

TEST_F(BuildProgram, GeneratedFilesArePly)
{
  const auto generate = [&](const std::string& file) {
    return RunTool(this->Folder, "generate", { "vase", file, "--vertices", "2000" });
  };
  this->ExpectError(generate("x.obj"), 2, "kdstream-generate: error: x.obj: ");
  EXPECT_EQ(this->Files(), std::set<std::string>{});
  const Outcome made = generate("x.ply");
  EXPECT_EQ(made.exitCode, 0);
  EXPECT_EQ(made.err.rfind("kdstream-generate: wrote x.ply: ", 0), 0U) << made.err;
}

TEST_F(BuildProgram, UnwritableOutputIsNamed)
{
  this->Write("in.ply", Torus(40, 20));
  ASSERT_EQ(this->Build({ "in.ply", "-o", "m.kds" }).exitCode, 0);
  EXPECT_EQ(this->Build({ "in.ply", "-o", "m.kds", "--stats", "no/s.json" }).err,
    "kdstream-build: error: no/s.json: cannot create a file in no: No such file or directory\n");
  const Outcome outcome = this->Store({ "extract", "m.kds", "--all", "-o", "in.ply/x.ply" });
  EXPECT_EQ(outcome.exitCode, 1);
  EXPECT_EQ(outcome.err.rfind("kdstream-store: error: in.ply/x.ply: ", 0), 0U) << outcome.err;
  EXPECT_EQ(this->Store({ "extract", "m.kds", "--all", "-o", "x.doc" }).exitCode, 2);
}

TEST_F(BuildProgram, WarnsWhereTheGridIsTooCoarse)
{
  Mesh apart = Torus(40, 20);
  const std::size_t one = apart.points.size(), triangles = apart.triangles.size();
  for (std::size_t v = 0; v < one; ++v)
  {
    apart.points.push_back({ apart.points[v][0] + 65536, apart.points[v][1], apart.points[v][2] });
  }
  for (std::size_t t = 0; t < triangles; ++t)
  {
    const Triangle& below = apart.triangles[t];
    const auto up = static_cast<VertexId>(one);
    apart.triangles.push_back({ below[0] + up, below[1] + up, below[2] + up });
  }
  this->Write("in.ply", apart);
  const Outcome coarse = this->Build({ "in.ply", "-o", "m.kds", "--precision", "10" });
  EXPECT_EQ(coarse.exitCode, 0);
  EXPECT_NE(
    coarse.err.find("vertices coincide with others on a grid of 10 bits"), std::string::npos)
    << coarse.err;
  EXPECT_EQ(this->Build({ "in.ply", "-o", "m.kds", "--precision", "lossless", "--quiet" }).err, "");
}

TEST_F(BuildProgram, StatisticsAreNotTheStore)
{
  this->Write("in.ply", Torus(40, 20));
  this->ExpectError(this->Build({ "in.ply", "-o", "m.kds", "--stats", "m.kds" }), 2,
    "kdstream-build: error: m.kds: --stats and --output name the same file");
  EXPECT_EQ(this->Files(), std::set<std::string>{ "in.ply" });
}

TEST_F(BuildProgram, NamesAPointThatMakesTheGridCoarse)
{
  Mesh cloud = DisplacedSphere(5);
  cloud.triangles.clear();
  for (Vec3& point : cloud.points)
  {
    point[1] += 1000;
  }
  const std::size_t number = cloud.points.size() / 2;
  cloud.points.insert(cloud.points.begin() + std::ptrdiff_t(number), Vec3{});
  this->Write("in.ply", cloud);
  const std::string stray = " bits: point " + std::to_string(number) +
                            " at (0, 0, 0) is so far from all others that the grid is ";
  for (const std::vector<std::string>& memory :
    { std::vector<std::string>{}, { "--memory", "64M" } })
  {
    std::vector<std::string> arguments{ "in.ply", "-o", "m.kds", "--precision", "12" };
    arguments.insert(arguments.end(), memory.begin(), memory.end());
    const Outcome built = this->Build(arguments);
    EXPECT_EQ(built.exitCode, 0);
    EXPECT_NE(built.err.find(stray), std::string::npos) << built.err;
    EXPECT_NE(built.err.find("remove it from the input"), std::string::npos) << built.err;
  }
  // If half of the points are far away, they are not strays.
  for (std::size_t v = 0; v < number; ++v)
  {
    cloud.points[v][1] -= 1000;
  }
  this->Write("in.ply", cloud);
  const Outcome two = this->Build({ "in.ply", "-o", "m.kds", "--precision", "8" });
  EXPECT_NE(two.err.find("bits; use more bits"), std::string::npos) << two.err;
}

TEST_F(BuildProgram, WarnsOfColorsThatAreNotShown)
{
  struct Case
  {
    AttributeType type;
    AttributeAssociation association;
    std::string warning;
  };
  const Case cases[] = { { AttributeType::UInt16, AttributeAssociation::Point,
                           "RGB of type uint16 are taken for colours, of which 1 is white" },
    { AttributeType::UInt8, AttributeAssociation::Cell, "triangle colours are kept" },
    { AttributeType::UInt8, AttributeAssociation::Point, "" } };
  for (const Case& it : cases)
  {
    Mesh mesh = Torus(40, 20);
    Attribute colors;
    colors.name = "RGB";
    colors.type = it.type;
    colors.components = 3;
    colors.association = it.association;
    colors.values.resize(
      colors.TupleSize() *
      (it.association == AttributeAssociation::Point ? mesh.points.size() : mesh.triangles.size()));
    mesh.attributes.push_back(colors);
    this->Write("in.ply", mesh);
    const Outcome outcome = this->Build({ "in.ply", "-o", "m.kds", "--quiet" });
    EXPECT_EQ(outcome.exitCode, 0);
    EXPECT_EQ(outcome.err.empty(), it.warning.empty()) << outcome.err;
    EXPECT_NE(outcome.err.find(it.warning), std::string::npos) << outcome.err;
  }
}

TEST_F(BuildProgram, NeverOverwritesItsInput)
{
  this->Write("in.ply", Torus(40, 20));
  const std::string input = ReadWhole(this->Folder / "in.ply");
  std::filesystem::create_symlink("in.ply", this->Folder / "link.ply");
  for (const char* output : { "in.ply", "./in.ply", "link.ply" })
  {
    this->ExpectError(this->Build({ "in.ply", "-o", output }), 2,
      std::string("kdstream-build: error: ") + output + ": ");
    EXPECT_EQ(this->Build({ "in.ply", "-o", "m.kds", "--stats", output }).exitCode, 2);
  }
  EXPECT_EQ(ReadWhole(this->Folder / "in.ply"), input);
  // The statistics would overwrite a store that does not exist yet.
  this->ExpectError(this->Build({ "in.ply", "-o", "m.kds", "--stats", "./m.kds" }), 2,
    "kdstream-build: error: ./m.kds: ");
  EXPECT_FALSE(std::filesystem::exists(this->Folder / "m.kds"));
  // A store with the name of a mesh.
  ASSERT_EQ(this->Build({ "in.ply", "-o", "m.ply" }).exitCode, 0);
  const std::string store = ReadWhole(this->Folder / "m.ply");
  EXPECT_EQ(this->Store({ "extract", "m.ply", "--all", "-o", "m.ply" }).exitCode, 2);
  EXPECT_TRUE(ReadWhole(this->Folder / "m.ply") == store);
}

TEST_F(BuildProgram, RefusesOutputsThatAreNotFiles)
{
  this->Write("in.ply", Torus(40, 20));
  std::filesystem::create_directory(this->Folder / "folder");
  ASSERT_EQ(::mkfifo((this->Folder / "pipe").c_str(), 0600), 0);
  this->ExpectError(
    this->Build({ "in.ply", "-o", "folder" }), 1, "kdstream-build: error: folder: ");
  this->ExpectError(this->Build({ "in.ply", "-o", "pipe" }), 1, "kdstream-build: error: pipe: ");
  EXPECT_TRUE(std::filesystem::is_fifo(this->Folder / "pipe"));
  // A link is followed, not replaced. Statistics may go to a stream.
  std::filesystem::create_symlink("target.kds", this->Folder / "link.kds");
  const Outcome built = this->Build({ "in.ply", "-o", "link.kds", "--stats", "/dev/stdout" });
  EXPECT_EQ(built.exitCode, 0) << built.err;
  EXPECT_TRUE(Json::parse(built.out).contains("digest"));
  EXPECT_TRUE(std::filesystem::is_symlink(this->Folder / "link.kds"));
  EXPECT_EQ(this->Store({ "verify", "target.kds" }).exitCode, 0);
}

TEST_F(BuildProgram, TextsMustBeShowable)
{
  this->Write("in.ply", Torus(40, 20));
  for (const std::string& title :
    { std::string(4097, 'x'), std::string("a\x1B[31mb"), std::string("\xFF\xFE") })
  {
    EXPECT_EQ(this->Build({ "in.ply", "-o", "m.kds", "--title", title }).exitCode, 2);
  }
  EXPECT_EQ(this->Build({ "in.ply", "-o", "m.kds", "--title", "Ångström" }).exitCode, 0);
}

TEST_F(BuildProgram, AnInterruptLeavesNoFiles)
{
  this->Write("in.ply", DisplacedSphere(8));
  const std::string program = std::string(KDSTREAM_PROGRAMS) + "/kdstream-build";
  unsigned interrupted = 0, said = 0;
  for (unsigned milliseconds = 2; milliseconds < 500; milliseconds = milliseconds * 3 / 2 + 1)
  {
    const pid_t child = ::fork();
    if (child == 0)
    {
      const bool ready =
        ::chdir(this->Folder.Path.c_str()) == 0 && std::freopen("said", "w", stderr);
      if (ready)
      {
        ::execl(program.c_str(), program.c_str(), "in.ply", "-o", "m.kds", "--quiet", nullptr);
      }
      ::_exit(127);
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(milliseconds));
    ::kill(child, SIGINT);
    int status = 0;
    ::waitpid(child, &status, 0);
    if (WIFEXITED(status) && WEXITSTATUS(status) != 0)
    {
      EXPECT_EQ(WEXITSTATUS(status), 1);
      EXPECT_EQ(ReadWhole(this->Folder / "said"),
        "kdstream-build: error: interrupted: m.kds is not written\n");
      ++said;
    }
    std::filesystem::remove(this->Folder / "said");
    std::set<std::string> files = this->Files();
    if (files.contains("m.kds"))
    {
      EXPECT_EQ(this->Store({ "verify", "m.kds" }).exitCode, 0) << "a store that is there is whole";
      std::filesystem::remove(this->Folder / "m.kds");
      files.erase("m.kds");
    }
    else
    {
      ++interrupted;
    }
    EXPECT_EQ(files, (std::set<std::string>{ "in.ply" })) << "after " << milliseconds << " ms";
  }
  EXPECT_GT(interrupted, 0U);
  EXPECT_GT(said, 0U);
}
