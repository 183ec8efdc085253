// SPDX-License-Identifier: BSD-3-Clause
// kdstream-build with formats that kdstream-convert reads for it, and with point clouds.
#include "Testing/EndToEnd/ConvertTools.h"
#include "Testing/Fixtures/Meshes.h"
#include "filters/core/MeshDistance.h"

#include <nlohmann/json.hpp>

#include <chrono>
#include <csignal>
#include <sstream>
#include <thread>

using namespace kdstream;
using namespace kdstream::fixtures;
using Json = nlohmann::json;

namespace
{

class TestForeignInput : public ConvertTest
{
protected:
  Json Stats() { return Json::parse(ReadWhole(this->Folder / "s.json")); }

  std::string CloudText(const Mesh& cloud)
  {
    std::string text;
    for (const Vec3& p : cloud.points)
    {
      char line[100];
      std::snprintf(line, sizeof(line), "%.9g %.9g %.9g\n", p[0], p[1], p[2]);
      text += line;
    }
    return text;
  }
};

}

TEST_F(TestForeignInput, StoresAreThoseOfThePly)
{
  const Mesh mesh = AsFloats(Shuffled(DisplacedSphere(5), 3));
  std::string digest;
  for (const char* file : { "in.ply", "in.vtp", "in.obj", "in.wrl" })
  {
    ASSERT_TRUE(WriteMesh(this->Folder / file, mesh));
    if (!hasVrml && std::string(file) == "in.wrl")
    {
      continue;
    }
    const Outcome built = this->Build({ file, "-o", "m.kds", "--stats", "s.json", "--quiet" });
    ASSERT_EQ(built.exitCode, 0) << built.err;
    EXPECT_EQ(built.out + built.err, "");
    const Json stats = this->Stats();
    EXPECT_EQ(stats["input"], file);
    EXPECT_EQ(stats["triangles"], mesh.triangles.size());
    const std::string ending = std::filesystem::path(file).extension();
    EXPECT_EQ(stats["seconds"].contains("convert"), ending == ".vtp" || ending == ".wrl") << file;
    digest = digest.empty() ? stats["digest"].get<std::string>() : digest;
    EXPECT_EQ(stats["digest"], digest) << file;
    const Json info =
      Json::parse(RunTool(this->Folder, "store", { "info", "m.kds", "--json" }).out);
    EXPECT_EQ(info["input"], file) << "the store must name the file that the user named";
  }
  ASSERT_TRUE(WriteMesh(this->Folder / "in.stl", mesh));
  for (const char* weld : { "on", "off" })
  {
    ASSERT_EQ(
      this->Build({ "in.stl", "-o", "m.kds", "--stats", "s.json", "--weld", weld }).exitCode, 0);
    EXPECT_EQ(this->Stats()["vertices"], mesh.points.size()) << "STL is always welded";
  }
  EXPECT_EQ(this->Files(),
    (std::set<std::string>{ "in.ply", "in.vtp", "in.obj", "in.wrl", "in.stl", "m.kds", "s.json" }))
    << "nothing else is left";
}

TEST_F(TestForeignInput, ErrorsNameTheInputAndLeaveNothing)
{
  this->WriteText("bad.obj", "v 1 2 3\nf 1 2 3\n");
  const Outcome badObj = this->Build({ "bad.obj", "-o", "m.kds" });
  EXPECT_EQ(badObj.exitCode, 1);
  EXPECT_EQ(badObj.err,
    "kdstream-build: error: bad.obj: face 0 (line 2) names vertex 2, but there is only 1: correct "
    "the file, or export it again\n");
  this->WriteText("bad.xyz", "1 2 3\n4 5\n");
  const Outcome bad = this->Build({ "bad.xyz", "-o", "m.kds" });
  EXPECT_EQ(bad.exitCode, 1);
  EXPECT_EQ(bad.err,
    "kdstream-build: error: bad.xyz: line 2: has 2 columns; those before have 3: correct the file, "
    "or export it again\n");
  const Outcome missing = this->Build({ "missing.vtp", "-o", "m.kds" });
  EXPECT_EQ(missing.exitCode, 1);
  EXPECT_EQ(missing.err.rfind("kdstream-build: error: missing.vtp: no such file", 0), 0U)
    << missing.err;
  EXPECT_EQ(this->Files(), (std::set<std::string>{ "bad.obj", "bad.xyz" }));
}

TEST_F(TestForeignInput, WarningsArePassedOn)
{
  this->WriteText("in.obj", "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  const Outcome built = this->Build({ "in.obj", "-o", "m.kds", "--quiet" });
  EXPECT_EQ(built.exitCode, 0);
  EXPECT_EQ(built.err, "kdstream-build: warning: in.obj: line 1: the materials 'a.mtl' are not "
                       "there: they are drawn white\n");
  this->WriteText("in.xyz", "0 0 0\n1 0 0\nnan 1 0\n");
  EXPECT_EQ(this->Build({ "in.xyz", "-o", "m.kds", "--quiet" }).err,
    "kdstream-build: warning: in.xyz: 1 point is not finite and is dropped: line 3\n");
}

TEST_F(TestForeignInput, NamesAreNeverOptions)
{
  const Mesh mesh = AsFloats(Torus(20, 10));
  std::filesystem::create_directory(this->Folder / "-folder with blanks");
  for (const char* name : { "-o.vtp", "--reconstruct.vtp", "a b;c'\"$(x).vtp",
         "-folder with "
         "blanks/in.vtp" })
  {
    ASSERT_TRUE(WriteMesh(this->Folder / name, mesh));
    const Outcome built = this->Build({ "-o", "./-folder with blanks/m.kds", "--", name });
    EXPECT_EQ(built.exitCode, 0) << name << ": " << built.err;
  }
}

TEST_F(TestForeignInput, WithoutKdstreamConvert)
{
  std::filesystem::copy(std::string(KDSTREAM_PROGRAMS) + "/kdstream-build", this->Folder / "build");
  const std::string there = "kdstream-convert, which is not at " +
                            std::filesystem::canonical(this->Folder.Path).string() +
                            "/kdstream-convert";
  const auto expect = [&](const std::vector<std::string>& arguments, const std::string& said)
  {
    const Outcome built = RunProgram(this->Folder, this->Folder / "build", arguments);
    EXPECT_EQ(built.exitCode, 1);
    EXPECT_EQ(built.err.rfind("kdstream-build: error: " + said + there + ": build it", 0), 0U)
      << built.err;
  };
  this->WriteText("in.xyz", "0 0 0\n");
  expect({ "in.xyz", "-o", "m.kds" }, "in.xyz: reading this format needs ");
  // A file in a format that kdstream-build reads itself is not refused in this way.
  Mesh mesh = Torus(40, 20);
  ASSERT_TRUE(WriteMesh(this->Folder / "mesh.ply", mesh));
  mesh.triangles.clear();
  ASSERT_TRUE(WriteMesh(this->Folder / "cloud.ply", mesh));
  for (const char* file : { "mesh.ply", "cloud.ply" })
  {
    expect({ file, "-o", "m.kds", "--reconstruct", "greedy" },
      file + std::string(": --reconstruct needs "));
  }
  EXPECT_EQ(this->Files(), (std::set<std::string>{ "build", "in.xyz", "mesh.ply", "cloud.ply" }));
}

TEST_F(TestForeignInput, WithoutKdstreamConvertPicturesAreLeftOut)
{
  std::filesystem::copy(std::string(KDSTREAM_PROGRAMS) + "/kdstream-build", this->Folder / "build");
  this->WriteText("in.mtl", "newmtl a\nmap_Kd a.png\n");
  this->WriteText("in.obj", "mtllib in.mtl\nusemtl a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  const Outcome built =
    RunProgram(this->Folder, this->Folder / "build", { "in.obj", "-o", "m.kds", "--quiet" });
  EXPECT_EQ(built.exitCode, 0);
  EXPECT_EQ(built.err.substr(0, built.err.find('\n')),
    "kdstream-build: warning: in.obj: its pictures are left out: reading them needs "
    "kdstream-convert, which is not at " +
      std::filesystem::canonical(this->Folder.Path).string() +
      "/kdstream-convert: build it (cmake --build build/release --target kdstream-convert; it "
      "needs VTK)");
}

// `./dev run MESH` builds kdstream-convert if the mesh needs it.
TEST_F(TestForeignInput, TheScriptBuildsTheConverterForTexturedMeshes)
{
  const std::string script = ReadWhole(KDSTREAM_SCRIPT);
  const std::size_t begin = script.find("\nconverter() {"), end = script.find("\n}\n", begin);
  ASSERT_NE(end, std::string::npos);
  this->WriteText("converter.sh",
    "set -euo pipefail\n" + script.substr(begin, end + 3 - begin) + "converter \"$1\"\n");
  const auto needsConverter = [&](const std::string& mesh)
  {
    const Outcome outcome = RunProgram(this->Folder, "/bin/bash", { "converter.sh", mesh });
    EXPECT_EQ(outcome.exitCode, 0) << outcome.err;
    return outcome.out == "kdstream-convert\n";
  };
  const std::string large(1 << 20, 'x'); // more than a pipe holds
  this->WriteText("plain.obj", "v 0 0 0\n");
  this->WriteText("a painted.OBJ", "# of a scan\nmtllib a.mtl\n" + large);
  this->WriteText("plain.ply", "ply\nformat ascii 1.0\nend_header\n" + large);
  this->WriteText("painted.ply", "ply\nformat ascii 1.0\ncomment TextureFile a.png\n" + large);
  for (const char* mesh : { "", "plain.obj", "plain.ply", "mesh.stl", "mesh.STL" })
  {
    EXPECT_FALSE(needsConverter(mesh)) << mesh;
  }
  for (const char* mesh : { "a painted.OBJ", "painted.ply", "mesh.glb", "cloud.xyz" })
  {
    EXPECT_TRUE(needsConverter(mesh)) << mesh;
  }
}

TEST_F(TestForeignInput, AnInterruptLeavesNothing)
{
  Mesh cloud = DisplacedSphere(8);
  cloud.triangles.clear();
  this->WriteText("in.xyz", this->CloudText(cloud));
  const std::string program = std::string(KDSTREAM_PROGRAMS) + "/kdstream-build";
  for (const int signal : { SIGINT, SIGTERM })
  {
    unsigned interrupted = 0;
    for (unsigned milliseconds = 5; milliseconds < 1500; milliseconds = milliseconds * 2)
    {
      const pid_t child = ::fork();
      if (child == 0)
      {
        const bool ready =
          ::chdir(this->Folder.Path.c_str()) == 0 && std::freopen("/dev/null", "w", stderr);
        if (ready)
        {
          ::execl(program.c_str(), program.c_str(), "in.xyz", "-o", "m.kds", nullptr);
        }
        ::_exit(127);
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(milliseconds));
      ::kill(child, signal);
      int status = 0;
      ::waitpid(child, &status, 0);
      interrupted += std::filesystem::remove(this->Folder / "m.kds") ? 0 : 1;
      // If the signal came before the program catches signals, nothing has been made yet.
      EXPECT_EQ(this->Files(), (std::set<std::string>{ "in.xyz" }))
        << "after " << milliseconds << " ms";
    }
    EXPECT_GT(interrupted, 0U);
  }
}

TEST_F(TestForeignInput, CloudsAreStoresOfPoints)
{
  Mesh cloud = AsFloats(Cloud(5));
  ASSERT_TRUE(WriteMesh(this->Folder / "in.ply", cloud));
  this->WriteText("in.xyz", this->CloudText(cloud));
  this->WriteText("in.pcd",
    "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH " +
      std::to_string(cloud.points.size()) + "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " +
      std::to_string(cloud.points.size()) + "\nDATA ascii\n" + this->CloudText(cloud));
  for (const char* file : { "in.ply", "in.xyz", "in.pcd" })
  {
    SCOPED_TRACE(file);
    if (std::string(file) == "in.pcd" &&
        this->Convert(file).err.find("needs PCL") != std::string::npos)
    {
      continue;
    }
    const Outcome built = this->Build({ file, "-o", "m.kds", "--precision", "lossless",
      "--vertices-per-partition", "150", "--stats", "s.json" });
    ASSERT_EQ(built.exitCode, 0) << built.err;
    const Json stats = this->Stats();
    EXPECT_EQ(stats["primitive"], "points");
    EXPECT_EQ(stats["vertices"], cloud.points.size());
    EXPECT_EQ(stats["triangles"], 0);
    EXPECT_LE(
      stats["partition_vertices"]["max"].get<int>() - stats["partition_vertices"]["min"].get<int>(),
      1);
    EXPECT_GE(stats["levels"].size(), 10U);
    const std::size_t finest = stats["levels"].size() - 1;
    for (const std::size_t d : { std::size_t{ 4 }, finest })
    {
      const Json& level = stats["levels"][d];
      EXPECT_GT(level["vertices"], std::size_t{ 1 } << (d - 1));
      EXPECT_LE(level["vertices"], cloud.points.size());
    }
    ASSERT_EQ(
      RunTool(this->Folder, "store", { "extract", "m.kds", "--all", "-o", "all.ply" }).exitCode, 0);
    EXPECT_EQ(PointMultiset(this->Read("all.ply")), PointMultiset(cloud));
  }
}

TEST_F(TestForeignInput, ReconstructedCloudsAreSurfaces)
{
  Mesh mesh = AsFloats(DisplacedSphere(4));
  Mesh cloud = mesh;
  cloud.triangles.clear();
  ASSERT_TRUE(WriteMesh(this->Folder / "mesh.ply", mesh));
  ASSERT_TRUE(WriteMesh(this->Folder / "cloud.ply", cloud));
  this->WriteText("cloud.xyz", this->CloudText(cloud));
  for (const char* method : { "greedy", "poisson" })
  {
    for (const char* file : { "cloud.ply", "cloud.xyz" })
    {
      SCOPED_TRACE(std::string(file) + " " + method);
      const Outcome built =
        this->Build({ file, "-o", "m.kds", "--reconstruct", method, "--stats", "s.json" });
      if (built.err.find("needs PCL") != std::string::npos)
      {
        EXPECT_EQ(built.exitCode, 1);
        GTEST_SKIP() << "built without PCL";
      }
      ASSERT_EQ(built.exitCode, 0) << built.err;
      const Json stats = this->Stats();
      EXPECT_EQ(stats["primitive"], "triangles");
      EXPECT_EQ(stats["input"], file);
      EXPECT_GT(stats["triangles"], mesh.triangles.size() * 3 / 4);
      if (std::string(method) == "greedy")
      {
        const std::size_t unused =
          stats.contains("unused") ? stats["unused"]["vertices"].get<std::size_t>() : 0;
        EXPECT_EQ(stats["vertices"].get<std::size_t>() + unused, mesh.points.size())
          << "greedy keeps the points";
      }
    }
  }
  EXPECT_EQ(this->Build({ "mesh.ply", "-o", "m.kds", "--reconstruct", "greedy" }).err,
    "kdstream-build: error: mesh.ply: has " + std::to_string(mesh.triangles.size()) +
      " triangles; --reconstruct is for point clouds\n");
  this->WriteText("line.xyz", "0 0 0\n1 1 1\n2 2 2\n3 3 3\n");
  EXPECT_EQ(this->Build({ "line.xyz", "-o", "m.kds", "--reconstruct", "poisson" }).err,
    "kdstream-build: error: line.xyz: all points lie on one line: there is no surface\n");
}

// PCL reports no progress while it makes the surface. No fraction is shown then, because it would
// stand still.
TEST_F(TestForeignInput, ReconstructionReportsAFractionOnlyForTheNormals)
{
  Mesh cloud = DisplacedSphere(4);
  cloud.triangles.clear();
  ASSERT_TRUE(WriteMesh(this->Folder / "cloud.ply", cloud));
  const Outcome converted = RunTool(this->Folder, "convert",
    { "cloud.ply", "-o", "out.ply", "--reconstruct", "poisson", "--progress-lines" });
  if (converted.err.find("needs PCL") != std::string::npos)
  {
    GTEST_SKIP() << "built without PCL";
  }
  ASSERT_EQ(converted.exitCode, 0) << converted.err;
  EXPECT_NE(converted.err.find(" normals\n"), std::string::npos) << converted.err;
  EXPECT_NE(converted.err.find("progress 0 surface\n"), std::string::npos) << converted.err;
  std::istringstream lines(converted.err);
  for (std::string line; std::getline(lines, line);)
  {
    EXPECT_TRUE(!line.ends_with(" surface") || line == "progress 0 surface") << line;
  }
}

TEST_F(TestForeignInput, TheDragonsPointsBecomeTheDragon)
{
  ASSERT_TRUE(std::filesystem::exists(KDSTREAM_DRAGON))
    << KDSTREAM_DRAGON << " is missing; Data/fetch-dragon fetches it";
  // The vertices of a level, about 16,000, without its triangles.
  ASSERT_EQ(this->Build({ KDSTREAM_DRAGON, "-o", "d.kds", "--quiet" }).exitCode, 0);
  ASSERT_EQ(
    RunTool(this->Folder, "store", { "extract", "d.kds", "--level", "14", "-o", "level.ply" })
      .exitCode,
    0);
  const Mesh level = this->Read("level.ply");
  Mesh cloud = level;
  cloud.triangles.clear();
  ASSERT_TRUE(WriteMesh(this->Folder / "cloud.ply", cloud));
  for (const char* method : { "greedy", "poisson" })
  {
    const Outcome converted =
      RunTool(this->Folder, "convert", { "cloud.ply", "-o", "out.ply", "--reconstruct", method });
    if (converted.err.find("needs PCL") != std::string::npos)
    {
      GTEST_SKIP() << "built without PCL";
    }
    ASSERT_EQ(converted.exitCode, 0) << converted.err;
    const Mesh surface = this->Read("out.ply");
    const std::size_t edges = surface.triangles.size() * 3 / 2;
    const std::size_t boundary = BoundaryEdges(surface.triangles).size();
    const Result<MeshDistance> distance = MeasureDistance(level, surface);
    ASSERT_TRUE(distance);
    const double percent = 100 / distance->diagonal;
    SCOPED_TRACE(std::string(method) + ": " + std::to_string(surface.triangles.size()) +
                 " triangles, " + std::to_string(boundary) + " boundary edges, RMS to " +
                 std::to_string(distance->rmsForward * percent) + " %, from " +
                 std::to_string(distance->rmsBackward * percent) + " %, Hausdorff " +
                 std::to_string(distance->hausdorff * percent) + " %");
    const bool greedy = std::string(method) == "greedy";
    EXPECT_LE(boundary, greedy ? edges / 25 : edges / 1000);
    EXPECT_LT(distance->rmsForward * percent, greedy ? 0.15 : 0.2);
    EXPECT_LT(distance->rmsBackward * percent, greedy ? 0.15 : 0.4);
    EXPECT_GT(surface.triangles.size(), level.triangles.size() * 9 / 10);
    if (greedy)
    {
      EXPECT_EQ(PointMultiset(surface), PointMultiset(cloud));
    }
  }
}
