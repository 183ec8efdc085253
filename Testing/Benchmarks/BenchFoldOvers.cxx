// SPDX-License-Identifier: BSD-3-Clause
// How many triangles of each level face the wrong way (Testing/Fixtures/FoldOvers.h), on made-up
// meshes and on files:
//   BenchFoldOvers [MESH.ply …]
#include "Testing/Benchmarks/WeldedMesh.h"
#include "Testing/Fixtures/FoldOvers.h"
#include "Testing/Fixtures/Meshes.h"
#include "filters/core/levels/Levels.h"

#include <cstdio>
#include <filesystem>

namespace
{

using namespace kdstream;
using namespace kdstream::bench;

void Print(const std::string& name, const Mesh& mesh)
{
  constexpr std::size_t fewest = 200; // a level with fewer triangles is skipped
  const KdTree tree = Need(BuildKdTree(mesh.points, {}));
  const std::vector<std::uint32_t> partition = CellOfVertex(tree, tree.depths.partition);
  const TriangleBuckets buckets = BucketTriangles(mesh.triangles,
    std::size_t{ 1 } << tree.depths.partition, [&](VertexId v) { return partition[v]; });
  const ClusterLevels levels = Need(BuildLevels(mesh, tree, buckets, LevelOptions{}));
  const std::vector<fixtures::FoldOverCount> counts = fixtures::CountFoldOvers(mesh, levels);
  for (std::size_t depth = counts.size(); depth-- > 0;)
  {
    const fixtures::FoldOverCount& count = counts[depth];
    if (count.triangles >= fewest)
    {
      std::printf("%-16s %5zu %10zu %8zu %9.4f %9.4f %8zu\n", name.c_str(), depth, count.triangles,
        count.opposed, 100.0 * double(count.opposed) / double(count.triangles),
        100 * count.opposedArea, count.opposedNearest);
    }
  }
}

}

int main(int argc, char** argv)
{
  std::printf("%-16s %5s %10s %8s %9s %9s %8s\n", "triangles that face the wrong way", "level",
    "triangles", "opposed", "%", "% of area", "by nearest vertex");
  Print("sphere", fixtures::DisplacedSphere(7));
  Print("height field", fixtures::HeightField(400));
  Print("thin plate", fixtures::ThinPlate(200));
  Print("torus", fixtures::Torus(300, 120));
  for (int i = 1; i < argc; ++i)
  {
    Print(std::filesystem::path(argv[i]).stem().string(), ReadWelded(argv[i]));
  }
  return 0;
}
