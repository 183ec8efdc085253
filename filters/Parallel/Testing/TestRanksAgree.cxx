// SPDX-License-Identifier: BSD-3-Clause
// If ranks are started with different arguments, the job ends before it works, and the error names
// the rank. Files that a killed job left are removed by the next job.
#include "Testing/Fixtures/Meshes.h"
#include "filters/Parallel/Testing/RunRanks.h"
#include "filters/meshio/MeshWriter.h"

#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <thread>

namespace kdstream
{
namespace
{

using namespace fixtures;

// For /bin/sh: replaces the shell by kdstream-build-mpi. REQUIRES: no argument has a quote.
std::string ExecBuild(const std::vector<std::string>& arguments)
{
  std::string line = "exec '" + buildMpi + "'";
  for (const std::string& argument : arguments)
  {
    line += " '" + argument + "'";
  }
  return line;
}

// Runs three ranks; the second has other arguments. They are a single application of mpirun: that
// of Debian 13 crashes with several, whatever the program (open-mpi/ompi#13303).
Outcome RunOneOtherwise(const TemporaryFolder& folder, const std::vector<std::string>& usual,
  const std::vector<std::string>& other)
{
  const std::string script =
    "if [ \"$OMPI_COMM_WORLD_RANK\" = 1 ]; then " + ExecBuild(other) + "; fi; " + ExecBuild(usual);
  return RunProgram(folder, KDSTREAM_MPIRUN, Ranks(3, { "/bin/sh", "-c", script }));
}

std::vector<std::string> With(
  std::vector<std::string> arguments, const std::vector<std::string>& more)
{
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

// "rank 1 on node7"
std::string Rank(unsigned rank)
{
  char host[256] = {};
  ::gethostname(host, sizeof(host) - 1);
  return "rank " + std::to_string(rank) + " on " + host;
}

TEST(RanksAgree, OtherOptionsOfOneRankEndTheJob)
{
  const TemporaryFolder folder;
  ASSERT_TRUE(WriteMesh(folder / "mesh.ply", DisplacedSphere(4)));
  const std::vector<std::string> usual{ "mesh.ply", "-o", "out.kds", "--quiet" };
  const auto expectDifference =
    [&](const std::vector<std::string>& option, const std::string& is, const std::string& other)
  {
    SCOPED_TRACE(option[0]);
    ExpectOneMessage(RunOneOtherwise(folder, usual, With(usual, option)),
      "all ranks need the same options: " + option[0] + " is " + is + " on " + Rank(0) + ", and " +
        other + " on " + Rank(1) + "\n",
      2);
    EXPECT_EQ(Others(folder, { "mesh.ply" }), std::vector<std::string>{});
  };
  expectDifference({ "--precision", "12" }, "20", "12");
  expectDifference({ "--weld", "off" }, "on", "off");
  expectDifference({ "--title", "A ball" }, "not given", "\"A ball\"");
  const std::vector<std::string> elsewhere{ "mesh.ply", "-o", "other.kds", "--quiet" };
  ExpectOneMessage(RunOneOtherwise(folder, usual, elsewhere),
    "--output is out.kds on " + Rank(0) + ", and other.kds on " + Rank(1), 2);
}

// Wrong arguments of one rank, or a request for help.
TEST(RanksAgree, WrongUsageOfOneRankEndsTheJob)
{
  const TemporaryFolder folder;
  ASSERT_TRUE(WriteMesh(folder / "mesh.ply", DisplacedSphere(2)));
  const std::vector<std::string> usual{ "mesh.ply", "-o", "out.kds", "--quiet" };
  const std::string of = " (" + Rank(1) + ")";
  const auto run = [&](const std::vector<std::string>& more)
  { return RunOneOtherwise(folder, usual, With(usual, more)); };
  ExpectOneMessage(run({ "--precison", "12" }), of, 2);
  ExpectOneMessage(run({ "--help" }),
    "--help or --version is not given on " + Rank(0) + ", and given on " + Rank(1), 2);
  ExpectOneMessage(RunOneOtherwise(folder, usual, { "mesh.las", "-o", "out.kds" }), of, 1);
  EXPECT_EQ(Others(folder, { "mesh.ply" }), std::vector<std::string>{});
}

// Runs three ranks; the second works in a folder of its own.
Outcome RunElsewhere(const TemporaryFolder& folder, const std::string& arguments)
{
  const std::string script = "if [ \"$OMPI_COMM_WORLD_RANK\" = 1 ]; then cd other; fi; exec " +
                             buildMpi + " " + arguments + " -o out.kds --quiet";
  return RunProgram(folder, KDSTREAM_MPIRUN, Ranks(3, { "/bin/sh", "-c", script }));
}

TEST(RanksAgree, OtherFilesOfTheSameNameEndTheJob)
{
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder / "other");
  ASSERT_TRUE(WriteMesh(folder / "mesh.ply", DisplacedSphere(7)));
  const std::string whole = ReadWhole(folder / "mesh.ply");
  ASSERT_GT(whole.size(), std::size_t{ 3 } << 19);
  const auto expectRefused = [&](const std::string& bytes, const std::string& said)
  {
    std::ofstream(folder / "other/mesh.ply", std::ios::binary) << bytes;
    ExpectOneMessage(RunElsewhere(folder, "mesh.ply"), said);
    EXPECT_EQ(Others(folder, { "mesh.ply", "other" }), std::vector<std::string>{});
  };
  const std::string named = "mesh.ply: the ranks have different files of this name: ";
  expectRefused(whole + "more", named + "the size in bytes is " + std::to_string(whole.size()) +
                                  " on " + Rank(0) + ", and " + std::to_string(whole.size() + 4) +
                                  " on " + Rank(1));
  // One changes a coordinate in the first MB, the other a corner in the last.
  for (const std::size_t place : { std::size_t{ 1000 }, whole.size() - 20 })
  {
    std::string changed = whole;
    changed[place] = static_cast<char>(changed[place] ^ 1);
    expectRefused(changed, named + "the hash of its content is ");
  }
  std::filesystem::remove(folder / "other/mesh.ply");
  ExpectOneMessage(RunElsewhere(folder, "mesh.ply"), "mesh.ply: no such file (" + Rank(1) + ")");
  // The same file under another path counts as the same.
  std::filesystem::copy(folder / "mesh.ply", folder / "other/mesh.ply");
  EXPECT_EQ(RunElsewhere(folder, "mesh.ply").exitCode, 0);
}

std::string DigestOf(const TemporaryFolder& folder, const std::string& store)
{
  const std::string info = RunTool(folder, "store", { "info", store, "--json" }).out;
  const std::size_t begin = info.find("\"digest\"");
  return begin == std::string::npos ? info : info.substr(begin, 45);
}

// The places where blocks end, and how often ranks exchange data, do not depend on the limit of one
// rank.
TEST(RanksAgree, RanksMayHaveDifferentLimitsOfMemory)
{
  const TemporaryFolder folder;
  ASSERT_TRUE(WriteMesh(folder / "mesh.ply", Shuffled(GridPlate(420), 3)));
  const std::vector<std::string> usual{ "mesh.ply", "-o", "some.kds", "--quiet", "--memory" };
  const Outcome some =
    RunOneOtherwise(folder, With(usual, { "512M" }), With(usual, { "64M", "--threads", "1" }));
  ASSERT_EQ(some.exitCode, 0) << some.err;
  ASSERT_EQ(RunTool(folder, "build", { "mesh.ply", "-o", "one.kds", "--quiet" }).exitCode, 0);
  EXPECT_EQ(DigestOf(folder, "some.kds"), DigestOf(folder, "one.kds"));
  EXPECT_EQ(RunTool(folder, "store", { "verify", "some.kds" }).exitCode, 0);
  ExpectOneMessage(RunOneOtherwise(folder, With(usual, { "512M" }), With(usual, { "8M" })),
    "the limit is 8 MiB (" + Rank(1) + ")");
}

TEST(RanksAgree, ARankWithoutMemoryForWhatComesIsTheErrorOfAll)
{
  const TemporaryFolder folder;
  const Outcome outcome = RunProgram(folder, KDSTREAM_MPIRUN,
    Ranks(
      2, { std::string(KDSTREAM_PROGRAMS) + "/RanksAgainstOne", folder.Path.string(), "room" }));
  EXPECT_EQ(outcome.exitCode, 0) << outcome.out << outcome.err;
}

TEST(RanksAgree, TheNextBuildRemovesWhatAKilledJobHasLeft)
{
  const TemporaryFolder folder;
  ASSERT_TRUE(WriteMesh(folder / "mesh.ply", GridPlate(350)));
  const std::vector<std::string> arguments{ "mesh.ply", "-o", "out.kds", "--quiet", "--threads",
    "1", "--memory", "64M" };
  for (const bool byRanks : { true, false })
  {
    const pid_t mpirun = Start(folder, KDSTREAM_MPIRUN, Ranks(2, With({ buildMpi }, arguments)));
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    while (!HasBegun(folder, false) && std::chrono::steady_clock::now() < deadline)
    {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    for (const pid_t rank : ChildrenOf(mpirun))
    {
      ::kill(rank, SIGKILL);
    }
    int status = 0;
    ASSERT_EQ(::waitpid(mpirun, &status, 0), mpirun);
    EXPECT_FALSE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
    const std::vector<std::string> left = Others(folder, { "mesh.ply", ".said" });
    EXPECT_FALSE(left.empty());
    EXPECT_TRUE(std::all_of(
      left.begin(), left.end(), [](const std::string& name) { return name.front() == '.'; }));
    const Outcome next =
      byRanks ? RunRanks(folder, 2, arguments) : RunTool(folder, "build", arguments);
    EXPECT_EQ(next.exitCode, 0) << next.err;
    EXPECT_EQ(Others(folder, { "mesh.ply", "out.kds", ".said" }), std::vector<std::string>{});
    std::filesystem::remove(folder / "out.kds");
  }
}

}
}
