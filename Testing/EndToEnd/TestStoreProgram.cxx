// SPDX-License-Identifier: BSD-3-Clause
// kdstream-store as doc/cli.md describes it: its output, its messages and its exit codes.
#include "Testing/EndToEnd/ProgramsTest.h"
#include "Testing/Fixtures/Invariants.h"
#include "Testing/Fixtures/Meshes.h"

#include <nlohmann/json.hpp>

#include <random>

using namespace kdstream;
using namespace kdstream::fixtures;
using Json = nlohmann::json;

namespace
{

class StoreProgram : public ProgramsTest
{
};

bool HasTool(const std::string& name)
{
  return std::filesystem::exists(std::string(KDSTREAM_PROGRAMS "/kdstream-") + name);
}

}

TEST_F(StoreProgram, HelpAndVersion)
{
  const Outcome help = this->Store({ "--help" });
  EXPECT_EQ(help.exitCode, 0);
  EXPECT_NE(help.out.find("Example"), std::string::npos);
  EXPECT_EQ(this->Store({ "--version" }).out, "kdstream-store 0.9.0\n");
  // A command that does not exist has no help; in particular, the program's help is not shown
  // instead.
  for (const std::vector<std::string>& arguments :
    { std::vector<std::string>{ "publish", "--help" }, { "-h", "publish" }, { "publish" } })
  {
    this->ExpectError(this->Store(arguments), 2,
      "kdstream-store: error: there is no command \"publish\"; use info, verify, "
      "extract, distance, edit or export (see --help)");
  }
  const std::string edit = this->Store({ "edit", "--help" }).out;
  EXPECT_EQ(edit.find("SIGHUP"), std::string::npos) << "a server sees it by itself";
  EXPECT_NE(edit.find("server shows the new texts"), std::string::npos) << edit;
  EXPECT_EQ(edit.find("--licence"), std::string::npos) << edit;
  EXPECT_NE(edit.find("--license TEXT"), std::string::npos) << edit;
}

TEST_F(StoreProgram, WrongUsageExitsWith2)
{
  this->Write("in.ply", Torus(40, 20));
  ASSERT_EQ(this->Build({ "in.ply", "-o", "m.kds" }).exitCode, 0);
  const std::vector<std::vector<std::string>> wrong{ {}, { "info" },
    { "extract", "m.kds", "-o", "x.ply" }, { "extract", "m.kds", "--level", "3" },
    { "extract", "m.kds", "--level", "3", "--all", "-o", "x.ply" },
    { "extract", "m.kds", "--level", "99", "-o", "x.ply" },
    { "extract", "m.kds", "--partition", "1", "-o", "x.ply" },
    { "extract", "m.kds", "--region", "0", "-o", "x.ply" },
    { "extract", "m.kds", "--region", "2", "-o", "x.ply" },
    { "extract", "m.kds", "--in-context", "3", "--all", "-o", "x.ply" }, { "distance", "m.kds" } };
  for (const auto& arguments : wrong)
  {
    const Outcome outcome = this->Store(arguments);
    EXPECT_EQ(outcome.exitCode, 2) << (arguments.empty() ? "" : arguments.back()) << outcome.err;
    EXPECT_EQ(outcome.err.rfind("kdstream-store: error: ", 0), 0U) << outcome.err;
  }
  EXPECT_EQ(this->Files(), (std::set<std::string>{ "in.ply", "m.kds" }));
}

TEST_F(StoreProgram, DistanceOfALevel)
{
  this->Write("in.ply", Torus(60, 30));
  ASSERT_EQ(this->Build({ "in.ply", "-o", "m.kds", "--precision", "lossless" }).exitCode, 0);
  const auto distance = [&](const std::string& level, const std::string& against)
  {
    const Outcome outcome =
      this->Store({ "distance", "m.kds", "--level", level, "--against", against, "--json" });
    EXPECT_EQ(outcome.exitCode, 0) << outcome.err;
    return Json::parse(outcome.out);
  };
  // The distance of a level from itself is 0, in a file of any format.
  for (const std::string file : { "level.ply", "level.vtp" })
  {
    SCOPED_TRACE(file);
    if (file == "level.vtp" && !HasTool("convert"))
    {
      continue; // built without VTK
    }
    ASSERT_EQ(this->Store({ "extract", "m.kds", "--level", "7", "-o", file }).exitCode, 0);
    const Json same = distance("7", file);
    EXPECT_LT(same["rms_forward"], 1e-9);
    EXPECT_LT(same["rms_backward"], 1e-9);
    EXPECT_LT(same["hausdorff"], 1e-9);
  }
  // Coarser levels are farther away, in both directions, but never farther than the largest
  // distance.
  Json finer = distance("9", "in.ply");
  for (const std::string level : { "7", "5" })
  {
    const Json coarser = distance(level, "in.ply");
    EXPECT_GT(coarser["rms_forward"], finer["rms_forward"]);
    EXPECT_GT(coarser["rms_backward"], finer["rms_backward"]);
    EXPECT_GT(coarser["hausdorff"], coarser["rms_forward"]);
    EXPECT_EQ(coarser["diagonal"], finer["diagonal"]);
    finer = coarser;
  }
  const Outcome text = this->Store({ "distance", "m.kds", "--level", "5", "--against", "in.ply" });
  EXPECT_NE(text.out.find("% of the diagonal"), std::string::npos) << text.out;
  this->ExpectError(
    this->Store({ "distance", "m.kds", "--level", "5", "--against", "nothing.ply" }), 1,
    "kdstream-store: error: nothing.ply: ");
  this->ExpectError(this->Store({ "distance", "m.kds", "--level", "99", "--against", "in.ply" }), 2,
    "kdstream-store: error: m.kds: --level");
}

TEST_F(StoreProgram, DistanceOfPointsSaysWhatIsMeasured)
{
  const Mesh torus = Torus(60, 30);
  Mesh cloud = torus;
  cloud.triangles.clear();
  this->Write("in.ply", torus);
  this->Write("cloud.ply", cloud);
  ASSERT_EQ(this->Build({ "in.ply", "-o", "m.kds", "--precision", "lossless" }).exitCode, 0);
  ASSERT_EQ(this->Build({ "cloud.ply", "-o", "c.kds", "--precision", "lossless" }).exitCode, 0);
  const auto said = [&](const std::string& store, const std::string& against)
  {
    const Outcome outcome =
      this->Store({ "distance", store, "--level", "5", "--against", against, "--quiet" });
    EXPECT_EQ(outcome.exitCode, 0) << outcome.err;
    return outcome.err;
  };
  const std::string points =
    " has no triangles: distances are measured from its points and to its nearest point\n";
  EXPECT_EQ(said("m.kds", "cloud.ply"), "kdstream-store: warning: cloud.ply:" + points);
  EXPECT_EQ(said("c.kds", "in.ply"), "kdstream-store: warning: c.kds: level 5" + points);
  EXPECT_EQ(said("c.kds", "cloud.ply"), "kdstream-store: warning: cloud.ply:" + points +
                                          "kdstream-store: warning: c.kds: level 5" + points);
  EXPECT_EQ(said("m.kds", "in.ply"), "");
  this->ExpectError(this->Store({ "distance", "m.kds", "--level", "5" }), 2,
    "kdstream-store: error: --against is required (see --help)");
}

TEST_F(StoreProgram, StlOfPointsIsRefused)
{
  Mesh cloud = Torus(40, 20);
  cloud.triangles.clear();
  this->Write("in.ply", cloud);
  ASSERT_EQ(this->Build({ "in.ply", "-o", "m.kds" }).exitCode, 0);
  this->ExpectError(this->Store({ "extract", "m.kds", "--all", "-o", "out/x.stl" }), 2,
    "kdstream-store: error: out/x.stl: ");
  EXPECT_EQ(this->Files(), (std::set<std::string>{ "in.ply", "m.kds" }));
}

TEST_F(StoreProgram, OutputsAreNamedAsTheyCanBe)
{
  this->Write("in.ply", Torus(40, 20));
  ASSERT_EQ(this->Build({ "in.ply", "-o", "m.kds", "--quiet" }).exitCode, 0);
  this->ExpectError(this->Store({ "extract", "m.kds", "--all", "-o", "x.xyz" }), 2,
    "kdstream-store: error: x.xyz: the ending '.xyz' names no format that can be written (.ply, "
    ".vtp, .stl, .obj, .wrl, .glb)");
  for (const std::string format : { "files", "3dtiles" })
  {
    this->ExpectError(this->Store({ "export", "m.kds", "x.glb", "--format", format }), 2,
      "kdstream-store: error: x.glb: ends in .glb, but --format " + format +
        " makes a folder: use --format glb");
  }
  const Outcome plain = this->Store({ "extract", "m.kds", "--all", "-o", "x.glb" });
  EXPECT_EQ(plain.exitCode, 0);
  EXPECT_NE(plain.err.find("wrote x.glb: 1600 triangles, "), std::string::npos) << plain.err;
  Mesh point;
  point.points = { { 1, 2, 3 } };
  this->Write("one.ply", point);
  ASSERT_EQ(this->Build({ "one.ply", "-o", "one.kds", "--quiet" }).exitCode, 0);
  const Outcome one = this->Store({ "extract", "one.kds", "--all", "-o", "x.ply" });
  EXPECT_NE(one.err.find("wrote x.ply: 1 point, "), std::string::npos) << one.err;
}

TEST_F(StoreProgram, VrmlSaysWhatItLoses)
{
  Mesh mesh = Torus(40, 20);
  mesh.scalarType = ScalarType::Float64;
  for (const double offset : { 0., 432000. })
  {
    for (Vec3& point : mesh.points)
    {
      point[0] += offset;
    }
    this->Write("in.ply", mesh);
    ASSERT_EQ(this->Build({ "in.ply", "-o", "m.kds", "--quiet" }).exitCode, 0);
    const Outcome written = this->Store({ "extract", "m.kds", "--all", "-o", "x.wrl", "--quiet" });
    EXPECT_EQ(written.exitCode, 0);
    EXPECT_EQ(written.err.find("VRML has floats") != std::string::npos, offset > 0) << written.err;
  }
}

TEST_F(StoreProgram, StlSaysWhatItLoses)
{
  Mesh doubles = Torus(40, 20);
  doubles.scalarType = ScalarType::Float64;
  this->Write("in.ply", doubles);
  ASSERT_EQ(this->Build({ "in.ply", "-o", "m.kds" }).exitCode, 0);
  EXPECT_EQ(this->Store({ "extract", "m.kds", "--all", "-o", "x.stl", "--quiet" }).err,
    "kdstream-store: warning: x.stl: STL holds floats; the coordinates were doubles and are "
    "rounded\n");
}

TEST_F(StoreProgram, DamageIsNamedByVerify)
{
  this->Write("in.ply", Torus(96, 48));
  ASSERT_EQ(
    this->Build({ "in.ply", "-o", "m.kds", "--vertices-per-partition", "200" }).exitCode, 0);
  EXPECT_EQ(this->Store({ "verify", "m.kds" }).exitCode, 0);
  const std::string whole = ReadWhole(this->Folder / "m.kds");
  // The blob of the last partition: partitions come last in the file.
  std::string damaged = whole;
  const std::size_t blob = whole.rfind("KDP\x08");
  ASSERT_NE(blob, std::string::npos);
  damaged[blob + 200] ^= 1;
  std::ofstream(this->Folder / "d.kds", std::ios::binary) << damaged;
  const Outcome verify = this->Store({ "verify", "d.kds" });
  EXPECT_EQ(verify.exitCode, 1);
  EXPECT_NE(verify.err.find("kdstream-store: error: d.kds: partitions/"), std::string::npos)
    << verify.err;
  EXPECT_EQ(this->Store({ "extract", "d.kds", "--all", "-o", "x.ply" }).exitCode, 1);
  EXPECT_EQ(this->Store({ "extract", "d.kds", "--level", "5", "-o", "x.ply" }).exitCode, 0)
    << "the rest is whole";
  this->ExpectError(this->Store({ "info", "in.ply" }), 1, "kdstream-store: error: in.ply: ");
  this->ExpectError(
    this->Store({ "info", "nothing.kds" }), 1, "kdstream-store: error: nothing.kds: ");
}

TEST_F(StoreProgram, ExtractsWhatIsAskedFor)
{
  this->Write("in.ply", Torus(96, 48));
  ASSERT_EQ(
    this->Build({ "in.ply", "-o", "m.kds", "--vertices-per-partition", "200", "--stats", "s.json" })
      .exitCode,
    0);
  const Json stats = Json::parse(ReadWhole(this->Folder / "s.json"));
  const unsigned stitch = stats["stitch_depth"], partitions = stats["partitions"];
  const auto extract = [&](std::vector<std::string> arguments)
  {
    arguments.insert(arguments.begin(), { "extract", "m.kds", "-o", "x.ply" });
    const Outcome outcome = this->Store(arguments);
    EXPECT_EQ(outcome.exitCode, 0) << outcome.err;
    return this->Read("x.ply");
  };
  for (unsigned d = 0; d < stats["levels"].size(); ++d)
  {
    const Mesh level = extract({ "--level", std::to_string(d) });
    EXPECT_EQ(level.points.size(), stats["levels"][d]["vertices"]);
    EXPECT_EQ(level.triangles.size(), stats["levels"][d]["triangles"]);
  }
  const Mesh partition = extract({ "--partition", "3" });
  EXPECT_GT(partition.points.size(), stats["partition_vertices"]["min"].get<std::size_t>());
  const Mesh near = extract({ "--region", "20", "--rings", "1" });
  const Mesh wide = extract({ "--region", "20", "--rings", "2" });
  EXPECT_GT(near.triangles.size(), partition.triangles.size());
  EXPECT_GT(wide.triangles.size(), near.triangles.size());
  for (const unsigned d : { 3U, stitch })
  {
    const Mesh context =
      extract({ "--region", "20", "--rings", "1", "--in-context", std::to_string(d) });
    EXPECT_TRUE(BoundaryEdges(context.triangles).empty()) << "in context of level " << d;
    EXPECT_LT(context.triangles.size(), stats["triangles"].get<std::size_t>());
  }
  std::mt19937 random(8);
  for (unsigned draw = 0; draw < 10; ++draw)
  {
    Json mix = Json::array();
    for (unsigned p = 0; p < partitions; ++p)
    {
      const auto depth =
        static_cast<unsigned>(stitch + random() % (stats["levels"].size() - stitch + 1));
      mix.push_back(depth < stats["levels"].size() ? Json(depth) : Json("original"));
    }
    this->WriteText("mix.json", mix.dump());
    EXPECT_TRUE(BoundaryEdges(extract({ "--resolutions", "mix.json" }).triangles).empty());
  }
  // Pieces in any order, over a base. Pieces that cannot be reached are not shown.
  const unsigned first = 1U << stats["partition_depth"].get<unsigned>();
  const Json pieces = { { "base", 2 },
    { "pieces",
      Json::array({ Json::array({ "original", first + 3 }), Json::array({ stitch, 1 }) }) } };
  this->WriteText("mix.json", pieces.dump());
  const Mesh mixed = extract({ "--resolutions", "mix.json" });
  EXPECT_TRUE(BoundaryEdges(mixed.triangles).empty());
  EXPECT_GT(mixed.points.size(), stats["levels"][stitch]["vertices"].get<std::size_t>());
  for (const auto& [text, said] : std::initializer_list<std::pair<std::string, std::string>>{
         { "{}", " must have \"base\" and a list \"pieces\"" },
         { R"({"base":99,"pieces":[]})", ": \"base\" is \"99\"; it must be a depth from 0 to " },
         { R"({"base":3,"pieces":[[3]]})",
           ": piece 0 does not name the resolution and node of a piece in the store" },
         { R"({"base":3,"pieces":[[3,1],["original",1]]})",
           ": piece 1 does not name the resolution and node of a piece in the store" },
         { "7", " is not a JSON list or object" } })
  {
    this->WriteText("mix.json", text);
    const Outcome bad =
      this->Store({ "extract", "m.kds", "--resolutions", "mix.json", "-o", "x.ply" });
    EXPECT_EQ(bad.exitCode, 2);
    EXPECT_NE(bad.err.find("--resolutions: mix.json" + said), std::string::npos) << bad.err;
  }
  const Outcome unread =
    this->Store({ "extract", "m.kds", "--resolutions", "no.json", "-o", "x.ply" });
  EXPECT_EQ(unread.exitCode, 1);
  EXPECT_EQ(
    unread.err, "kdstream-store: error: no.json: cannot be read: No such file or directory\n");
  this->WriteText("mix.json", "[\"original\"]");
  EXPECT_EQ(this->Store({ "extract", "m.kds", "--resolutions", "mix.json", "-o", "x.ply" }).err,
    "kdstream-store: error: m.kds: --resolutions: mix.json has 1 entries for " +
      std::to_string(partitions) + " partitions\n");
  this->WriteText("mix.json", "[\"fine\"]");
  EXPECT_EQ(
    this->Store({ "extract", "m.kds", "--resolutions", "mix.json", "-o", "x.ply" }).exitCode, 2);
  for (const char* name : { "x.vtp", "x.stl", "x.obj", "x.wrl" })
  {
    EXPECT_EQ(this->Store({ "extract", "m.kds", "--level", "5", "-o", name }).exitCode, 0) << name;
    EXPECT_GT(std::filesystem::file_size(this->Folder / name), 100U);
  }
}
