// SPDX-License-Identifier: BSD-3-Clause
// Writes the small stores of Corpus/FuzzStore, from which the fuzz targets start: one store of each
// kind, as small as possible. Usage: WriteSmallStores FOLDER
#include "filters/baselines/stores/Baselines.h"
#include "filters/build/Builder.h"

#include <cmath>
#include <cstdio>
#include <filesystem>

namespace
{

using namespace kdstream;

Mesh Tetrahedron()
{
  Mesh mesh;
  mesh.points = { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 } };
  mesh.triangles = { { 0, 1, 2 }, { 0, 2, 3 }, { 0, 3, 1 }, { 1, 3, 2 } };
  return mesh;
}

// A surface of side × side coloured vertices.
Mesh Sheet(std::uint32_t side)
{
  Mesh mesh;
  Attribute colors{ { "RGB", AttributeType::UInt8, AttributeAssociation::Point, 3 }, {} };
  colors.values.resize(std::size_t{ side } * side * colors.TupleSize());
  for (std::uint32_t i = 0; i < side * side; ++i)
  {
    const double x = i % side, y = i / side;
    mesh.points.push_back({ x, y, std::sin(x) * std::cos(y) });
    colors.Set(i, 0, 20 * x);
    if (i % side != 0 && i >= side)
    {
      mesh.triangles.push_back({ i, i - 1, i - side });
      mesh.triangles.push_back({ i - 1, i - side - 1, i - side });
    }
  }
  mesh.attributes = { std::move(colors) };
  return mesh;
}

bool Write(const std::filesystem::path& file, Mesh mesh, const BuildOptions& options)
{
  const auto report = BuildStore(std::move(mesh), "mesh.ply", file, options);
  if (!report)
  {
    std::fprintf(
      stderr, "WriteSmallStores: error: %s: %s\n", file.c_str(), report.GetError().message.c_str());
  }
  return report.HasValue();
}

}

int main(int argc, char** argv)
{
  if (argc != 2)
  {
    std::fprintf(stderr, "usage: WriteSmallStores FOLDER\n");
    return 2;
  }
  const std::filesystem::path folder = argv[1];
  BuildOptions plain, lossless, parts, octree;
  lossless.bits = 0;
  parts.tree.partitions = 8;
  parts.title = "A sheet";
  octree.partitioner = &OctreeMethod();
  octree.tree.partitions = 4;
  Mesh points = Tetrahedron();
  points.triangles.clear();
  Mesh strays = Sheet(5);
  strays.triangles.resize(12); // only half of its vertices remain in use
  const bool good =
    Write(folder / "tetrahedron.kds", Tetrahedron(), plain) &&
    Write(folder / "lossless.kds", Tetrahedron(), lossless) &&
    Write(folder / "points.kds", points, plain) && Write(folder / "sheet.kds", Sheet(9), parts) &&
    Write(folder / "octree.kds", Sheet(5), octree) && Write(folder / "unused.kds", strays, plain);
  return good ? 0 : 1;
}
