// SPDX-License-Identifier: BSD-3-Clause
// How much of a mesh's vertex colours its levels keep, and what that costs in shape
// (doc/benchmarks.md#colours).
//
//   BenchColors OUTPUT_FOLDER MESH.ply...
//
// Compares levels of coloured meshes with levels of the same meshes that ignore colours and get the
// means of their vertices' colours. The comparison is: the difference between pictures without
// light and the original's pictures, from 24 cameras, in grey values; the distance of the surfaces
// (RMS, the larger direction) in % of the diagonal; and the ratios. Writes a picture of each at
// about 16,000 and 4,000 triangles. Exit code 1 if a limit is missed.
#include "Testing/Benchmarks/FlatPictures.h"
#include "Testing/Benchmarks/WeldedMesh.h"
#include "filters/core/MeshDistance.h"
#include "filters/core/levels/CollapseAttributes.h"
#include "filters/core/levels/LevelAttributes.h"
#include "filters/core/levels/Levels.h"
#include "filters/program/TbbExecution.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

namespace
{

using namespace kdstream;
using namespace kdstream::bench;

constexpr std::size_t samples = 100000, side = 640;
constexpr unsigned coarsest = 9;

// The limits for levels with this number of triangles: errors of colours and of shape, relative to
// those of levels that ignore colours.
struct Bar
{
  std::size_t least, most;
  double color, shape;
};
constexpr Bar bars[] = { { 12000, 20000, 0.5, 1.1 }, { 3000, 5000, 0.9, 1.15 } };

struct Figure
{
  std::size_t triangles = 0;
  double color = 0, rms = 0;
};

class ColorBenchmark
{
public:
  ColorBenchmark(const std::string& folder, const std::string& file, const Execution& execution)
    : Stem(folder + "/paint-" + std::filesystem::path(file).stem().string())
    , Exec(execution)
    , Input(ReadWelded(file, true))
    , Colors(FindVertexColors(this->Input.attributes))
    , Tree(Need(BuildKdTree(this->Input.points, {})))
    , Painter(this->Tree.boxes[1], side)
  {
  }

  bool HasColors() const { return this->Colors != nullptr; }

  // Returns whether all limits are met.
  bool Run()
  {
    this->Originals =
      this->Painter.DrawAll(this->Input.points, this->Input.triangles, *this->Colors);
    this->Write(this->Originals[8], "original");
    const ClusterLevels colored = this->LevelsOf(this->Input);
    Mesh shape{ this->Input.points, this->Input.triangles };
    ClusterLevels bare = this->LevelsOf(shape);
    AddLevelAttributes(this->Input, bare);
    std::printf("%s: %zu triangles\n%5s | %9s %7s %7s | %9s %7s %7s | %6s %6s\n",
      this->Stem.c_str(), this->Input.triangles.size(), "level", "triangles", "colours", "shape",
      "triangles", "colours", "shape", "ratios", "");
    bool met = true;
    for (std::size_t depth = colored.levels.size(); depth-- > coarsest;)
    {
      const Figure a = this->Measure(colored.levels[depth], "paint-" + std::to_string(depth));
      const Figure b = this->Measure(bare.levels[depth], "shape-" + std::to_string(depth));
      const double color = a.color / b.color, rms = a.rms / b.rms;
      std::printf("%5zu | %9zu %7.2f %7.4f | %9zu %7.2f %7.4f | %6.3f %6.3f\n", depth, a.triangles,
        a.color, a.rms, b.triangles, b.color, b.rms, color, rms);
      const Bar* const bar = BarOf(a);
      met = met && (!bar || (color <= bar->color && rms <= bar->shape));
    }
    return met;
  }

private:
  ClusterLevels LevelsOf(const Mesh& mesh) const
  {
    const std::vector<std::uint32_t> partition =
      CellOfVertex(this->Tree, this->Tree.depths.partition);
    const TriangleBuckets buckets = BucketTriangles(mesh.triangles,
      std::size_t{ 1 } << this->Tree.depths.partition, [&](VertexId v) { return partition[v]; });
    return Need(BuildLevels(mesh, this->Tree, buckets, LevelOptions{}, this->Exec));
  }

  static const Bar* BarOf(const Figure& figure)
  {
    const auto bar = std::find_if(std::begin(bars), std::end(bars),
      [&](const Bar& b) { return figure.triangles >= b.least && figure.triangles <= b.most; });
    return bar == std::end(bars) ? nullptr : bar;
  }

  Figure Measure(const ClusterLevel& level, const std::string& name) const
  {
    const auto pictures =
      this->Painter.DrawAll(level.positions, level.triangles, *FindVertexColors(level.attributes));
    const MeshDistance d = Need(MeasureDistance(
      this->Input, Mesh{ level.positions, level.triangles }, { samples, 1 }, this->Exec));
    const Figure figure{ level.triangles.size(), MeanDifference(pictures, this->Originals),
      std::max(d.rmsForward, d.rmsBackward) * 100 / d.diagonal };
    if (BarOf(figure))
    {
      this->Write(pictures[8], name);
    }
    return figure;
  }

  void Write(const FlatPicture& picture, const std::string& name) const
  {
    const Status written = this->Painter.WritePpm(picture, this->Stem + "-" + name + ".ppm");
    if (!written)
    {
      std::fprintf(stderr, "error: %s\n", written.GetError().message.c_str());
      std::exit(2);
    }
  }

  std::string Stem;
  const Execution& Exec;
  Mesh Input;
  const Attribute* Colors;
  KdTree Tree;
  FlatPainter Painter;
  std::vector<FlatPicture> Originals;
};

}

int main(int count, char** arguments)
{
  if (count < 3)
  {
    std::fprintf(stderr, "usage: BenchColors OUTPUT_FOLDER MESH.ply...\n");
    return 2;
  }
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  const Execution execution = MakeTbbExecution(0);
  bool met = true;
  for (int i = 2; i < count; ++i)
  {
    ColorBenchmark benchmark(arguments[1], arguments[i], execution);
    if (!benchmark.HasColors())
    {
      std::fprintf(stderr, "error: %s is not painted\n", arguments[i]);
      return 2;
    }
    met = benchmark.Run() && met;
  }
  std::printf("bars %s\n", met ? "met" : "MISSED");
  return met ? 0 : 1;
}
