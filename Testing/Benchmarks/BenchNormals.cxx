// SPDX-License-Identifier: BSD-3-Clause
// Do levels with the original's normals look more like the original than levels that use the same
// bytes for more vertices? (doc/decisions/0014-refine-by-the-view.md)
//
//   BenchNormals MESH.ply...
//
// Draws each level of a mesh from 12 directions, lit in different ways: by the normals of its own
// triangles, and by the mean of the original's normals under each vertex. These means are exact, or
// rounded to an octahedron's grid with different numbers of bits. Prints the medians of the share
// of wrong pixels (ComparedPictures.h). Also prints the cost of these normals: the entropy of their
// differences from the level's own normals, in bits for each vertex.
#include "Testing/Benchmarks/ComparedPictures.h"
#include "Testing/Benchmarks/WeldedMesh.h"
#include "filters/core/VectorMath.h"
#include "filters/core/drawing/PartNormals.h"
#include "filters/core/levels/Levels.h"
#include "viewer/session/Geometry.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <numeric>
#include <string>
#include <vector>

namespace
{

using namespace kdstream;
using namespace kdstream::bench;

constexpr int directions = 12;

// ---- an octahedron's grid

using Cell = std::array<int, 2>;

Cell OctahedronCell(const Vec3& n, int bits)
{
  const double sum = std::abs(n[0]) + std::abs(n[1]) + std::abs(n[2]);
  double u = sum > 0 ? n[0] / sum : 0, v = sum > 0 ? n[1] / sum : 0;
  if (n[2] < 0)
  {
    const double folded = (1 - std::abs(v)) * (u < 0 ? -1 : 1);
    v = (1 - std::abs(u)) * (v < 0 ? -1 : 1);
    u = folded;
  }
  const double steps = (1 << (bits / 2)) - 1;
  return { static_cast<int>(std::lround((0.5 * u + 0.5) * steps)),
    static_cast<int>(std::lround((0.5 * v + 0.5) * steps)) };
}

Vec3 NormalOfCell(const Cell& cell, int bits)
{
  const double steps = (1 << (bits / 2)) - 1;
  double u = 2 * cell[0] / steps - 1, v = 2 * cell[1] / steps - 1;
  const double z = 1 - std::abs(u) - std::abs(v);
  if (z < 0)
  {
    const double folded = (1 - std::abs(v)) * (u < 0 ? -1 : 1);
    v = (1 - std::abs(u)) * (v < 0 ? -1 : 1);
    u = folded;
  }
  return { u, v, z };
}

double EntropyOf(const std::vector<int>& values)
{
  std::map<int, double> counts;
  for (const int value : values)
  {
    ++counts[value];
  }
  return std::accumulate(counts.begin(), counts.end(), 0.0,
    [n = double(values.size())](double sum, const auto& count)
    { return sum - count.second / n * std::log2(count.second / n); });
}

// The entropy of the differences between grid cells, in bits for each vertex.
double CostOf(const std::vector<Vec3>& reported, const std::vector<Vec3>& known, int bits)
{
  std::vector<int> u, v;
  for (std::size_t i = 0; i < reported.size(); ++i)
  {
    const Cell a = OctahedronCell(reported[i], bits), b = OctahedronCell(known[i], bits);
    u.push_back(a[0] - b[0]);
    v.push_back(a[1] - b[1]);
  }
  return EntropyOf(u) + EntropyOf(v);
}

// ---- scenes

std::vector<Vec3> SumsOfNormals(
  const std::vector<Vec3>& points, const std::vector<Triangle>& triangles)
{
  std::vector<Vec3> sums(points.size(), Vec3{});
  for (const Triangle& t : triangles)
  {
    const Vec3 area = Cross(Minus(points[t[1]], points[t[0]]), Minus(points[t[2]], points[t[0]]));
    for (const VertexId corner : t)
    {
      sums[corner] = Plus(sums[corner], area);
    }
  }
  return sums;
}

std::shared_ptr<const DrawnSurface> SurfaceOf(const std::vector<Vec3>& points,
  const std::vector<Triangle>& triangles, const std::vector<Vec3>& normals)
{
  auto part = std::make_shared<SurfacePart>();
  part->own.resize(points.size());
  std::iota(part->own.begin(), part->own.end(), 0U);
  part->surface.points = points;
  part->surface.triangles = triangles;
  part->surface.sources.resize(points.size());
  return std::make_shared<const DrawnSurface>(SurfacePartList{ part },
    std::vector<PartNormals::Normals>{ std::make_shared<const std::vector<Vec3>>(normals) });
}

// A scene seen from one of the directions, so that the whole box is visible.
ViewerScene SceneFrom(int direction, const Box& box)
{
  ViewerScene scene;
  scene.box = box;
  scene.focal = box.lo * 0.5 + box.hi * 0.5;
  const double around = direction % 4 * std::acos(0.0), over = direction / 4 * 0.6 - 0.6;
  const Vec3 back{ std::sin(around) * std::cos(over), std::sin(over),
    std::cos(around) * std::cos(over) };
  const double radius = 0.5 * Length(box.hi - box.lo);
  scene.eye = scene.focal + back * (radius / std::sin(0.5 * scene.viewAngle));
  return scene;
}

double Median(std::vector<double> values)
{
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

void Bench(const std::string& file, Painter& painter)
{
  const Mesh mesh = ReadWelded(file);
  const KdTree tree = Need(BuildKdTree(mesh.points, {}));
  const std::vector<std::uint32_t> partition = CellOfVertex(tree, tree.depths.partition);
  const TriangleBuckets buckets = BucketTriangles(mesh.triangles,
    std::size_t{ 1 } << tree.depths.partition, [&](VertexId v) { return partition[v]; });
  const ClusterLevels levels = Need(BuildLevels(mesh, tree, buckets, LevelOptions{}));
  const std::vector<Vec3> original = SumsOfNormals(mesh.points, mesh.triangles);
  std::vector<WindowPicture> originals, backgrounds;
  for (int i = 0; i < directions; ++i)
  {
    ViewerScene scene = SceneFrom(i, tree.boxes[1]);
    scene.surface = SurfaceOf(mesh.points, mesh.triangles, original);
    originals.push_back(painter.Draw(scene));
    scene.surface = std::make_shared<const DrawnSurface>();
    backgrounds.push_back(painter.Draw(scene));
  }
  std::printf("%s\n%5s %9s %8s %8s |", std::filesystem::path(file).stem().c_str(), "level",
    "vertices", "own", "exact");
  const std::array<int, 4> grids{ 6, 8, 10, 12 };
  for (const int bits : grids)
  {
    std::printf(" %2d bits: coded %%", bits);
  }
  std::printf("\n");
  std::vector<VertexId> clusterOf = levels.finest;
  for (std::size_t depth = levels.levels.size(); depth-- > 11;)
  {
    const ClusterLevel& level = levels.levels[depth];
    std::vector<Vec3> means(level.positions.size(), Vec3{});
    for (VertexId v = 0; v < mesh.points.size(); ++v)
    {
      means[clusterOf[v]] = Plus(means[clusterOf[v]], original[v]);
    }
    const std::vector<Vec3> own = SumsOfNormals(level.positions, level.triangles);
    const auto wrong = [&](const std::vector<Vec3>& normals)
    {
      std::vector<double> shares;
      const auto surface = SurfaceOf(level.positions, level.triangles, normals);
      for (int i = 0; i < directions; ++i)
      {
        ViewerScene scene = SceneFrom(i, tree.boxes[1]);
        scene.surface = surface;
        const auto at = static_cast<std::size_t>(i);
        shares.push_back(ShareOfWrong(painter.Draw(scene), originals[at], backgrounds[at]));
      }
      return 100 * Median(shares);
    };
    std::printf("%5zu %9zu %8.2f %8.2f |", depth, means.size(), wrong(own), wrong(means));
    for (const int bits : grids)
    {
      std::vector<Vec3> rounded;
      std::transform(means.begin(), means.end(), std::back_inserter(rounded),
        [bits](const Vec3& n) { return NormalOfCell(OctahedronCell(n, bits), bits); });
      std::printf("   %6.2f %7.2f", CostOf(means, own, bits), wrong(rounded));
    }
    std::printf("\n");
    for (VertexId& cluster : clusterOf)
    {
      cluster = level.parents.empty() ? cluster : level.parents[cluster];
    }
  }
}

}

int main(int count, char** arguments)
{
  if (count < 2)
  {
    std::fprintf(stderr, "usage: BenchNormals MESH.ply...\n");
    return 2;
  }
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  Painter painter;
  for (int i = 1; i < count; ++i)
  {
    Bench(arguments[i], painter);
  }
  return 0;
}
