// SPDX-License-Identifier: BSD-3-Clause
// The content of stores over the versions of KdStream: a build today must give the same bytes as
// before. Digests.txt has a line for each mesh and way to build it. Lines there may change only if
// a format or an algorithm changes.
#include "Testing/Fixtures/Attributes.h"
#include "Testing/Fixtures/Meshes.h"
#include "filters/baselines/stores/Baselines.h"
#include "filters/build/Builder.h"
#include "filters/program/TbbExecution.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <sstream>

using namespace kdstream;
using namespace kdstream::fixtures;
namespace fs = std::filesystem;

namespace
{

struct Way
{
  std::string name;
  BuildOptions options;
};

std::vector<Way> Ways()
{
  BuildOptions usual;
  usual.tree.verticesPerPartition = 150;
  usual.levels.maker = LevelMaker::Collapse;
  std::vector<Way> ways{ { "usual", usual } };

  Way lossless{ "lossless", usual };
  lossless.options.bits = 0;
  lossless.options.weld = false;
  ways.push_back(lossless);

  Way clusters{ "clusters", usual };
  clusters.options.levels.maker = LevelMaker::Cluster;
  ways.push_back(clusters);

  Way paper{ "paper", usual }; // exactly the method of the paper
  paper.options.levels.maker = LevelMaker::Cluster;
  paper.options.levels.representative = Representative::Mean;
  paper.options.levels.byComponents = false;
  paper.options.bits = 14;
  ways.push_back(paper);

  Way octree{ "octree", usual };
  octree.options.partitioner = &OctreeMethod();
  ways.push_back(octree);
  return ways;
}

std::vector<NamedMesh> Inputs()
{
  std::vector<NamedMesh> inputs = AllMeshes();
  inputs.push_back({ "sphere with attributes", WithAttributes(DisplacedSphere(4), 7) });
  inputs.push_back({ "shuffled torus", Shuffled(Torus(60, 40), 3) });
  return inputs;
}

std::string DigestOf(const NamedMesh& input, const Way& way, const fs::path& file)
{
  const Result<BuildReport> report =
    BuildStore(input.mesh, input.name, file, way.options, MakeTbbExecution(2));
  fs::remove(file);
  return report ? report->info.digest : "error: " + report.GetError().message;
}

TEST(Digests, AreThoseOfEarlierVersions)
{
  std::map<std::string, std::string> expected; // by mesh and way
  std::ifstream lines(KDSTREAM_DIGESTS);
  for (std::string line; std::getline(lines, line);)
  {
    const auto colon = line.find(": ");
    ASSERT_NE(colon, std::string::npos) << line;
    expected.emplace(line.substr(0, colon), line.substr(colon + 2));
  }
  ASSERT_GT(expected.size(), 100U) << KDSTREAM_DIGESTS;

  const fs::path file =
    fs::temp_directory_path() / ("kdstream-digests-" + std::to_string(::getpid()) + ".kds");
  std::ostringstream built;
  for (const NamedMesh& input : Inputs())
  {
    for (const Way& way : Ways())
    {
      const std::string what = input.name + ", " + way.name;
      const std::string digest = DigestOf(input, way, file);
      built << what << ": " << digest << "\n";
      EXPECT_EQ(digest, expected[what]) << what;
      expected.erase(what);
    }
  }
  for (const auto& [what, digest] : expected)
  {
    ADD_FAILURE() << what << " is no longer built";
  }
  if (HasFailure())
  {
    const fs::path all = fs::temp_directory_path() / "Digests.txt";
    std::ofstream(all) << built.str();
    std::cerr << "What was built stands in " << all << "\n";
  }
}

}
