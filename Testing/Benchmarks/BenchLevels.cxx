// SPDX-License-Identifier: BSD-3-Clause
// Errors of levels by number of triangles: how far each method's meshes are from the original (RMS
// in both directions, and Hausdorff), and whether this project's own limits are met. Usage:
//   BenchLevels OUTPUT_FOLDER MESH.ply …
// Methods: ours (collapse; clusters with sheets + quadric; the paper's), an octree's cells (mean;
// sheets + quadric) at equal numbers of clusters, and peers from VTK and meshoptimizer at equal
// numbers of triangles. All methods of a row run in one session on one machine; they run on one
// thread if their times are compared. Writes levels.csv and levels.png. Exit code 1 if a limit is
// missed.
#include "Testing/Benchmarks/ErrorChart.h"
#include "Testing/Benchmarks/LevelPeers.h"
#include "filters/baselines/OctreeClustering.h"
#include "filters/core/MeshDistance.h"
#include "filters/core/Weld.h"
#include "filters/core/levels/Levels.h"
#include "filters/core/levels/SimplifyByClusters.h"
#include "filters/core/tree/Clustering.h"
#include "filters/meshio/MeshReader.h"
#include "filters/program/TbbExecution.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <limits>

namespace
{

using namespace kdstream;
using namespace kdstream::bench;

constexpr std::size_t samples = 100000;
// Of levels below 2^7, because distant surfaces take longest.
constexpr std::size_t coarseSamples = 20000;
constexpr unsigned fewestDepth = 4; // limits apply from 16 clusters on, as in Fig. 13
constexpr const char* collapseName = "collapse (ours)";
constexpr const char* componentsName = "cluster, sheets + quadric (ours)";
constexpr const char* paperName = "cluster, mean (the paper's)";
constexpr const char* octreeName = "octree, mean";
constexpr const char* octreeComponentsName = "octree, sheets + quadric";

// Returns the result. A failed step ends the program, because there is nothing to measure then.
template <class T>
T Need(Result<T> result)
{
  if (!result)
  {
    std::cerr << "BenchLevels: error: " << result.GetError().message << "\n";
    std::exit(2);
  }
  return std::move(*result);
}

double Now()
{
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

Mesh ReadWelded(const std::string& file)
{
  Mesh mesh;
  const std::unique_ptr<MeshReader> reader = Need(MeshReader::Open(file));
  Need(reader->ReadVertices(mesh, std::numeric_limits<std::size_t>::max()));
  Need(reader->ReadTriangles(mesh, std::numeric_limits<std::size_t>::max()));
  mesh.attributes.clear(); // peers do not support attributes
  WeldVertices(mesh);
  return mesh;
}

// The figures of one mesh. Distances are in % of the diagonal.
struct Figure
{
  std::string method;
  unsigned level = 0; // our level that this mesh is compared with
  std::size_t vertices = 0, triangles = 0;
  double rmsTo = 0, rmsFrom = 0, hausdorff = 0;
  double seconds = 0; // 0: not measured separately
  double Rms() const { return std::max(this->rmsTo, this->rmsFrom); }
};

struct Bar
{
  std::string what;
  double measured = 0, most = 0;
  bool Met() const { return this->measured <= this->most; }
};

class MeshBenchmark
{
public:
  MeshBenchmark(const std::string& file, const Execution& execution)
    : Name(std::filesystem::path(file).stem().string())
    , Exec(execution)
    , Input(ReadWelded(file))
    , Peers(this->Input)
  {
  }

  void Run()
  {
    std::printf("\n%s: %zu vertices, %zu triangles; distances in %% of the diagonal\n",
      this->Name.c_str(), this->Input.points.size(), this->Input.triangles.size());
    std::printf("%-34s %5s %9s %9s %9s %9s %9s %9s\n", "method", "level", "vertices", "triangles",
      "rms to", "rms from", "hausdorff", "seconds");
    this->Depths = Need(ComputeDepths(this->Input.points.size(), {}));
    this->MeasureLevels(collapseName, LevelOptions{});
    this->MeasureLevels(componentsName, LevelOptions{ {}, LevelMaker::Cluster });
    this->MeasureLevels(
      paperName, LevelOptions{ { Representative::Mean, false, 0 }, LevelMaker::Cluster });
    this->MeasureOctrees();
    this->MeasurePeers();
  }

  // Adds the limits for the dragon, for which all figures exist.
  void AddPeerBars(std::vector<Bar>& bars) const
  {
    const Figure &fine = this->Nearest(collapseName, 18500),
                 &coarse = this->Nearest(collapseName, 2700);
    const Figure &fineVtk = this->Beside("vtkQuadricDecimation", fine.level),
                 &coarseVtk = this->Beside("vtkQuadricDecimation", coarse.level);
    const std::string at = " at " + std::to_string(fine.triangles) + " triangles",
                      atCoarse = " at " + std::to_string(coarse.triangles) + " triangles";
    bars.push_back({ "RMS to, of vtkQuadricDecimation's," + at, fine.rmsTo / fineVtk.rmsTo, 1.10 });
    bars.push_back(
      { "RMS from, of vtkQuadricDecimation's," + at, fine.rmsFrom / fineVtk.rmsFrom, 1.15 });
    bars.push_back(
      { "RMS to, of vtkQuadricDecimation's," + atCoarse, coarse.rmsTo / coarseVtk.rmsTo, 1.20 });
    bars.push_back({ "RMS from, of vtkQuadricDecimation's," + atCoarse,
      coarse.rmsFrom / coarseVtk.rmsFrom, 1.20 });
    bars.push_back({ "Hausdorff, % of the diagonal," + at, fine.hausdorff, 0.8 });
    bars.push_back({ "seconds of tree and all levels, of that decimation's, one thread",
      fine.seconds / fineVtk.seconds, 0.2 });
    const Figure& components = this->Nearest(componentsName, 18500);
    const Figure& grid = this->Beside("vtkQuadricClustering", components.level);
    const std::string beside = " at " + std::to_string(components.triangles) + " against " +
                               std::to_string(grid.triangles) + " triangles";
    bars.push_back({ "cluster, RMS to, of vtkQuadricClustering's," + beside,
      components.rmsTo / grid.rmsTo, 0.95 });
    bars.push_back({ "cluster, RMS from, of vtkQuadricClustering's," + beside,
      components.rmsFrom / grid.rmsFrom, 0.95 });
  }

  // Adds the limits that apply to every level of at least 16 clusters; each is compared with the
  // worst level.
  void AddLevelBars(std::vector<Bar>& bars) const
  {
    Bar octree{ this->Name + ": RMS either way, of an octree's means, the largest", 0, 1 };
    Bar octreeComponents{
      this->Name + ": RMS, the larger way, of an octree's sheets + quadric, the largest", 0, 1
    };
    Bar paper{ this->Name + ": Hausdorff, of the paper's method's, the largest", 0, 1.05 };
    std::string octreeAt, octreeComponentsAt, paperAt;
    const auto worse = [](Bar& bar, std::string& at, double ratio, unsigned level)
    {
      if (ratio > bar.measured)
      {
        bar.measured = ratio;
        at = ", level " + std::to_string(level);
      }
    };
    for (const Figure& other : this->Figures)
    {
      const Figure* const ours =
        other.level < fewestDepth ? nullptr : this->Find(collapseName, other.level);
      if (ours && other.method == octreeName)
      {
        worse(octree, octreeAt, std::max(ours->rmsTo / other.rmsTo, ours->rmsFrom / other.rmsFrom),
          other.level);
      }
      if (ours && other.method == octreeComponentsName)
      {
        worse(octreeComponents, octreeComponentsAt, ours->Rms() / other.Rms(), other.level);
      }
      if (ours && other.method == paperName)
      {
        worse(paper, paperAt, ours->hausdorff / other.hausdorff, other.level);
      }
    }
    octree.what += octreeAt;
    octreeComponents.what += octreeComponentsAt;
    paper.what += paperAt;
    bars.push_back(octree);
    bars.push_back(octreeComponents);
    bars.push_back(paper);
  }

  void WriteRows(std::ostream& csv) const
  {
    for (const Figure& f : this->Figures)
    {
      csv << this->Name << ",\"" << f.method << "\"," << f.level << ',' << f.vertices << ','
          << f.triangles << ',' << f.rmsTo << ',' << f.rmsFrom << ',' << f.hausdorff << ','
          << f.seconds << '\n';
    }
  }

  // Charts of RMS (the larger direction) and Hausdorff, with a curve for each method.
  std::vector<ErrorPanel> Panels() const
  {
    std::vector<ErrorPanel> panels(2);
    panels[0].title = this->Name + ": RMS distance";
    panels[1].title = this->Name + ": Hausdorff distance";
    for (ErrorPanel& panel : panels)
    {
      panel.xTitle = "triangles";
      panel.yTitle = "% of the diagonal";
      for (const Figure& f : this->Figures)
      {
        const double error = &panel == panels.data() ? f.Rms() : f.hausdorff;
        auto curve = std::find_if(panel.curves.begin(), panel.curves.end(),
          [&](const ErrorCurve& c) { return c.name == f.method; });
        if (curve == panel.curves.end())
        {
          curve = panel.curves.insert(curve, { f.method, {}, {} });
        }
        if (error > 0)
        {
          curve->costs.push_back(double(f.triangles));
          curve->errors.push_back(error);
        }
      }
    }
    return panels;
  }

private:
  void Measure(const std::string& method, unsigned level, const Mesh& mesh, double seconds)
  {
    if (mesh.triangles.empty())
    {
      return;
    }
    const MeshDistance d = Need(
      MeasureDistance(this->Input, mesh, { level < 7 ? coarseSamples : samples, 1 }, this->Exec));
    const double percent = 100 / d.diagonal;
    const Figure f{ method, level, mesh.points.size(), mesh.triangles.size(),
      d.rmsForward * percent, d.rmsBackward * percent, d.hausdorff * percent, seconds };
    std::printf("%-34s %5u %9zu %9zu %9.4f %9.4f %9.3f %9.3f\n", f.method.c_str(), f.level,
      f.vertices, f.triangles, f.rmsTo, f.rmsFrom, f.hausdorff, f.seconds);
    std::fflush(stdout);
    this->Figures.push_back(f);
  }

  // Measures the tree and all levels, timed on one thread.
  void MeasureLevels(const std::string& method, const LevelOptions& options)
  {
    const Execution serial;
    const double start = Now();
    const KdTree tree = Need(BuildKdTree(this->Input.points, {}, serial));
    const std::vector<std::uint32_t> partition = CellOfVertex(tree, tree.depths.partition);
    const TriangleBuckets buckets = BucketTriangles(this->Input.triangles,
      std::size_t{ 1 } << tree.depths.partition, [&](VertexId v) { return partition[v]; });
    const ClusterLevels levels = Need(BuildLevels(this->Input, tree, buckets, options, serial));
    const double seconds = Now() - start;
    for (unsigned depth = this->Depths.finest + 1; depth-- > 0;)
    {
      const ClusterLevel& level = levels.levels[depth];
      this->Measure(method, depth, { level.positions, level.triangles }, seconds);
    }
  }

  // Measures octrees with at most as many vertices as our levels have, and as close to that as
  // their cells allow.
  void MeasureOctrees()
  {
    const std::vector<Figure> ours = this->Figures;
    for (const Figure& f : ours)
    {
      if (f.method != collapseName)
      {
        continue;
      }
      for (const ClusterOptions& options :
        { ClusterOptions{ Representative::Mean, false, 0 }, ClusterOptions{} })
      {
        const ClusterLevel level = this->OctreeLevel(f.vertices, options);
        this->Measure(options.byComponents ? octreeComponentsName : octreeName, f.level,
          { level.positions, level.triangles }, 0);
      }
    }
  }

  // With components a cell may have several vertices, so fewer cells are made.
  ClusterLevel OctreeLevel(std::size_t mostVertices, const ClusterOptions& options) const
  {
    std::size_t wanted = mostVertices;
    for (;;)
    {
      const OctreeClustering cells = Need(
        ClusterByOctree(this->Input.points, { 0, static_cast<std::uint32_t>(wanted) }, this->Exec));
      ClusterLevel level = Need(SimplifyByClusters(this->Input, cells, options, this->Exec));
      if (level.positions.size() <= mostVertices || wanted == 1)
      {
        return level;
      }
      wanted = std::min(wanted - 1, wanted * mostVertices / level.positions.size());
    }
  }

  void MeasurePeers()
  {
    const std::vector<Figure> ours = this->Figures;
    for (const Figure& f : ours)
    {
      if (f.level < 6 || f.level == this->Depths.finest)
      {
        continue; // at less than a hundred triangles, little can be expected of a mesh
      }
      if (f.method == collapseName)
      {
        for (const PeerMesh& peer : this->Peers.ByTarget(f.triangles))
        {
          this->Measure(peer.method, f.level, peer.mesh, peer.seconds);
        }
      }
      else if (f.method == componentsName)
      {
        for (const PeerMesh& peer : this->Peers.ByGrid(f.triangles))
        {
          this->Measure(peer.method, f.level, peer.mesh, peer.seconds);
        }
      }
    }
  }

  const Figure* Find(const std::string& method, unsigned level) const
  {
    const auto found = std::find_if(this->Figures.begin(), this->Figures.end(),
      [&](const Figure& f) { return f.method == method && f.level == level; });
    return found == this->Figures.end() ? nullptr : &*found;
  }

  const Figure& Beside(const std::string& method, unsigned level) const
  {
    return *this->Find(method, level);
  }

  const Figure& Nearest(const std::string& method, double triangles) const
  {
    const Figure* nearest = nullptr;
    for (const Figure& f : this->Figures)
    {
      if (f.method == method && (!nearest || std::abs(double(f.triangles) - triangles) <
                                               std::abs(double(nearest->triangles) - triangles)))
      {
        nearest = &f;
      }
    }
    return *nearest;
  }

  std::string Name;
  const Execution& Exec;
  Mesh Input;
  LevelPeers Peers;
  TreeDepths Depths;
  std::vector<Figure> Figures;
};

bool PrintBars(const std::vector<Bar>& bars)
{
  std::printf("\nbars\n");
  bool met = true;
  for (const Bar& bar : bars)
  {
    std::printf("%-6s %8.3f of at most %.3f  %s\n", bar.Met() ? "met" : "MISSED", bar.measured,
      bar.most, bar.what.c_str());
    met = met && bar.Met();
  }
  return met;
}

}

int main(int argc, char** argv)
{
  if (argc < 3)
  {
    std::cerr << "usage: BenchLevels OUTPUT_FOLDER MESH.ply …\n";
    return 2;
  }
  const std::filesystem::path folder = argv[1];
  std::filesystem::create_directories(folder);
  std::ofstream csv(folder / "levels.csv");
  csv << "mesh,method,level,vertices,triangles,rms to %,rms from %,hausdorff %,seconds\n";
  const Execution execution = MakeTbbExecution(0);
  std::vector<Bar> bars;
  std::vector<std::vector<ErrorPanel>> rows;
  for (int i = 2; i < argc; ++i)
  {
    MeshBenchmark benchmark(argv[i], execution);
    benchmark.Run();
    benchmark.WriteRows(csv);
    rows.push_back(benchmark.Panels());
    if (std::filesystem::path(argv[i]).stem() == "dragon")
    {
      benchmark.AddPeerBars(bars);
    }
    benchmark.AddLevelBars(bars);
  }
  const Status drawn = WriteErrorCharts(rows, (folder / "levels.png").string());
  if (!drawn || !csv.flush())
  {
    std::cerr << "BenchLevels: error: "
              << (drawn ? "levels.csv cannot be written" : drawn.GetError().message) << "\n";
    return 2;
  }
  return PrintBars(bars) ? 0 : 1;
}
