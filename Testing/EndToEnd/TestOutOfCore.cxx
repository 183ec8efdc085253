// SPDX-License-Identifier: BSD-3-Clause
// kdstream-build with less memory than the mesh needs makes the same store as with more, within the
// limit, whatever interrupts it.
#include "Testing/EndToEnd/Process.h"
#include "Testing/Fixtures/Meshes.h"
#include "Testing/Fixtures/Sanitized.h"
#include "filters/meshio/MeshWriter.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <malloc.h>

#include <chrono>
#include <csignal>
#include <functional>
#include <set>
#include <thread>

using namespace kdstream;
using namespace kdstream::fixtures;
using Json = nlohmann::json;
namespace fs = std::filesystem;

namespace
{

using Arguments = std::vector<std::string>;

class OutOfCore : public ::testing::Test
{
protected:
  OutOfCore() { fs::create_directory(this->Folder / "spill"); }

  // Writes the mesh. It is freed afterwards, because a child's peak includes its parent's memory at
  // the fork.
  void Write(const std::function<Mesh()>& make)
  {
    const Status status = WriteMesh(this->Folder / "in.ply", make());
    ASSERT_TRUE(status) << status.GetError().message;
    ::malloc_trim(0);
  }

  Outcome Build(Arguments options)
  {
    options.insert(options.begin(),
      { "in.ply", "-o", "m.kds", "--temp-dir", "spill", "--stats", "s.json", "--quiet" });
    return RunTool(this->Folder, "build", options);
  }
  Json Stats() { return Json::parse(ReadWhole(this->Folder / "s.json")); }

  // Builds, verifies and removes the store. Returns its statistics; `store` gets its bytes.
  Json StatsOf(const Arguments& options, std::string& store)
  {
    const Outcome built = this->Build(options);
    EXPECT_EQ(built.exitCode, 0) << built.err;
    EXPECT_EQ(RunTool(this->Folder, "store", { "verify", "m.kds" }).exitCode, 0);
    store = ReadWhole(this->Folder / "m.kds");
    fs::remove(this->Folder / "m.kds");
    Json stats = this->Stats();
    fs::remove(this->Folder / "s.json");
    this->ExpectNothingLeft();
    return stats;
  }

  void ExpectNothingLeft(const std::set<std::string>& but = { "in.ply", "spill" })
  {
    EXPECT_TRUE(fs::is_empty(this->Folder / "spill"));
    EXPECT_EQ(this->Folder.Names(), but);
  }

  // Expects that all runs make the same store; the last run is in memory.
  void ExpectOneStore(const Arguments& common, const std::vector<Arguments>& runs)
  {
    std::string expected;
    for (std::size_t i = runs.size(); i-- > 0;)
    {
      Arguments options = common;
      options.insert(options.end(), runs[i].begin(), runs[i].end());
      std::string store;
      const Json stats = this->StatsOf(options, store);
      if (i + 1 == runs.size())
      {
        expected = store;
        EXPECT_EQ(stats["temp_bytes"], 0);
        continue;
      }
      EXPECT_TRUE(store == expected) << "run " << i << ", digest " << stats["digest"];
      EXPECT_GT(stats["temp_bytes"], 0);
      EXPECT_GT(stats["passes"], 1);
    }
  }

  // Starts a build, and sends it a signal after a while. Returns whether the signal has ended it.
  bool BuildAndSignal(const Arguments& options, int signal, std::chrono::milliseconds after)
  {
    const std::string program = std::string(KDSTREAM_PROGRAMS) + "/kdstream-build";
    const pid_t child = ::fork();
    if (child == 0)
    {
      std::vector<char*> argv{ const_cast<char*>(program.c_str()) };
      for (const std::string& argument : options)
      {
        argv.push_back(const_cast<char*>(argument.c_str()));
      }
      argv.push_back(nullptr);
      if (::chdir(this->Folder.Path.c_str()) == 0 && std::freopen("/dev/null", "w", stderr))
      {
        ::execv(program.c_str(), argv.data());
      }
      ::_exit(127);
    }
    std::this_thread::sleep_for(after);
    ::kill(child, signal);
    int status = 0;
    ::waitpid(child, &status, 0);
    return !WIFEXITED(status) || WEXITSTATUS(status) != 0;
  }

  TemporaryFolder Folder;
};

// A mesh that does not fit into 64M or 96M.
Mesh Plate()
{
  return Shuffled(GridPlate(550), 3);
}

Mesh EachFaceSixTimes()
{
  Mesh mesh = Torus(500, 300);
  const std::vector<Triangle> once = mesh.triangles;
  for (unsigned i = 0; i < 5; ++i)
  {
    mesh.triangles.insert(mesh.triangles.end(), once.begin(), once.end());
  }
  return mesh;
}

// Adds this number of floats for each point and for each triangle, in arrays of at most four
// components.
Mesh WithManyBytes(Mesh mesh, std::size_t forPoints, std::size_t forCells)
{
  for (const auto association : { AttributeAssociation::Point, AttributeAssociation::Cell })
  {
    const bool points = association == AttributeAssociation::Point;
    for (std::size_t left = points ? forPoints : forCells; left > 0; left -= 4)
    {
      Attribute attribute{ { "a" + std::to_string(left), AttributeType::Float32, association, 4 },
        {} };
      attribute.values.resize(
        attribute.TupleSize() * (points ? mesh.points.size() : mesh.triangles.size()));
      mesh.attributes.push_back(std::move(attribute));
    }
  }
  return mesh;
}

}

// The passes of the methods differ only with less memory than programs need: TestExternalBuilder.
TEST_F(OutOfCore, OneStoreWhateverTheThreadsTheMemoryAndTheMedian)
{
  this->Write(Plate);
  this->ExpectOneStore({}, { { "--memory", "64M", "--threads", "1" },
                             { "--memory", "64M", "--threads", "2", "--median", "heaps" },
                             { "--memory", "96M", "--threads", "5", "--median", "torben" },
                             { "--memory", "96M", "--threads", "2", "--median", "sort" },
                             { "--memory", "64M", "--threads", "5", "--median", "histogram" },
                             { "--memory", "2G", "--threads", "2" } });
}

TEST_F(OutOfCore, AttributesAndDuplicatesTravel)
{
  this->Write(
    []
    {
      Mesh mesh = WithManyBytes(GridPlate(550), 8, 4);
      for (std::size_t i = 0; i < mesh.attributes.size(); ++i)
      {
        Attribute& attribute = mesh.attributes[i];
        attribute.name = i == 0 ? "weight" : attribute.name;
        for (std::size_t k = 0; k < attribute.values.size(); ++k)
        {
          attribute.values[k] = static_cast<std::uint8_t>(k * 7919 >> 11);
        }
      }
      Attribute colors{ { "RGB", AttributeType::UInt8, AttributeAssociation::Point, 3 }, {} };
      for (std::size_t k = 0; k < 3 * mesh.points.size(); ++k)
      {
        colors.values.push_back(static_cast<std::uint8_t>(k * k >> 9));
      }
      mesh.attributes.push_back(std::move(colors));
      for (std::size_t i = 0; i + 1 < mesh.points.size(); i += 50)
      {
        mesh.points[i] = mesh.points[i + 1]; // which has its own attributes
      }
      return mesh;
    });
  this->ExpectOneStore({ "--weld", "off", "--precision", "lossless" },
    { { "--memory", "64M", "--threads", "5", "--median", "sort" }, { "--memory", "2G" } });
  this->ExpectOneStore({}, { { "--memory", "64M", "--median", "heaps" }, { "--memory", "2G" } });
}

TEST_F(OutOfCore, StoresByTheOctreeAreTheSameToo)
{
  this->Write(Plate);
  const Arguments octree{ "--partitioner", "octree", "--precision", "lossless" };
  this->ExpectOneStore(octree, { { "--memory", "64M", "--threads", "1" },
                                 { "--memory", "96M", "--threads", "5" }, { "--memory", "2G" } });
  Arguments some = octree;
  some.insert(some.end(), { "--partitions", "300" });
  this->ExpectOneStore(some, { { "--memory", "64M" }, { "--memory", "2G" } });
}

TEST_F(OutOfCore, TheDragonIsTheSame)
{
  ASSERT_TRUE(fs::exists(KDSTREAM_DRAGON))
    << KDSTREAM_DRAGON << " is missing; Data/fetch-dragon fetches it";
  fs::create_symlink(KDSTREAM_DRAGON, this->Folder / "in.ply");
  this->ExpectOneStore(
    {}, { { "--memory", "64M", "--threads", "1", "--median", "torben" },
          { "--memory", "64M", "--threads", "5", "--median", "histogram" },
          { "--memory", "96M", "--threads", "2", "--median", "sort" },
          { "--memory", "96M", "--threads", "1", "--median", "heaps" }, { "--memory", "2G" } });
  this->ExpectOneStore({ "--precision", "lossless", "--weld", "off" },
    { { "--memory", "64M", "--threads", "2" }, { "--memory", "2G" } });
}

TEST_F(OutOfCore, StaysBelowTheMemoryLimit)
{
  if (fixtures::sanitized)
  {
    GTEST_SKIP() << "a sanitizer's own memory would count";
  }
  struct Case
  {
    const char* name;
    std::function<void()> write;
    unsigned mebibytes;
    const char* threads = "2";
  };
  const auto relief = [&]()
  {
    EXPECT_EQ(RunTool(this->Folder, "generate",
                { "relief", "in.ply", "--vertices", "2000000", "--shuffled", "--shuffled-vertices",
                  "--quiet" })
                .exitCode,
      0);
  };
  const Case cases[] = {
    { "relief", relief, 64 },
    { "relief, many threads", relief, 64, "24" },
    { "soup", [&] { this->Write([] { return Soup(300000, 1); }); }, 64 },
    { "larger soup", [&] { this->Write([] { return Soup(700000, 1); }); }, 128 },
    { "cloud",
      [&]
      {
        this->Write(
          []
          {
            Mesh mesh = Torus(1200, 1000);
            mesh.triangles.clear();
            return mesh;
          });
      },
      64 },
    { "attributes", [&] { this->Write([] { return WithManyBytes(Torus(500, 300), 60, 20); }); },
      64 },
    { "very wide attributes",
      [&] { this->Write([] { return WithManyBytes(Torus(150, 100), 600, 200); }); }, 64 },
    { "each face six times", [&] { this->Write(EachFaceSixTimes); }, 64 },
  };
  for (const Case& it : cases)
  {
    SCOPED_TRACE(it.name);
    it.write();
    for (const char* partitioner : { "kdtree", "octree" })
    {
      const Outcome outcome = this->Build({ "--memory", std::to_string(it.mebibytes) + "M",
        "--threads", it.threads, "--partitioner", partitioner });
      ASSERT_EQ(outcome.exitCode, 0) << outcome.err;
      EXPECT_GT(this->Stats()["temp_bytes"], 0);
      EXPECT_LE(outcome.peakBytes >> 20, it.mebibytes + 64) << "MiB, " << partitioner;
    }
  }
}

// A partition is never divided. If it does not fit into the limit, the build is refused; before any
// work, if the header gives enough information. If it fits, fewer partitions are processed at once.
TEST_F(OutOfCore, PartitionsFitTheMemoryOrAreRefused)
{
  if (fixtures::sanitized)
  {
    GTEST_SKIP() << "a sanitizer's own memory would count";
  }
  struct Case
  {
    const char* name;
    std::function<Mesh()> make;
    Arguments options;
    std::uint64_t mebibytes;
    bool fits;
  };
  const auto surface = [] { return Torus(1000, 600); }; // 600,000 vertices
  // 2,400,000 corners, which welding reduces to 400,000: too many to be welded in memory.
  const auto corners = [] { return Unwelded(Torus(800, 500)); };
  const Case cases[] = {
    { "one", surface, { "--partitions", "1" }, 64, false },
    { "two", surface, { "--vertices-per-partition", "300000" }, 64, false },
    { "eight", surface, { "--vertices-per-partition", "75000" }, 64, true },
    { "two, more memory", surface, { "--partitions", "2" }, 192, false },
    { "one, enough memory", surface, { "--partitions", "1" }, 448, true },
    { "two, enough memory", surface, { "--partitions", "2" }, 288, true },
    { "each face six times", EachFaceSixTimes, { "--partitions", "1" }, 128, false },
    { "each face six times, enough memory", EachFaceSixTimes, { "--partitions", "1" }, 320, true },
    { "attributes", [] { return WithManyBytes(Torus(500, 300), 60, 20); }, { "--partitions", "4" },
      64, false },
    { "corners", corners, { "--partitions", "1" }, 96, false },
    { "corners, smaller partitions", corners, { "--partitions", "4" }, 96, true },
  };
  for (const Case& it : cases)
  {
    SCOPED_TRACE(it.name);
    this->Write(it.make);
    Arguments options{ "--memory", std::to_string(it.mebibytes) + "M", "--threads", "2" };
    options.insert(options.end(), it.options.begin(), it.options.end());
    const Outcome outcome = this->Build(options);
    EXPECT_EQ(outcome.exitCode, it.fits ? 0 : 1) << outcome.err;
    EXPECT_LE(outcome.peakBytes >> 20, it.mebibytes + 16) << "MiB";
    if (!it.fits)
    {
      EXPECT_EQ(outcome.err.rfind("kdstream-build: error: in.ply: partitions of ", 0), 0U)
        << outcome.err;
      EXPECT_NE(
        outcome.err.find("the limit (--memory) is " + std::to_string(it.mebibytes) + " MiB"),
        std::string::npos)
        << outcome.err;
    }
    fs::remove(this->Folder / "m.kds");
    fs::remove(this->Folder / "s.json");
    this->ExpectNothingLeft();
  }
}

TEST_F(OutOfCore, AKilledBuildIsResumedAndAnInterruptedOneLeavesNothing)
{
  this->Write(Plate);
  std::string expected;
  const Json whole = this->StatsOf({ "--memory", "64M" }, expected);
  const auto all = static_cast<int>(1000 * whole["seconds"]["total"].get<double>());
  const Arguments build{ "in.ply", "-o", "m.kds", "--temp-dir", "spill", "--memory", "64M" };
  unsigned ended = 0;
  for (int i = 1; i < 8; ++i)
  {
    const std::chrono::milliseconds time(all * i / 8);
    if (this->BuildAndSignal(build, SIGKILL, time))
    {
      ++ended;
      // If the build is killed while it removes its temporary files, the store is complete, never
      // half of one.
      const fs::path left = this->Folder / "m.kds";
      EXPECT_TRUE(!fs::exists(left) || ReadWhole(left) == expected);
    }
    std::string store;
    const Json stats = this->StatsOf({ "--memory", "64M", "--resume" }, store);
    EXPECT_TRUE(store == expected) << "killed after " << time.count() << " ms";
    for (const char* step : { "read", "tree", "faces", "levels", "encode", "write", "total" })
    {
      EXPECT_TRUE(stats["seconds"].contains(step)) << step;
    }
  }
  EXPECT_GT(ended, 0U);
  for (const int signal : { SIGINT, SIGTERM })
  {
    for (int i = 1; i < 4; ++i)
    {
      this->BuildAndSignal(build, signal, std::chrono::milliseconds(all * i / 4));
      fs::remove(this->Folder / "m.kds"); // the store may be complete if the signal was late
      this->ExpectNothingLeft();
    }
  }
}

TEST_F(OutOfCore, ResumeReportsWhatItFound)
{
  this->Write(Plate);
  const Arguments build{ "in.ply", "-o", "m.kds", "--temp-dir", "spill", "--memory", "64M" };
  const auto resume = [&](const Arguments& more)
  {
    Arguments options = build;
    options.push_back("--resume");
    options.insert(options.end(), more.begin(), more.end());
    return RunTool(this->Folder, "build", options).err;
  };
  const auto expect = [](const std::string& said, const std::string& wanted)
  {
    EXPECT_NE(said.find("kdstream-build: " + wanted), std::string::npos)
      << said << "lacks: " << wanted;
  };
  const auto killed = [&]
  {
    // When the journal exists, a phase is finished.
    for (int milliseconds = 100; milliseconds < 20000; milliseconds += 100)
    {
      if (!this->BuildAndSignal(build, SIGKILL, std::chrono::milliseconds(milliseconds)))
      {
        break;
      }
      for (const fs::directory_entry& entry : fs::directory_iterator(this->Folder / "spill"))
      {
        if (fs::exists(entry.path() / "journal"))
        {
          return;
        }
      }
    }
    FAIL() << "no build was killed between its phases";
  };
  expect(resume({}),
    "nothing to resume: no earlier build in spill (did that build have another --temp-dir?)");
  killed();
  expect(resume({}), "continuing with the step ");
  killed();
  EXPECT_EQ(resume({ "--quiet" }), "");
  killed();
  const std::string startOver = "; its files are kept: build without --resume to start over";
  expect(resume({ "--title", "x" }), "error: in.ply: --resume: the interrupted build had other "
                                     "options, which --resume needs: --title none (now x)" +
                                       startOver);
  const auto time = fs::last_write_time(this->Folder / "in.ply");
  fs::last_write_time(this->Folder / "in.ply", time + std::chrono::seconds(1));
  expect(resume({}), "error: in.ply: --resume: the interrupted build had another input, or its "
                     "input has changed since" +
                       startOver);
  fs::last_write_time(this->Folder / "in.ply", time);
  // A build without --resume reports the files that it discards.
  expect(RunTool(this->Folder, "build", build).err,
    "there are files of a killed build of this store: --resume would continue it with the step ");
  this->ExpectNothingLeft({ "in.ply", "spill", "m.kds" });
}

TEST_F(OutOfCore, ErrorsNameTheTemporaryFolder)
{
  this->Write(Plate);
  const auto build = [&](const std::string& spill)
  {
    return RunTool(
      this->Folder, "build", { "in.ply", "-o", "m.kds", "--memory", "64M", "--temp-dir", spill });
  };
  const Outcome missing = build("no");
  EXPECT_EQ(missing.exitCode, 1);
  EXPECT_EQ(missing.err, "kdstream-build: error: no: there is no such folder\n");
  EXPECT_EQ(build("in.ply").err, "kdstream-build: error: in.ply: is a file, not a folder\n");
  const Outcome unwritable = build("/proc");
  EXPECT_EQ(unwritable.exitCode, 1);
  EXPECT_EQ(unwritable.err.rfind("kdstream-build: error: /proc: ", 0), 0U) << unwritable.err;
  this->ExpectNothingLeft();

  rlimit before{};
  ::getrlimit(RLIMIT_FSIZE, &before);
  rlimit small = before;
  small.rlim_cur = 5000000; // children inherit it
  ::setrlimit(RLIMIT_FSIZE, &small);
  const Outcome full = build("spill");
  ::setrlimit(RLIMIT_FSIZE, &before);
  EXPECT_EQ(full.exitCode, 1);
  EXPECT_EQ(
    full.err.rfind("kdstream-build: error: spill: the temporary folder is too small: the build "
                   "needs about ",
      0),
    0U)
    << full.err;
  EXPECT_EQ(full.err.find("spill", 30), std::string::npos) << "named twice: " << full.err;
  const auto mebibytes = std::stod(full.err.substr(full.err.find(" about ") + 7));
  this->ExpectNothingLeft();
  std::string store;
  const double taken =
    this->StatsOf({ "--memory", "64M" }, store)["temp_bytes"].get<double>() / (1 << 20);
  EXPECT_GE(mebibytes, taken);
  EXPECT_LE(mebibytes, 1.5 * taken);
  EXPECT_NE(full.err.find(" bytes, of which "), std::string::npos) << full.err;
  this->ExpectNothingLeft();
}
