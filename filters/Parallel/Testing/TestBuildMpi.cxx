// SPDX-License-Identifier: BSD-3-Clause
// kdstream-build-mpi compared with kdstream-build: the same store for any number of ranks; if it
// fails, one message and no store.
#include "Testing/Fixtures/Attributes.h"
#include "Testing/Fixtures/Meshes.h"
#include "filters/Parallel/Testing/RunRanks.h"
#include "filters/meshio/MeshWriter.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <sstream>
#include <thread>

using namespace kdstream;
using namespace kdstream::fixtures;

namespace
{

nlohmann::json StatsOf(const TemporaryFolder& folder, const std::string& name)
{
  nlohmann::json stats = nlohmann::json::parse(ReadWhole(folder / name), nullptr, false);
  for (const char* const measured : { "seconds", "peak_rss_bytes", "convert_peak_rss_bytes",
         "passes", "temp_bytes", "temp_bytes_read", "temp_bytes_written", "bytes" })
  {
    stats.erase(measured);
  }
  return stats;
}

// The output without the program's name at the beginning of each line.
std::string WithoutName(const std::string& said)
{
  std::istringstream lines(said);
  std::string rest;
  for (std::string line; std::getline(lines, line);)
  {
    rest += line.substr(std::min(line.size(), line.find(": "))) + "\n";
  }
  return rest;
}

// Builds the mesh by one process and on several ranks. The stores and the printed statistics must
// be the same.
void CheckSame(
  const Mesh& mesh, const std::vector<unsigned>& ranks, const std::vector<std::string>& options)
{
  const TemporaryFolder folder;
  ASSERT_TRUE(WriteMesh(folder / "mesh.ply", mesh));
  std::vector<std::string> arguments{ "mesh.ply", "-o", "one.kds", "--quiet", "--stats",
    "one.json" };
  arguments.insert(arguments.end(), options.begin(), options.end());
  const Outcome one = RunTool(folder, "build", arguments);
  ASSERT_EQ(one.exitCode, 0) << one.err;
  const nlohmann::json expected = StatsOf(folder, "one.json");
  ASSERT_TRUE(expected.contains("digest"));
  for (const unsigned count : ranks)
  {
    SCOPED_TRACE(std::to_string(count) + " ranks");
    arguments[2] = "some.kds";
    arguments[5] = "some.json";
    const Outcome some = RunRanks(folder, count, arguments);
    ASSERT_EQ(some.exitCode, 0) << some.err;
    EXPECT_EQ(StatsOf(folder, "some.json"), expected);
    EXPECT_EQ(WithoutName(some.err), WithoutName(one.err));
    EXPECT_EQ(Others(folder, { "mesh.ply", "one.kds", "one.json", "some.kds", "some.json" }),
      std::vector<std::string>{});
  }
}

}

TEST(BuildMpi, HardMeshes)
{
  const TemporaryFolder folder;
  const Outcome outcome = RunProgram(folder, KDSTREAM_MPIRUN,
    Ranks(3, { std::string(KDSTREAM_PROGRAMS) + "/RanksAgainstOne", folder.Path.string() }));
  EXPECT_EQ(outcome.exitCode, 0) << outcome.out << outcome.err;
  EXPECT_EQ(Others(folder, { "mesh.ply", "one.kds", "some.kds" }), std::vector<std::string>{});
}

TEST(BuildMpi, OptionsAndRanks)
{
  const Mesh mesh = Shuffled(DisplacedSphere(5), 7);
  CheckSame(mesh, { 1, 5 }, { "--vertices-per-partition", "3" }); // S of 16 and more
  // A plate, because many merges have the same cost.
  CheckSame(GridPlate(220), { 3 }, { "--vertices-per-partition", "200", "--cell-vertices", "2" });
  // Clusters that lose their last triangle at the border of a block; rounds on three ranks.
  CheckSame(Soup(30000, 5), { 3 }, { "--vertices-per-partition", "500", "--cell-vertices", "2" });
  CheckSame(mesh, { 3 },
    { "--partitions", "64", "--sheets", "off", "--representative", "mean", "--title", "A ball" });
  CheckSame(mesh, { 2 }, { "--precision", "8" }); // warns that vertices are merged
}

// Only one rank reads the end of the file and sees the data after the last face. The first rank
// reports them.
TEST(BuildMpi, ReportsWhatItIgnores)
{
  const TemporaryFolder folder;
  std::ofstream(folder / "text.ply") << "ply\nformat ascii 1.0\nelement vertex 4\n"
                                        "property float x\nproperty float y\nproperty float z\n"
                                        "property list uchar int neighbours\n"
                                        "element face 3\n"
                                        "property list uchar int vertex_indices\nend_header\n"
                                        "0 0 0 0\n1 0 0 0\n0 1 0 0\n0 0 1 0\n"
                                        "3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";
  ASSERT_TRUE(WriteMesh(folder / "binary.ply", DisplacedSphere(2)));
  std::ofstream(folder / "binary.ply", std::ios::binary | std::ios::app) << "a second mesh";
  for (const std::string file : { "text.ply", "binary.ply" })
  {
    SCOPED_TRACE(file);
    const Outcome one = RunTool(folder, "build", { file, "-o", "one.kds", "--quiet" });
    ASSERT_EQ(one.exitCode, 0) << one.err;
    ASSERT_NE(one.err.find(" bytes after the end"), std::string::npos) << one.err;
    const Outcome some = RunRanks(folder, 3, { file, "-o", "some.kds", "--quiet" });
    EXPECT_EQ(WithoutName(some.err), WithoutName(one.err));
  }
}

// Pictures too: the first rank reads them, and each rank makes the textures of its partitions.
TEST(BuildMpi, TexturedMeshes)
{
  const TemporaryFolder folder;
  ASSERT_EQ(RunTool(folder, "generate",
              { "statue", "statue.obj", "--vertices", "12000", "--picture-side", "256", "--quiet" })
              .exitCode,
    0);
  const auto build = [&](unsigned ranks, const std::string& name)
  {
    const std::vector<std::string> arguments{ "statue.obj", "-o", name + ".kds", "--stats",
      name + ".json", "--vertices-per-partition", "500", "--cell-vertices", "2", "--quiet" };
    const Outcome built =
      ranks == 0 ? RunTool(folder, "build", arguments) : RunRanks(folder, ranks, arguments);
    ASSERT_EQ(built.exitCode, 0) << built.err;
    EXPECT_EQ(built.err, "");
  };
  build(0, "one");
  const nlohmann::json expected = StatsOf(folder, "one.json");
  ASSERT_TRUE(expected.contains("textures"));
  for (const unsigned ranks : { 1U, 3U })
  {
    build(ranks, "some");
    nlohmann::json some = StatsOf(folder, "some.json");
    EXPECT_EQ(some, expected) << ranks;
  }
  std::size_t folders = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder.Path))
  {
    folders += entry.is_directory() ? 1 : 0;
  }
  EXPECT_EQ(folders, 0U);
}

// If one rank drops a vertex, the corners of all ranks change. Also, a line and a quad have the
// same number of bytes as two triangles, which some ranks skip.
TEST(BuildMpi, DropsAndCountsTheSame)
{
  const TemporaryFolder folder;
  Mesh mesh = Shuffled(DisplacedSphere(5), 7);
  mesh.scalarType = ScalarType::Float64;
  Mesh spoiled = mesh;
  for (std::size_t v = 100; v < spoiled.points.size(); v += 977)
  {
    spoiled.points[v][v % 3] = std::numeric_limits<double>::quiet_NaN();
  }
  ASSERT_TRUE(WriteMesh(folder / "nan.ply", spoiled));
  ASSERT_TRUE(WriteMesh(folder / "nan.stl", spoiled));
  const std::string vertices = "ply\nformat binary_little_endian 1.0\nelement vertex 4\n"
                               "property uchar x\nproperty uchar y\nproperty uchar z\n"
                               "element face 6\nproperty list uchar uchar vertex_indices\n"
                               "end_header\n";
  std::ofstream(folder / "mixed.ply", std::ios::binary)
    << vertices << std::string("\0\0\0\1\0\0\0\1\0\0\0\1", 12)
    << std::string("\3\0\1\2\3\0\1\3\2\0\1\3\0\2\3\4\0\1\2\3\3\1\2\3", 24);
  for (const std::string file : { "nan.ply", "nan.stl", "mixed.ply" })
  {
    SCOPED_TRACE(file);
    const std::vector<std::string> options{ file, "--quiet", "--precision", "lossless" };
    const auto with = [&](std::vector<std::string> more)
    {
      more.insert(more.begin(), options.begin(), options.end());
      return more;
    };
    const Outcome one = RunTool(folder, "build", with({ "-o", "one.kds", "--stats", "one.json" }));
    ASSERT_EQ(one.exitCode, 0) << one.err;
    EXPECT_NE(one.err.find(" dropped"), std::string::npos) << one.err;
    for (const unsigned ranks : { 1U, 3U })
    {
      const Outcome some =
        RunRanks(folder, ranks, with({ "-o", "some.kds", "--stats", "some.json" }));
      ASSERT_EQ(some.exitCode, 0) << some.err;
      EXPECT_EQ(WithoutName(some.err), WithoutName(one.err));
      EXPECT_EQ(StatsOf(folder, "some.json"), StatsOf(folder, "one.json"));
    }
    EXPECT_EQ(RunRanks(folder, 3, with({ "-o", "some.kds", "--strict" })).exitCode, 1);
  }
}

TEST(BuildMpi, Clouds)
{
  CheckSame(WithAttributes(Cloud(5), 3), { 2 }, { "--vertices-per-partition", "50" });
}

namespace
{

// Builds on several ranks with a memory limit. The memory of each rank, measured from outside, must
// be within the limit plus what libraries take.
void CheckMemoryOfRanks(const TemporaryFolder& folder, unsigned ranks, std::uint64_t mebibytes,
  const std::vector<std::string>& options)
{
  std::vector<std::string> command{ std::string(KDSTREAM_PROGRAMS) + "/MeasureRank",
    folder.Path.string(), buildMpi, "mesh.ply", "-o", "some.kds", "--quiet", "--memory",
    std::to_string(mebibytes) + "M" };
  command.insert(command.end(), options.begin(), options.end());
  const Outcome outcome = RunProgram(folder, KDSTREAM_MPIRUN, Ranks(ranks, command));
  ASSERT_EQ(outcome.exitCode, 0) << outcome.err;
  const std::vector<std::string> measured = Others(folder, { "mesh.ply", "some.kds" });
  EXPECT_EQ(measured.size(), ranks);
  for (const std::string& name : measured)
  {
    const std::uint64_t bytes = std::stoull("0" + ReadWhole(folder / name));
    EXPECT_GT(bytes, std::uint64_t{ 16 } << 20) << name;
    EXPECT_LE(bytes, (mebibytes + 64) << 20) << name;
    testing::Test::RecordProperty(name, std::to_string(bytes >> 20) + " MiB");
    std::filesystem::remove(folder / name);
  }
}

}

TEST(BuildMpi, EachRankHoldsItsLimitOfMemory)
{
  const TemporaryFolder folder;
  ASSERT_TRUE(WriteMesh(folder / "mesh.ply", Shuffled(GridPlate(700), 2)));
  CheckMemoryOfRanks(folder, 3, 64, {});
}

namespace
{

// Runs three ranks, of which rank 1 first runs `differs` in its shell.
Outcome RunWithOneOther(const TemporaryFolder& folder, const std::string& differs)
{
  const std::string script = "in=mesh.ply; if [ \"$OMPI_COMM_WORLD_RANK\" = 1 ]; then " + differs +
                             "; fi; exec " + buildMpi + " \"$in\" -o out.kds --quiet";
  return RunProgram(folder, KDSTREAM_MPIRUN, Ranks(3, { "/bin/sh", "-c", script }));
}

}

TEST(BuildMpi, AnErrorOfOneRankIsThatOfAll)
{
  const TemporaryFolder folder;
  ASSERT_TRUE(WriteMesh(folder / "mesh.ply", DisplacedSphere(6)));
  const std::string whole = ReadWhole(folder / "mesh.ply");
  std::ofstream(folder / "cut.ply", std::ios::binary) << whole.substr(0, whole.size() - 7);
  // Only the rank that reads the end of the file sees this error.
  ExpectOneMessage(RunRanks(folder, 3, { "cut.ply", "-o", "out.kds", "--quiet" }), "cut.ply: ");
  ExpectOneMessage(RunWithOneOther(folder, "in=none.ply"), "none.ply: no such file (rank 1 on ");
  Mesh wide = DisplacedSphere(4);
  wide.scalarType = ScalarType::Float64;
  for (Vec3& p : wide.points)
  {
    p = { 1e306 * p[0], p[1], p[2] };
  }
  ASSERT_TRUE(WriteMesh(folder / "wide.ply", wide));
  const std::string tooWide = "wide.ply: the mesh spans more than 2^127 (1.7e38) along x";
  ExpectOneMessage(RunRanks(folder, 3, { "wide.ply", "-o", "out.kds", "--quiet" }), tooWide);
  // Files cannot grow beyond 8 MB; the levels need more.
  ASSERT_TRUE(WriteMesh(folder / "mesh.ply", GridPlate(500)));
  const Outcome full = RunWithOneOther(folder, "ulimit -f 16000");
  ExpectOneMessage(full, "is too small");
  EXPECT_NE(full.err.find(" (rank 1 on "), std::string::npos) << full.err;
  EXPECT_EQ(Others(folder, { "mesh.ply", "cut.ply", "wide.ply" }), std::vector<std::string>{});
}

TEST(BuildMpi, AnExceptionOfOneRankIsTheErrorOfAll)
{
  const TemporaryFolder folder;
  const Outcome outcome = RunProgram(folder, KDSTREAM_MPIRUN,
    Ranks(
      3, { std::string(KDSTREAM_PROGRAMS) + "/RanksAgainstOne", folder.Path.string(), "throws" }));
  EXPECT_EQ(outcome.exitCode, 0) << outcome.out << outcome.err;
  EXPECT_EQ(Others(folder, { "mesh.ply" }), std::vector<std::string>{});
}

namespace
{

// Both programs must refuse the file with the same message. REQUIRES: the mesh is too large to be
// built in memory, so that kdstream-build works out of core, too.
void ExpectSameRefusal(const TemporaryFolder& folder, unsigned ranks, const std::string& file,
  const std::vector<std::string>& options, const std::string& said)
{
  SCOPED_TRACE(said);
  std::vector<std::string> arguments{ file, "-o", "out.kds", "--quiet" };
  arguments.insert(arguments.end(), options.begin(), options.end());
  const Outcome some = RunRanks(folder, ranks, arguments);
  ExpectOneMessage(some, said);
  arguments.push_back("--resume");
  const Outcome one = RunTool(folder, "build", arguments);
  EXPECT_EQ(one.exitCode, 1);
  const auto line = [](const std::string& err) // without the name of the rank
  {
    const std::size_t begin = std::min(err.size(), err.find("error: "));
    const std::string whole = err.substr(begin, err.find('\n', begin) - begin);
    return whole.substr(0, whole.find(" (rank "));
  };
  EXPECT_EQ(line(some.err), line(one.err));
}

// A fan far from the origin, beside an ordinary surface.
Mesh MeshWithHub(VertexId rim)
{
  Mesh mesh = Torus(40, 30);
  const auto hub = static_cast<VertexId>(mesh.points.size());
  mesh.points.push_back({ 8, 0.5, -2 });
  for (VertexId i = 1; i <= rim; ++i)
  {
    mesh.points.push_back({ 8 + double(i % 500), double(i / 500), double(0.25F) });
    mesh.triangles.push_back({ hub + i % rim + 1, hub, hub + i });
  }
  return mesh;
}

}

TEST(BuildMpi, AHubThatNoMemoryHoldsIsNamed)
{
  const TemporaryFolder folder;
  ASSERT_TRUE(WriteMesh(folder / "mesh.ply", Shuffled(MeshWithHub(150000), 3)));
  ExpectSameRefusal(folder, 3, "mesh.ply", { "--memory", "64M" },
    "the vertex at (8.000000, 0.500000, -2.000000) has 150000 triangles, which must be in memory "
    "together: use --memory 69M");
  EXPECT_EQ(Others(folder, { "mesh.ply" }), std::vector<std::string>{});
  CheckMemoryOfRanks(folder, 3, 69, {});
}

// Refused when vertices are welded; or before anything is read, if the header shows it.
TEST(BuildMpi, PartitionsThatNoMemoryHoldsAreRefused)
{
  const TemporaryFolder folder;
  ASSERT_TRUE(WriteMesh(folder / "mesh.ply", Unwelded(Torus(500, 300))));
  const std::vector<std::string> build{ "mesh.ply", "-o", "out.kds", "--quiet", "--memory", "64M",
    "--partitions", "1" };
  ExpectOneMessage(RunRanks(folder, 2, build),
    "partitions of 150000 vertices need about 115 MiB of memory; the limit (--memory) is 64 MiB: "
    "raise it, or make smaller partitions");
  EXPECT_NE(
    RunTool(folder, "build", build).err.find("partitions of 150000 vertices need about 115 MiB"),
    std::string::npos);
  CheckMemoryOfRanks(folder, 2, 115, { "--partitions", "1" });
  ASSERT_TRUE(WriteMesh(folder / "mesh.ply", Torus(1000, 500)));
  const std::string whole = ReadWhole(folder / "mesh.ply");
  std::ofstream(folder / "cut.ply", std::ios::binary) << whole.substr(0, whole.size() - 7);
  ExpectSameRefusal(folder, 2, "cut.ply", { "--memory", "64M", "--partitions", "4" },
    "partitions of 125000 vertices need about 96 MiB");
  EXPECT_EQ(Others(folder, { "mesh.ply", "cut.ply", "some.kds" }), std::vector<std::string>{});
}

namespace
{

void CheckInterrupted(bool oneRank, bool whileItWrites)
{
  const TemporaryFolder folder;
  // mpirun signals the ranks a second later, and they must still be working then.
  ASSERT_TRUE(WriteMesh(folder / "mesh.ply", GridPlate(oneRank || whileItWrites ? 350 : 700)));
  // The ranks report to a file: mpirun of Open MPI 5 drops what they say after its own signal.
  const std::string script =
    "exec " + buildMpi + " mesh.ply -o out.kds --quiet --threads 1 --memory 64M 2>> .errors";
  const std::vector<std::string> command = Ranks(2, { "/bin/sh", "-c", script });
  ::setenv("OMPI_MCA_odls_base_sigkill_timeout", "1", 1);
  const pid_t mpirun = Start(folder, KDSTREAM_MPIRUN, command);
  while (!HasBegun(folder, whileItWrites) && ::waitpid(mpirun, nullptr, WNOHANG) == 0)
  {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  const std::vector<pid_t> ranks = ChildrenOf(mpirun);
  ASSERT_FALSE(ranks.empty());
  const pid_t to = oneRank ? ranks.back() : mpirun;
  ::kill(to, SIGINT);
  int status = 0;
  ASSERT_EQ(::waitpid(mpirun, &status, 0), mpirun);
  const std::string said = ReadWhole(folder / ".errors");
  // Ranks receive mpirun's signal a second later. By then they may have finished.
  const bool late = whileItWrites || !oneRank;
  if (late && std::filesystem::exists(folder / "out.kds"))
  {
    EXPECT_EQ(
      Others(folder, { "mesh.ply", ".said", ".errors", "out.kds" }), std::vector<std::string>{});
    EXPECT_EQ(RunTool(folder, "store", { "verify", "out.kds" }).exitCode, 0);
    return;
  }
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 1) << status;
  const std::size_t first = said.find("kdstream-build-mpi: error: ");
  EXPECT_NE(first, std::string::npos) << said;
  EXPECT_EQ(said.find("kdstream-build-mpi: error: ", first + 1), std::string::npos) << said;
  EXPECT_NE(said.find("error: interrupted"), std::string::npos) << said;
  EXPECT_EQ(Others(folder, { "mesh.ply", ".said", ".errors" }), std::vector<std::string>{});
}

}

TEST(BuildMpi, LeavesNothingWhenItIsInterrupted)
{
  CheckInterrupted(false, false);
  CheckInterrupted(false, true);
  CheckInterrupted(true, false);
  CheckInterrupted(true, true);
}

TEST(BuildMpi, SaysWhatItDoesNotDo)
{
  const TemporaryFolder folder;
  ASSERT_TRUE(WriteMesh(folder / "mesh.ply", DisplacedSphere(3)));
  const auto check = [&](std::vector<std::string> arguments, int exitCode, const std::string& said)
  {
    arguments.insert(arguments.end(), { "-o", "out.kds", "--quiet" });
    const Outcome outcome = RunRanks(folder, 2, arguments);
    EXPECT_EQ(outcome.exitCode, exitCode);
    EXPECT_NE(outcome.err.find(said), std::string::npos) << outcome.err;
  };
  check({ "mesh.ply", "--partitioner", "octree" }, 2,
    "--partitioner octree does not work on several ranks: use kdstream-build");
  check(
    { "mesh.ply", "--resume" }, 2, "--resume does not work on several ranks: use kdstream-build");
  check(
    { "mesh.ply", "--reconstruct", "greedy" }, 2, "--reconstruct does not work on several ranks");
  check({ "mesh.ply", "--memory", "8M" }, 1, "at least 64 MiB on each");
  check({ "mesh.ply", "--precision", "7" }, 2, "neither a number of bits from 8 to 24");
  EXPECT_EQ(Others(folder, { "mesh.ply" }), std::vector<std::string>{});
}
