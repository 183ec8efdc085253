// kdstream-build and kdstream-store as doc/cli.md describes them: what they write, say and
// return.
#include "Testing/EndToEnd/Process.h"
#include "Testing/Fixtures/Invariants.h"
#include "Testing/Fixtures/Meshes.h"
#include "filters/core/Weld.h"
#include "filters/meshio/MeshReader.h"
#include "filters/meshio/MeshWriter.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <malloc.h>
#include <sys/stat.h>

#include <csignal>
#include <functional>
#include <random>
#include <set>
#include <thread>

using namespace kdstream;
using namespace kdstream::fixtures;
using Json = nlohmann::json;

namespace
{

class Programs : public ::testing::Test
{
protected:
  Outcome Build(std::vector<std::string> arguments)
  {
    return RunTool(this->Folder, "build", arguments);
  }
  Outcome Store(std::vector<std::string> arguments)
  {
    return RunTool(this->Folder, "store", arguments);
  }

  void Write(const std::string& name, const Mesh& mesh)
  {
    const Status status = WriteMesh(this->Folder / name, mesh);
    ASSERT_TRUE(status) << status.GetError().message;
  }
  void WriteText(const std::string& name, const std::string& text)
  {
    std::ofstream(this->Folder / name) << text;
  }

  Mesh Read(const std::string& name)
  {
    auto reader = MeshReader::Open(this->Folder / name);
    Mesh mesh;
    EXPECT_TRUE(reader) << reader.GetError().message;
    if (reader)
    {
      mesh.scalarType = (*reader)->Info().scalarType;
      EXPECT_TRUE((*reader)->ReadVertices(mesh, ~std::size_t{ 0 }));
      EXPECT_TRUE((*reader)->ReadTriangles(mesh, ~std::size_t{ 0 }));
    }
    return mesh;
  }

  // The error line of a program that fails, whole.
  void ExpectError(const Outcome& outcome, int exitCode, const std::string& line)
  {
    EXPECT_EQ(outcome.exitCode, exitCode);
    EXPECT_EQ(outcome.err, line + "\n");
    EXPECT_EQ(outcome.out, "");
  }

  std::set<std::string> Files() const
  {
    std::set<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(this->Folder.Path))
    {
      names.insert(entry.path().filename().string());
    }
    return names;
  }

  TemporaryFolder Folder;
};

bool HasTool(const std::string& name)
{
  return std::filesystem::exists(std::string(KDSTREAM_PROGRAMS "/kdstream-") + name);
}

std::string Ply(const std::string& vertices, const std::string& faces, const std::string& body)
{
  return "ply\nformat ascii 1.0\nelement vertex " + vertices +
         "\nproperty float x\nproperty float y\nproperty float z\nelement face " + faces +
         "\nproperty list uchar int vertex_indices\nend_header\n" + body;
}

}

TEST_F(Programs, HelpAndVersion)
{
  for (const char* name : { "build", "store" })
  {
    const Outcome help = RunTool(this->Folder, name, { "--help" });
    EXPECT_EQ(help.exitCode, 0);
    EXPECT_NE(help.out.find("Example"), std::string::npos);
    EXPECT_EQ(RunTool(this->Folder, name, { "--version" }).out, "0.1.0\n");
  }
}

TEST_F(Programs, AllOfALosslessStoreIsTheInput)
{
  for (const NamedMesh& named : AllMeshes())
  {
    SCOPED_TRACE(named.name);
    this->Write("in.ply", named.mesh);
    const Outcome built = this->Build({ "in.ply", "-o", "m.kds", "--precision", "lossless",
      "--weld", "off", "--vertices-per-partition", "150", "--stats", "s.json", "--quiet" });
    ASSERT_EQ(built.exitCode, 0) << built.err;
    EXPECT_EQ(built.out + built.err, "");
    ASSERT_EQ(this->Store({ "extract", "m.kds", "--all", "-o", "out.ply" }).exitCode, 0);
    const Mesh out = this->Read("out.ply");
    EXPECT_EQ(PointMultiset(out), PointMultiset(named.mesh));
    EXPECT_EQ(TriangleMultiset(out), TriangleMultiset(named.mesh));
    const Json stats = Json::parse(ReadWhole(this->Folder / "s.json"));
    EXPECT_EQ(stats["vertices"], named.mesh.points.size());
    EXPECT_EQ(stats["triangles"], named.mesh.triangles.size());
    EXPECT_LE(
      stats["partition_vertices"]["max"].get<int>() - stats["partition_vertices"]["min"].get<int>(),
      1);
  }
}

TEST_F(Programs, StatsHaveTheContractsKeys)
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

TEST_F(Programs, EveryOptionChangesSomething)
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
  const Json named = stats({ "--title", "T", "--credit", "C", "--license", "L", "--unit", "mm" });
  EXPECT_EQ(named["title"], "T");
  EXPECT_EQ(named["credit"], "C");
  EXPECT_EQ(named["license"], "L");
  EXPECT_EQ(named["unit"], "mm");
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

TEST_F(Programs, BaselinesHavePartitionsAndNoLevels)
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

TEST_F(Programs, DistanceOfALevel)
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
  // A level is at no distance from itself, as a file of any format.
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
  // The coarser, the farther, both ways; never farther than the largest distance.
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
    "kdstream-store: error: nothing.ply: no such file");
  this->ExpectError(this->Store({ "distance", "m.kds", "--level", "99", "--against", "in.ply" }), 2,
    "kdstream-store: error: m.kds: --level 99: the finest level is 10");
}

TEST_F(Programs, WrongUsageExitsWith2)
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
  ASSERT_EQ(this->Build({ "in.ply", "-o", "m.kds" }).exitCode, 0);
  const std::vector<std::vector<std::string>> wrongStore{ {}, { "info" },
    { "extract", "m.kds", "-o", "x.ply" }, { "extract", "m.kds", "--level", "3" },
    { "extract", "m.kds", "--level", "3", "--all", "-o", "x.ply" },
    { "extract", "m.kds", "--level", "99", "-o", "x.ply" },
    { "extract", "m.kds", "--partition", "1", "-o", "x.ply" },
    { "extract", "m.kds", "--region", "0", "-o", "x.ply" },
    { "extract", "m.kds", "--region", "2", "-o", "x.ply" },
    { "extract", "m.kds", "--in-context", "3", "--all", "-o", "x.ply" }, { "distance", "m.kds" } };
  for (const auto& arguments : wrongStore)
  {
    const Outcome outcome = this->Store(arguments);
    EXPECT_EQ(outcome.exitCode, 2) << (arguments.empty() ? "" : arguments.back()) << outcome.err;
    EXPECT_EQ(outcome.err.rfind("kdstream-store: error: ", 0), 0U) << outcome.err;
  }
  EXPECT_EQ(this->Files(), (std::set<std::string>{ "in.ply", "m.kds" }));
}

TEST_F(Programs, MemoryWithoutAUnitIsExplained)
{
  this->Write("in.ply", Torus(40, 20));
  this->ExpectError(this->Build({ "in.ply", "-o", "m.kds", "--memory", "64" }), 2,
    "kdstream-build: error: --memory: 64 bytes cannot hold any build; K, M or G may follow the "
    "number, as in 64M");
  this->ExpectError(this->Build({ "in.ply", "-o", "m.kds", "--memory", "64K" }), 2,
    "kdstream-build: error: --memory: 64 KiB cannot hold any build; K, M or G may follow the "
    "number, as in 64M");
  EXPECT_EQ(this->Build({ "in.ply", "-o", "m.kds", "--memory", "67108864" }).exitCode, 0);
}

TEST_F(Programs, AStoreOfAnotherEndingIsWarnedOf)
{
  this->Write("in.ply", Torus(40, 20));
  for (const char* output : { "m.xyz", "m", "m.KDS" })
  {
    const Outcome outcome = this->Build({ "in.ply", "-o", output, "--quiet" });
    EXPECT_EQ(outcome.exitCode, 0);
    EXPECT_EQ(outcome.err, "kdstream-build: warning: " + std::string(output) +
                             ": kdstream-serve finds stores by the ending .kds\n");
    EXPECT_EQ(this->Store({ "verify", output }).exitCode, 0);
  }
  EXPECT_EQ(this->Build({ "in.ply", "-o", "m.kds", "--quiet" }).err, "");
}

TEST_F(Programs, BadInputIsNamedWithItsPlace)
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
  expect("range.ply", "face 1: index 99 out of range (4 vertices)");
  expect("nan.ply", "vertex 1: z is not finite");
  expect("none.ply", "the mesh has no vertices");
  expect("model.ifc", ".ifc");
  expect("wide.ply",
    "the mesh spans more than 2^127 (1.7e38) along y, the most that levels can be computed for");
  expect("cut.ply", "face 1599");
  expect("cut2.ply", "vertex ");
}

TEST_F(Programs, RefusesWhatDoesNotFitTheMemory)
{
  this->Write("in.ply", DisplacedSphere(5));
  const Outcome outcome = this->Build({ "in.ply", "-o", "m.kds", "--memory", "1M" });
  EXPECT_EQ(outcome.exitCode, 1);
  EXPECT_EQ(outcome.err.rfind("kdstream-build: error: in.ply: needs about ", 0), 0U) << outcome.err;
  EXPECT_NE(outcome.err.find("the limit is 1 MiB"), std::string::npos);
  EXPECT_EQ(this->Files(), (std::set<std::string>{ "in.ply" }));
}

// With that many floats for each point and for each triangle, in arrays of four at most.
Mesh WithManyBytes(Mesh mesh, std::size_t forPoints, std::size_t forCells)
{
  for (const auto association : { AttributeAssociation::Point, AttributeAssociation::Cell })
  {
    const bool points = association == AttributeAssociation::Point;
    for (std::size_t left = points ? forPoints : forCells; left > 0;)
    {
      const std::size_t components = std::min<std::size_t>(left, 4);
      Attribute attribute{ { "a" + std::to_string(left), AttributeType::Float32, association,
                             static_cast<std::uint8_t>(components) },
        {} };
      attribute.values.resize(
        attribute.TupleSize() * (points ? mesh.points.size() : mesh.triangles.size()));
      mesh.attributes.push_back(std::move(attribute));
      left -= components;
    }
  }
  return mesh;
}

TEST_F(Programs, StaysBelowTheMemoryLimit)
{
  // A build that accepts a limit keeps it (64 MiB are the programs' own), measured from outside.
  // The meshes are gone before the programs start: a child counts what its parent held when it was
  // forked.
  const auto dense = []
  {
    Mesh mesh = Torus(500, 300);
    const std::vector<Triangle> once = mesh.triangles;
    for (unsigned i = 0; i < 5; ++i)
    {
      mesh.triangles.insert(mesh.triangles.end(), once.begin(), once.end());
    }
    return mesh;
  };
  const auto cloud = []
  {
    Mesh mesh = Torus(1000, 600);
    mesh.triangles.clear();
    return mesh;
  };
  const std::pair<const char*, std::function<Mesh()>> meshes[] = { { "torus", []
                                                                     { return Torus(1000, 600); } },
    { "shuffled torus", [] { return Shuffled(Torus(1000, 600), 1); } }, { "cloud", cloud },
    { "soup", [] { return Soup(200000, 1); } },
    { "attributes", [] { return WithManyBytes(Torus(500, 300), 6, 3); } },
    { "wide attributes", [] { return WithManyBytes(Torus(150, 100), 500, 100); } },
    { "each face six times", dense } };
  for (const auto& [name, make] : meshes)
  {
    this->Write("in.ply", make());
    ::malloc_trim(0);
    for (const char* cell : { "8", "1" })
    {
      SCOPED_TRACE(std::string(name) + ", cells of " + cell);
      unsigned accepted = 0, refused = 0;
      for (std::uint64_t limit = 32; limit <= 1024; limit += limit / 4)
      {
        const Outcome outcome = this->Build({ "in.ply", "-o", "m.kds", "--memory",
          std::to_string(limit) + "M", "--cell-vertices", cell });
        (outcome.exitCode == 0 ? accepted : refused) += 1;
        EXPECT_LE(outcome.peakBytes, (limit + 64) << 20) << "limit " << limit << " MiB";
        if (outcome.exitCode != 0)
        {
          EXPECT_NE(outcome.err.find(" of memory"), std::string::npos) << outcome.err;
        }
        else
        {
          EXPECT_LE(limit << 20, 4 * outcome.peakBytes)
            << "far more memory than needed was asked for";
          break;
        }
      }
      EXPECT_EQ(accepted, 1U);
      EXPECT_GT(refused, 0U);
    }
  }
}

TEST_F(Programs, OfAnStlWhatWeldingLeavesDecidesTheMemory)
{
  const auto temporaryBytes = [&](const Mesh& mesh)
  {
    this->Write("in.stl", mesh);
    constexpr std::uint64_t limit = 80;
    const Outcome outcome = this->Build(
      { "in.stl", "-o", "m.kds", "--memory", std::to_string(limit) + "M", "--stats", "s.json" });
    EXPECT_EQ(outcome.exitCode, 0) << outcome.err;
    EXPECT_LE(outcome.peakBytes, (limit + 64) << 20);
    return Json::parse(ReadWhole(this->Folder / "s.json"))["temp_bytes"].get<std::uint64_t>();
  };
  EXPECT_EQ(temporaryBytes(Torus(500, 300)), 0U) << "it fits, once it is welded";
  EXPECT_GT(temporaryBytes(Soup(200000, 1)), 0U) << "nothing is welded";
}

TEST_F(Programs, UnwritableOutputIsNamed)
{
  this->Write("in.ply", Torus(40, 20));
  ASSERT_EQ(this->Build({ "in.ply", "-o", "m.kds" }).exitCode, 0);
  EXPECT_EQ(this->Build({ "in.ply", "-o", "m.kds", "--stats", "no/s.json" }).err,
    "kdstream-build: error: no/s.json: cannot create a file in no: No such file or directory\n");
  const Outcome outcome = this->Store({ "extract", "m.kds", "--all", "-o", "no/x.ply" });
  EXPECT_EQ(outcome.exitCode, 1);
  EXPECT_EQ(outcome.err.rfind("kdstream-store: error: no/x.ply: ", 0), 0U) << outcome.err;
  EXPECT_EQ(this->Store({ "extract", "m.kds", "--all", "-o", "x.doc" }).exitCode, 2);
}

TEST_F(Programs, WarnsWhereTheGridIsTooCoarse)
{
  Mesh apart = Torus(40, 20);
  const std::size_t one = apart.points.size();
  for (std::size_t v = 0; v < one; ++v)
  {
    apart.points.push_back({ apart.points[v][0] + 65536, apart.points[v][1], apart.points[v][2] });
  }
  this->Write("in.ply", apart);
  const Outcome coarse = this->Build({ "in.ply", "-o", "m.kds", "--precision", "10" });
  EXPECT_EQ(coarse.exitCode, 0);
  EXPECT_NE(
    coarse.err.find("vertices fall together with others on a grid of 10 bits"), std::string::npos)
    << coarse.err;
  EXPECT_EQ(this->Build({ "in.ply", "-o", "m.kds", "--precision", "lossless" }).err, "");
}

TEST_F(Programs, WarnsOfColorsThatAreNotShown)
{
  struct Case
  {
    AttributeType type;
    AttributeAssociation association;
    std::string warning;
  };
  const Case cases[] = { { AttributeType::UInt16, AttributeAssociation::Point,
                           "colours of type uint16 are kept" },
    { AttributeType::UInt8, AttributeAssociation::Cell, "colours of triangles are kept" },
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
    const Outcome outcome = this->Build({ "in.ply", "-o", "m.kds" });
    EXPECT_EQ(outcome.exitCode, 0);
    EXPECT_EQ(outcome.err.empty(), it.warning.empty()) << outcome.err;
    EXPECT_NE(outcome.err.find(it.warning), std::string::npos) << outcome.err;
  }
}

TEST_F(Programs, NeverOverwritesItsInput)
{
  this->Write("in.ply", Torus(40, 20));
  const std::string input = ReadWhole(this->Folder / "in.ply");
  std::filesystem::create_symlink("in.ply", this->Folder / "link.ply");
  for (const char* output : { "in.ply", "./in.ply", "link.ply" })
  {
    this->ExpectError(this->Build({ "in.ply", "-o", output }), 2,
      std::string("kdstream-build: error: ") + output + ": is in.ply itself, which would be lost");
    EXPECT_EQ(this->Build({ "in.ply", "-o", "m.kds", "--stats", output }).exitCode, 2);
  }
  EXPECT_EQ(ReadWhole(this->Folder / "in.ply"), input);
  EXPECT_FALSE(std::filesystem::exists(this->Folder / "m.kds"));
  ASSERT_EQ(this->Build({ "in.ply", "-o", "m.ply" }).exitCode, 0); // a store under a mesh's name
  const std::string store = ReadWhole(this->Folder / "m.ply");
  EXPECT_EQ(this->Store({ "extract", "m.ply", "--all", "-o", "m.ply" }).exitCode, 2);
  EXPECT_TRUE(ReadWhole(this->Folder / "m.ply") == store);
}

TEST_F(Programs, RefusesOutputsThatAreNoFiles)
{
  this->Write("in.ply", Torus(40, 20));
  std::filesystem::create_directory(this->Folder / "folder");
  ASSERT_EQ(::mkfifo((this->Folder / "pipe").c_str(), 0600), 0);
  this->ExpectError(
    this->Build({ "in.ply", "-o", "folder" }), 1, "kdstream-build: error: folder: is a folder");
  this->ExpectError(this->Build({ "in.ply", "-o", "pipe" }), 1,
    "kdstream-build: error: pipe: cannot be written: it is not a regular file");
  EXPECT_TRUE(std::filesystem::is_fifo(this->Folder / "pipe"));
  // A link is followed, not replaced; stats may go to a stream.
  std::filesystem::create_symlink("target.kds", this->Folder / "link.kds");
  const Outcome built = this->Build({ "in.ply", "-o", "link.kds", "--stats", "/dev/stdout" });
  EXPECT_EQ(built.exitCode, 0) << built.err;
  EXPECT_TRUE(Json::parse(built.out).contains("digest"));
  EXPECT_TRUE(std::filesystem::is_symlink(this->Folder / "link.kds"));
  EXPECT_EQ(this->Store({ "verify", "target.kds" }).exitCode, 0);
}

TEST_F(Programs, TextsMustBeShowable)
{
  this->Write("in.ply", Torus(40, 20));
  for (const std::string& title :
    { std::string(4097, 'x'), std::string("a\x1B[31mb"), std::string("\xFF\xFE") })
  {
    EXPECT_EQ(this->Build({ "in.ply", "-o", "m.kds", "--title", title }).exitCode, 2);
  }
  EXPECT_EQ(this->Build({ "in.ply", "-o", "m.kds", "--title", "Ångström" }).exitCode, 0);
}

TEST_F(Programs, StlSaysWhatItLoses)
{
  Mesh doubles = Torus(40, 20);
  doubles.scalarType = ScalarType::Float64;
  this->Write("in.ply", doubles);
  ASSERT_EQ(this->Build({ "in.ply", "-o", "m.kds" }).exitCode, 0);
  EXPECT_EQ(this->Store({ "extract", "m.kds", "--all", "-o", "x.stl" }).err,
    "kdstream-store: warning: x.stl: STL holds floats; the coordinates were doubles and are "
    "rounded\n");
}

TEST_F(Programs, DamageIsNamedByVerify)
{
  this->Write("in.ply", Torus(96, 48));
  ASSERT_EQ(
    this->Build({ "in.ply", "-o", "m.kds", "--vertices-per-partition", "200" }).exitCode, 0);
  EXPECT_EQ(this->Store({ "verify", "m.kds" }).exitCode, 0);
  const std::string whole = ReadWhole(this->Folder / "m.kds");
  // The blob of the last partition: partitions come last in the file.
  std::string damaged = whole;
  const std::size_t blob = whole.rfind("KDP\x05");
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
  this->ExpectError(
    this->Store({ "info", "in.ply" }), 1, "kdstream-store: error: in.ply: not a KdStream store");
  this->ExpectError(this->Store({ "info", "nothing.kds" }), 1,
    "kdstream-store: error: nothing.kds: No such file or directory");
}

TEST_F(Programs, ExtractsWhatIsAskedFor)
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

TEST_F(Programs, AnInterruptLeavesNothingBehind)
{
  this->Write("in.ply", DisplacedSphere(8));
  const std::string program = std::string(KDSTREAM_PROGRAMS) + "/kdstream-build";
  unsigned interrupted = 0;
  for (unsigned milliseconds = 2; milliseconds < 500; milliseconds = milliseconds * 3 / 2 + 1)
  {
    const pid_t child = ::fork();
    if (child == 0)
    {
      const bool ready =
        ::chdir(this->Folder.Path.c_str()) == 0 && std::freopen("/dev/null", "w", stderr);
      if (ready)
      {
        ::execl(program.c_str(), program.c_str(), "in.ply", "-o", "m.kds", nullptr);
      }
      ::_exit(127);
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(milliseconds));
    ::kill(child, SIGINT);
    int status = 0;
    ::waitpid(child, &status, 0);
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
}
