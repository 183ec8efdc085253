// SPDX-License-Identifier: BSD-3-Clause
// TestBuildMpi runs this on the ranks of a job. It builds difficult meshes twice: on all ranks,
// with so little memory for each step that everything is done in parts; and by one process in
// memory. The stores must be the same. Usage: RanksAgainstOne FOLDER; exit code 1, and a line for
// each store that differs. The second argument "throws" checks instead that an exception on one
// rank is an error on all; "room" checks that all are informed if one rank has no memory for what
// it would receive.
#include "Testing/Fixtures/Attributes.h"
#include "Testing/Fixtures/Meshes.h"
#include "filters/Parallel/DistributedBuilder.h"
#include "filters/Parallel/MpiGroup.h"
#include "filters/Parallel/MpiJob.h"
#include "filters/build/Builder.h"
#include "filters/meshio/MeshWriter.h"

#include <cstdlib>
#include <fstream>
#include <iostream>
#include <sstream>
#include <stdexcept>
#include <string_view>

#include <sys/resource.h>
#include <unistd.h>

namespace
{

using namespace kdstream;
using namespace kdstream::fixtures;

constexpr std::uint64_t little = std::uint64_t{ 1 } << 14;

struct Way
{
  const char* name;
  BuildOptions options;
  std::uint64_t stepMemory = 0; // 0: as options.memory allows
};

std::vector<Way> Ways()
{
  std::vector<Way> ways{ { "collapse", {} }, { "collapse, not welded, little memory", {}, little },
    { "clusters, not welded, little memory", {}, little },
    { "clusters without sheets, lossless", {}, 64 * little } };
  for (Way& way : ways)
  {
    way.options.memory = std::uint64_t{ 64 } << 20;
  }
  ways[0].options.tree = { 40, {}, 4 };
  ways[1].options.tree = { 6, {}, 2 };
  ways[1].options.weld = false;
  ways[2].options.tree = { 20, {}, 1 };
  ways[2].options.weld = false;
  ways[2].options.levels.maker = LevelMaker::Cluster;
  ways[3].options.tree = { 40, {}, 2 };
  ways[3].options.levels.maker = LevelMaker::Cluster;
  ways[3].options.levels.byComponents = false;
  ways[3].options.bits = 0;
  return ways;
}

// Describes the store and the report.
std::string Describe(const Result<BuildReport>& report)
{
  std::ostringstream text;
  if (!report)
  {
    text << "error: " << report.GetError().message;
    return text.str();
  }
  text << report->info.digest << ", " << (report->info.unused ? report->info.unused->vertices : 0)
       << " unused, " << report->info.welded << " welded, " << report->info.inconsistentEdges
       << " inconsistent, " << report->mergedByGrid << " merged";
  for (const ScalarDescription& scalar : report->info.scalars)
  {
    text << ", " << scalar.name << " " << scalar.least << " " << scalar.low << " " << scalar.high
         << " " << scalar.most << " " << scalar.classes.size();
  }
  return text.str();
}

// Unused vertices come before all others, so that only the first rank reads them. Some occur twice;
// some are in the same place as a used vertex.
Mesh WithUnused()
{
  Mesh mesh = Shuffled(DisplacedSphere(3), 4);
  std::vector<Vec3> unused(mesh.points.end() - 50, mesh.points.end());
  for (int i = 0; i < 150; ++i)
  {
    unused.push_back({ double(i % 100), 1e6, -double(i % 100) });
  }
  mesh.points.insert(mesh.points.begin(), unused.begin(), unused.end());
  for (Triangle& triangle : mesh.triangles)
  {
    for (VertexId& corner : triangle)
    {
      corner += static_cast<VertexId>(unused.size());
    }
  }
  return mesh;
}

class Comparison
{
public:
  Comparison(MpiGroup& group, std::filesystem::path folder)
    : Group(group)
    , Folder(std::move(folder))
  {
  }

  void Check(const NamedMesh& named, const Way& way)
  {
    const std::filesystem::path file = this->Folder / "mesh.ply";
    if (this->Group.IsFirst() && !WriteMesh(file, named.mesh))
    {
      std::cout << "cannot write " << file << '\n';
    }
    (void)this->Group.Finish(); // now all ranks see the file
    const Result<BuildReport> collective = BuildStoreCollectively(
      this->Group, file, this->Folder / "some.kds", way.options, {}, way.stepMemory);
    if (this->Group.IsFirst())
    {
      BuildOptions options = way.options;
      options.memory = 0;
      const std::string expected = Describe(BuildStore(file, this->Folder / "one.kds", options));
      if (Describe(collective) != expected)
      {
        this->AnyDiffers = true;
        std::cout << named.name << ", " << way.name << ": " << Describe(collective)
                  << " instead of " << expected << '\n';
      }
    }
    this->AnyDiffers |= !collective; // the ranks cannot exchange anything more
  }
  bool Differs() const { return this->AnyDiffers; }

private:
  MpiGroup& Group;
  std::filesystem::path Folder;
  bool AnyDiffers = false;
};

// Rank 1 throws an exception in the middle of its build, as a library may.
bool AllHearOfAnException(MpiGroup& group, const std::filesystem::path& folder)
{
  const std::filesystem::path file = folder / "mesh.ply";
  if (group.IsFirst() && !WriteMesh(file, DisplacedSphere(3)))
  {
    std::cout << "cannot write " << file << '\n';
  }
  (void)group.Finish(); // now all ranks see the file
  Execution execution;
  if (group.Rank() == 1)
  {
    execution.progress = [](std::string_view, double) -> bool
    { throw std::runtime_error("a library has failed"); };
  }
  BuildOptions options;
  options.memory = std::uint64_t{ 64 } << 20;
  const std::string said =
    Describe(BuildStoreCollectively(group, file, folder / "some.kds", options, execution));
  const bool heard = said.starts_with("error: unexpected: a library has failed (rank 1 on ");
  if (!heard)
  {
    std::cout << "rank " << group.Rank() << ": " << said << '\n';
  }
  return heard;
}

// Rank 1 has too little memory for the bytes that rank 0 would send.
bool AllHearOfNoMemory(MpiGroup& group)
{
  constexpr std::uint64_t bytes = std::uint64_t{ 1 } << 28;
  if (group.Rank() == 1)
  {
    std::uint64_t pages = 0;
    std::ifstream("/proc/self/statm") >> pages;
    const rlim_t most = pages * static_cast<rlim_t>(::sysconf(_SC_PAGESIZE)) + bytes / 2;
    const rlimit limit{ most, most };
    ::setrlimit(RLIMIT_AS, &limit);
  }
  std::vector<VertexId> numbers(group.IsFirst() ? bytes / sizeof(VertexId) : 0);
  const Status reported = group.Run([&] { return group.Spread(numbers); });
  const std::string said = reported ? "" : reported.GetError().message;
  const bool heard = said.starts_with("out of memory (rank 1 on ");
  if (!heard)
  {
    std::cout << "rank " << group.Rank() << ": " << said << '\n';
  }
  return heard;
}

}

int main(int argc, char** argv)
{
  MpiJob job(argc, argv);
  MpiGroup group(job.Messages());
  const std::filesystem::path folder = argc > 1 ? argv[1] : ".";
  if (argc > 2)
  {
    const bool heard = std::string_view(argv[2]) == "room" ? AllHearOfNoMemory(group)
                                                           : AllHearOfAnException(group, folder);
    return heard ? 0 : 1;
  }
  Comparison comparison(group, folder);
  std::vector<NamedMesh> meshes = AllMeshes();
  meshes.push_back(
    { "sphere with attributes", WithAttributes(Shuffled(DisplacedSphere(3), 5), 3) });
  meshes.push_back({ "soup with attributes", WithAttributes(Soup(100, 4), 6) });
  meshes.push_back({ "unused vertices with attributes", WithAttributes(WithUnused(), 7) });
  meshes.push_back({ "unused vertices of one rank, and twins", WithUnused() });
  const std::vector<Way> ways = Ways();
  for (const NamedMesh& named : meshes)
  {
    for (const Way& way : ways)
    {
      comparison.Check(named, way);
    }
  }
  // Levels below S that are too large to be in memory.
  comparison.Check({ "large cloud", Shuffled(Cloud(6), 3) }, ways[2]);
  comparison.Check({ "large soup", Soup(12000, 8) }, ways[2]);
  return comparison.Differs() ? 1 : 0;
}
