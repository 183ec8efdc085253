// SPDX-License-Identifier: BSD-3-Clause
#include "Testing/Faults/Operations.h"

#include "Testing/Fixtures/Meshes.h"
#include "filters/meshio/MeshWriter.h"
#include "server/access/QuotaBook.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>

namespace kdstream::fixtures
{

std::string ProgramPath(const std::string& name)
{
  return std::string(KDSTREAM_PROGRAMS) + "/" + name;
}

FileTree TreeAfter(const Operation& operation)
{
  const TemporaryFolder folder;
  WriteTree(folder.Path, operation.before);
  FaultyProgram program(
    faultLibrary, folder.Path, ProgramPath(operation.program), operation.arguments);
  const auto outcome = program.Run();
  EXPECT_EQ(outcome.exitCode, 0) << operation.name << ": " << outcome.err;
  return ReadTree(folder.Path);
}

namespace
{

std::string MeshFile(unsigned subdivisions)
{
  const TemporaryFolder folder;
  EXPECT_TRUE(WriteMesh(folder / "mesh.ply", DisplacedSphere(subdivisions)));
  return ReadWhole(folder / "mesh.ply");
}

// No name may occur twice in the output of a test run: each operation starts from the output of the
// previous one.
std::vector<Operation> MakeOperations()
{
  const std::string mesh = MeshFile(2), other = MeshFile(1);
  const std::vector<std::string> small{ "--vertices-per-partition=40", "--threads=1", "--quiet" };
  const auto with = [&](std::vector<std::string> begin)
  {
    begin.insert(begin.end(), small.begin(), small.end());
    return begin;
  };
  std::vector<Operation> all;
  all.push_back({ "build", "kdstream-build", with({ "mesh.ply", "-o", "new/a.kds" }),
    { { "mesh.ply", mesh } } });
  const auto built = TreeAfter(all.back()).at("new/a.kds");
  all.push_back({ "rebuild", "kdstream-build", with({ "mesh.ply", "-o", "a.kds" }),
    { { "mesh.ply", other }, { "a.kds", built } } });
  all.push_back({ "external", "faulty-work", { "build", "mesh.ply", "a.kds" },
    { { "mesh.ply", mesh }, { "a.kds", "nothing" } } });
  all.push_back({ "edit", "kdstream-store",
    { "edit", "a.kds", "--title", "Another", "--up=0,0,1", "--quiet" }, { { "a.kds", built } } });
  const auto edited = TreeAfter(all.back()).at("a.kds");
  all.push_back({ "verify", "kdstream-store", { "verify", "a.kds" }, { { "a.kds", built } } });
  all.push_back(
    { "extract", "kdstream-store", { "extract", "a.kds", "--all", "-o", "out/b.ply", "--quiet" },
      { { "a.kds", built }, { "out/", "" } } });
  all.push_back({ "notes", "faulty-work", { "notes", "a.notes.json" },
    { { "a.notes.json", "{\"notes\": []}\n" } } });
  const auto notes = TreeAfter(all.back()).at("a.notes.json");
  all.push_back({ "export", "kdstream-store", { "export", "a.kds", "web/up", "--quiet" },
    { { "a.kds", built }, { "a.notes.json", notes } } });
  // There is already another model, which must stay in the list.
  auto up = TreeAfter({ "", "kdstream-store",
    { "export", "a.kds", "web/up", "--model=b", "--quiet" }, TreeAfter(all.back()) });
  up["a.kds"] = edited;
  all.push_back(
    { "exportagain", "kdstream-store", { "export", "a.kds", "web/up", "--quiet" }, up });
  up["a.kds"] = TreeAfter(all[1]).at("a.kds");
  all.push_back(
    { "exportanother", "kdstream-store", { "export", "a.kds", "web/up", "--quiet" }, up });
  all.push_back({ "tiles", "kdstream-store",
    { "export", "a.kds", "web/tiles", "--format=3dtiles", "--quiet" }, { { "a.kds", built } } });
  all.back().repeats = false;
  all.push_back(
    { "glb", "kdstream-store", { "export", "a.kds", "out/a.glb", "--format=glb", "--quiet" },
      { { "a.kds", built }, { "out/", "" } } });
  Operation quotas{ "quotas", "faulty-work", { "quotas", "quotas.db" }, {} };
  quotas.others = { "quotas.db", "quotas.db-wal", "quotas.db-shm", "quotas.db-journal" };
  quotas.recovers = true;
  // Partitions that were given count, and no more may be given than the quota allows.
  quotas.check = [](const FaultyProgram::Outcome& outcome, const std::filesystem::path& folder)
  {
    std::istringstream said(outcome.out);
    std::string what, given;
    std::uint32_t partition = 0;
    std::set<std::uint32_t> had;
    while (said >> what >> partition)
    {
      given += what == "given" ? "" : "refused ";
      had.insert(partition);
    }
    QuotaLimits limits;
    limits.share = 0.5;
    const auto book = QuotaBook::Open(folder / "quotas.db", limits);
    if (!book)
    {
      return "the book does not open: " + book.GetError().message;
    }
    std::uint32_t more = 0;
    for (std::uint32_t p = 0; p < 8; ++p)
    {
      const auto taken = (*book)->TakePartition("ann", { "model", "input", "tree", 8 }, p, 100);
      if (!taken)
      {
        return "nothing can be taken: " + taken.GetError().message;
      }
      given += had.count(p) != 0 && *taken ? "lost " + std::to_string(p) + " " : "";
      more += had.count(p) == 0 && !*taken ? 1 : 0;
    }
    return had.size() + more > 4 ? given + "more was given" : given;
  };
  all.push_back(quotas);
  return all;
}

}

const Operation& OperationOf(const std::string& name)
{
  static const std::vector<Operation> all = MakeOperations();
  return *std::find_if(all.begin(), all.end(), [&](const auto& each) { return each.name == name; });
}

}
