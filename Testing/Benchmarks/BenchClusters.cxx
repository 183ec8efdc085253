// SPDX-License-Identifier: BSD-3-Clause
// Figs. 12-14 of the paper: compares simplification by the cells of a k-d tree with the cells of an
// octree, at (about) equal numbers of vertices, and with levels by collapse. Gives RMS and
// Hausdorff distances, and pictures. Usage:
//   BenchClusters OUTPUT_FOLDER MESH.ply …
#include "Testing/Benchmarks/MeshPicture.h"
#include "filters/adapter/PolyDataMesh.h"
#include "filters/baselines/OctreeClustering.h"
#include "filters/core/MeshDistance.h"
#include "filters/core/Weld.h"
#include "filters/core/levels/CollapseLevels.h"
#include "filters/core/levels/SimplifyByClusters.h"
#include "filters/core/tree/Clustering.h"
#include "filters/program/TbbExecution.h"

#include <vtkCellArray.h>
#include <vtkNew.h>
#include <vtkPLYReader.h>
#include <vtkPoints.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iostream>

namespace
{

using namespace kdstream;
using namespace kdstream::bench;

constexpr std::uint32_t counts[] = { 16, 32, 64, 128, 256, 512, 2048, 8192 };
constexpr std::uint32_t shownCounts = 5;  // shown in the picture after Fig. 13
constexpr std::uint32_t faceCount = 2048; // in Fig. 14

struct Method
{
  const char* name;
  bool octree;
  bool collapse;
  Representative representative;
  bool byComponents;
};

constexpr Method methods[] = {
  { "k-d tree, mean (the paper's)", false, false, Representative::Mean, false },
  { "octree, mean", true, false, Representative::Mean, false },
  { "k-d tree, sheets + quadric", false, false, Representative::Quadric, true },
  { "octree, sheets + quadric", true, false, Representative::Quadric, true },
  { "collapse", false, true, Representative::Quadric, true },
};

// Returns the result. A failed step ends the program, because there is nothing to measure then.
template <class T>
T Need(Result<T> result)
{
  if (!result)
  {
    std::cerr << "BenchClusters: error: " << result.GetError().message << "\n";
    std::exit(1);
  }
  return std::move(*result);
}

Mesh ReadWelded(const std::string& file, const Execution& execution)
{
  vtkNew<vtkPLYReader> reader;
  reader->SetFileName(file.c_str());
  reader->Update();
  Mesh mesh = Need(ReadMesh(*reader->GetOutput(), execution));
  WeldVertices(mesh);
  return mesh;
}

ClusterLevel Collapse(const Mesh& mesh, std::uint32_t count, const Execution& execution)
{
  const KdTree tree = Need(BuildKdTree(mesh.points, {}, execution));
  const std::vector<std::uint32_t> partition = CellOfVertex(tree, tree.depths.partition);
  const TriangleBuckets buckets = BucketTriangles(mesh.triangles,
    std::size_t{ 1 } << tree.depths.partition, [&](VertexId v) { return partition[v]; });
  return Need(CollapseTo(mesh, tree, buckets, {}, { 0, count }, execution)).level;
}

ClusterLevel Simplify(
  const Mesh& mesh, const Method& method, std::uint32_t count, const Execution& execution)
{
  if (method.collapse)
  {
    return Collapse(mesh, count, execution);
  }
  ClusterOptions options;
  options.representative = method.representative;
  options.byComponents = method.byComponents;
  if (method.octree)
  {
    const OctreeOptions octree{ 0, count };
    return Need(SimplifyByClusters(
      mesh, Need(ClusterByOctree(mesh.points, octree, execution)), options, execution));
  }
  const KdTree tree = Need(BuildKdTree(mesh.points, { 0, count, 0 }, execution));
  const Clustering cells{ CellOfVertex(tree, tree.depths.partition), count };
  return Need(SimplifyByClusters(mesh, cells, options, execution));
}

vtkSmartPointer<vtkPolyData> ToPolyData(
  const std::vector<Vec3>& positions, const std::vector<Triangle>& triangles)
{
  auto mesh = vtkSmartPointer<vtkPolyData>::New();
  vtkNew<vtkPoints> points;
  for (const Vec3& p : positions)
  {
    points->InsertNextPoint(p.data());
  }
  vtkNew<vtkCellArray> cells;
  for (const Triangle& t : triangles)
  {
    const vtkIdType ids[] = { t[0], t[1], t[2] };
    cells->InsertNextCell(3, ids);
  }
  mesh->SetPoints(points);
  mesh->SetPolys(cells);
  return mesh;
}

// The table of one mesh, and the mesh's cells in the pictures.
class MeshBenchmark
{
public:
  MeshBenchmark(const std::string& file, const Execution& execution, std::ostream& csv)
    : Name(std::filesystem::path(file).stem().string())
    , Exec(execution)
    , Csv(csv)
    , Input(ReadWelded(file, execution))
  {
  }

  void Run()
  {
    std::printf("\n%s: %zu vertices, %zu triangles; distances in %% of the diagonal\n",
      this->Name.c_str(), this->Input.points.size(), this->Input.triangles.size());
    std::printf("%-30s %9s %9s %9s %9s %9s\n", "method", "vertices", "triangles", "rms to",
      "rms from", "hausdorff");
    for (const std::uint32_t count : counts)
    {
      for (const Method& method : methods)
      {
        if (count < this->Input.points.size())
        {
          this->Measure(method, count);
        }
      }
    }
    this->Summarize();
  }

  void WritePictures(const std::filesystem::path& folder)
  {
    PictureOptions look;
    look.flat = true;
    look.edges = true;
    look.cellWidth = 360;
    look.cellHeight = 330;
    Need(WriteAll(this->Rows, look, folder / ("fig13-" + this->Name + ".png")));
    look.cellWidth = 900;
    look.cellHeight = 760;
    look.edges = false;
    Need(WriteAll({ this->Faces }, look, folder / ("fig14-" + this->Name + ".png")));
  }

private:
  static Result<int> WriteAll(const std::vector<std::vector<PictureCell>>& rows,
    const PictureOptions& look, const std::filesystem::path& file)
  {
    const Status status = WriteMeshPicture(rows, look, file.string());
    return status ? Result<int>(0) : Result<int>(status.GetError());
  }

  void Measure(const Method& method, std::uint32_t count)
  {
    const ClusterLevel level = Simplify(this->Input, method, count, this->Exec);
    const Mesh simplified{ level.positions, level.triangles, ScalarType::Float64 };
    const MeshDistance d = Need(MeasureDistance(this->Input, simplified, {}, this->Exec));
    const double percent = 100 / d.diagonal;
    std::printf("%-30s %9zu %9zu %9.4f %9.4f %9.3f\n", method.name, level.positions.size(),
      level.triangles.size(), d.rmsForward * percent, d.rmsBackward * percent,
      d.hausdorff * percent);
    this->Csv << this->Name << ',' << method.name << ',' << level.positions.size() << ','
              << level.triangles.size() << ',' << d.rmsForward * percent << ','
              << d.rmsBackward * percent << ',' << d.hausdorff * percent << '\n';
    const auto row = static_cast<std::size_t>(&method - methods);
    this->Figures[row].push_back({ d.rmsForward * percent, d.rmsBackward * percent });
    this->Rows.resize(std::size(methods));
    PictureCell cell{ ToPolyData(level.positions, level.triangles),
      std::string(method.name) + "\n" + std::to_string(level.positions.size()) + " vertices, " +
        std::to_string(level.triangles.size()) + " triangles",
      {} };
    if (count == faceCount)
    {
      this->Faces.push_back(cell);
    }
    if (this->Rows[row].size() < shownCounts)
    {
      this->Rows[row].push_back(std::move(cell));
    }
  }

  // Counts how often the paper's claim holds: at equal numbers the k-d tree's mesh is better.
  void Summarize() const
  {
    const auto better = [&](std::size_t a, std::size_t b)
    {
      std::size_t wins = 0;
      for (std::size_t i = 0; i < this->Figures[a].size(); ++i)
      {
        wins += std::max(this->Figures[a][i].to, this->Figures[a][i].from) <
                std::max(this->Figures[b][i].to, this->Figures[b][i].from);
      }
      return wins;
    };
    const std::size_t all = this->Figures[0].size();
    std::printf("smaller RMS (the larger way) than the octree's: the paper's method in %zu of %zu "
                "cases, with sheets + quadric both in %zu of %zu, collapse (than either) in %zu\n",
      better(0, 1), all, better(2, 3), all, std::min(better(4, 1), better(4, 3)));
  }

  struct Figure
  {
    double to, from; // RMS, % of the diagonal
  };

  std::string Name;
  const Execution& Exec;
  std::ostream& Csv;
  Mesh Input;
  std::vector<Figure> Figures[std::size(methods)];
  std::vector<std::vector<PictureCell>> Rows;
  std::vector<PictureCell> Faces;
};

}

int main(int argc, char** argv)
{
  if (argc < 3)
  {
    std::cerr << "usage: BenchClusters OUTPUT_FOLDER MESH.ply …\n";
    return 2;
  }
  const std::filesystem::path folder = argv[1];
  std::filesystem::create_directories(folder);
  std::ofstream csv(folder / "fig12.csv");
  csv << "mesh,method,vertices,triangles,rms to %,rms from %,hausdorff %\n";
  const Execution execution = MakeTbbExecution(0);
  for (int i = 2; i < argc; ++i)
  {
    MeshBenchmark benchmark(argv[i], execution, csv);
    benchmark.Run();
    benchmark.WritePictures(folder);
  }
  return csv.flush() ? 0 : 1;
}
