// SPDX-License-Identifier: BSD-3-Clause
// Table 2 and Figs. 5 and 6 of the paper: partitions by k-d tree, octree and k-means. Compares
// their compactness, the spread of their sizes, and the time, with the paper's figures and with
// peers. Usage:
//   BenchPartition table2|fig5 OUTPUT_FOLDER MESH.ply …
// table2 prints the table and writes table2.csv. fig5 writes fig5-MESH.png, a mesh cut by all three
// methods, and fig6.png, all meshes cut by the k-d tree.
#include "Testing/Benchmarks/MeshPicture.h"
#include "filters/baselines/KMeansClustering.h"
#include "filters/baselines/OctreeClustering.h"
#include "filters/core/Weld.h"
#include "filters/core/tree/KdTree.h"
#include "filters/core/tree/PartitionMeasures.h"
#include "filters/meshio/MeshReader.h"
#ifdef KDSTREAM_PCL_PEER
#include "Testing/Benchmarks/PclOctreePeer.h"
#endif

#include <vtkCellArray.h>
#include <vtkKdTree.h>
#include <vtkNew.h>
#include <vtkOctreePointLocator.h>
#include <vtkPoints.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iostream>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

namespace
{

using namespace kdstream;
using namespace kdstream::bench;

constexpr std::uint32_t partitionCounts[] = { 16, 64, 256 };
constexpr std::uint32_t mainCount = 64; // of Fig. 5; the paper does not say that of Table 2
constexpr int repeats = 5;              // the shortest time of these counts

// Returns the result. A failed step ends the program, because there is nothing to measure then.
template <class T>
T Need(Result<T> result)
{
  if (!result)
  {
    std::cerr << "BenchPartition: error: " << result.GetError().message << "\n";
    std::exit(1);
  }
  return std::move(*result);
}

struct NamedMesh
{
  std::string name;
  Mesh mesh;
};

NamedMesh ReadWelded(const std::filesystem::path& file)
{
  const auto reader = Need(MeshReader::Open(file));
  NamedMesh named{ file.stem().string(), {} };
  constexpr std::size_t all = std::numeric_limits<std::size_t>::max();
  while (Need(reader->ReadVertices(named.mesh, all)) > 0)
  {
  }
  while (Need(reader->ReadTriangles(named.mesh, all)) > 0)
  {
  }
  named.mesh.attributes.clear();
  WeldVertices(named.mesh);
  return named;
}

struct Method
{
  const char* name;
  std::function<Clustering(const Mesh& mesh, std::uint32_t partitions)> cluster;
};

const std::vector<Method>& Methods()
{
  static const std::vector<Method> methods{
    { "k-d tree",
      [](const Mesh& mesh, std::uint32_t partitions)
      {
        const KdTree tree = Need(BuildKdTree(mesh.points, { 0, partitions, 0 }));
        return Clustering{ CellOfVertex(tree, tree.depths.partition), partitions };
      } },
    { "octree",
      [](const Mesh& mesh, std::uint32_t partitions) {
        return Clustering(Need(ClusterByOctree(mesh.points, { 0, partitions })));
      } },
    { "k-means",
      [](const Mesh& mesh, std::uint32_t partitions)
      {
        KMeansOptions options;
        options.partitions = partitions;
        return Need(ClusterByKMeans(mesh.points, mesh.triangles, options));
      } },
  };
  return methods;
}

// The shortest time of several runs, after one that does not count.
double LeastSeconds(const std::function<void()>& run)
{
  run();
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < repeats; ++i)
  {
    const auto start = std::chrono::steady_clock::now();
    run();
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    least = std::min(least, seconds.count());
  }
  return least;
}

// The figures in the paper.
struct PaperRow
{
  const char* mesh;
  unsigned vertices;
  double compactness[3], seconds[3]; // k-d tree, octree, k-means
};
constexpr PaperRow paperRows[] = {
  { "Bunny", 35947, { 2.068, 1.856, 2.358 }, { 3.18, 3.15, 4.10 } },
  { "Feline", 49864, { 2.938, 2.299, 2.440 }, { 4.43, 4.38, 5.85 } },
  { "Igea", 67180, { 1.787, 1.816, 2.435 }, { 6.16, 6.12, 9.27 } },
  { "Skull", 98306, { 1.857, 1.761, 2.331 }, { 9.12, 9.08, 13.14 } },
};

void PrintPaper()
{
  std::printf("\nThe paper's Table 2 (2 GHz, 3 GB; its times hold what went before too):\n");
  std::printf("%-14s %8s | %29s | %29s\n", "mesh", "vertices", "compactness", "seconds");
  std::printf("%-14s %8s | %9s %9s %9s | %9s %9s %9s\n", "", "", "k-d tree", "octree", "k-means",
    "k-d tree", "octree", "k-means");
  for (const PaperRow& row : paperRows)
  {
    std::printf("%-14s %8u | %9.3f %9.3f %9.3f | %9.2f %9.2f %9.2f\n", row.mesh, row.vertices,
      row.compactness[0], row.compactness[1], row.compactness[2], row.seconds[0], row.seconds[1],
      row.seconds[2]);
  }
  std::printf(
    "%-14s %8s | %9.3f %9.3f %9.3f | %9.2f %9.2f %9.2f (its k-means column gives 2.391)\n",
    "average", "", 2.163, 1.933, 3.049, 5.73, 5.68, 9.21);
}

// Makes Table 2, one mesh after the other.
class Table
{
public:
  explicit Table(const std::filesystem::path& folder)
    : Csv(folder / "table2.csv")
  {
    this->Csv << "mesh,vertices,triangles,wanted partitions,method,partitions,compactness mean,"
                 "compactness maximum,vertices minimum,vertices maximum,vertices deviation,"
                 "seconds\n";
  }

  void Add(const NamedMesh& named)
  {
    for (const std::uint32_t partitions : partitionCounts)
    {
      Row row{ named.name, named.mesh.points.size(), partitions, {} };
      for (const Method& method : Methods())
      {
        row.figures.push_back(this->Measure(named, method, partitions));
      }
      this->Rows.push_back(row);
    }
  }

  void Print() const
  {
    for (const std::uint32_t partitions : partitionCounts)
    {
      this->PrintCompactness(partitions);
    }
    this->PrintSpread();
    this->PrintOrder();
  }

  bool Finish() { return static_cast<bool>(this->Csv.flush()); }

private:
  struct Figure
  {
    double compactness, seconds;
    std::uint32_t partitions;
    Spread vertices;
  };
  struct Row
  {
    std::string mesh;
    std::size_t vertices;
    std::uint32_t partitions;
    std::vector<Figure> figures; // one for each method
  };

  Figure Measure(const NamedMesh& named, const Method& method, std::uint32_t partitions)
  {
    const Mesh& mesh = named.mesh;
    const double seconds = LeastSeconds([&] { method.cluster(mesh, partitions); });
    const Clustering clustering = method.cluster(mesh, partitions);
    const PartitionMeasures measures =
      Need(MeasurePartitions(mesh.points, mesh.triangles, clustering));
    this->Csv << named.name << ',' << mesh.points.size() << ',' << mesh.triangles.size() << ','
              << partitions << ',' << method.name << ',' << clustering.clusters << ','
              << measures.compactness.mean << ',' << measures.compactness.maximum << ','
              << measures.vertices.minimum << ',' << measures.vertices.maximum << ','
              << measures.vertices.standardDeviation << ',' << seconds << '\n';
    return { measures.compactness.mean, seconds, clustering.clusters, measures.vertices };
  }

  void PrintCompactness(std::uint32_t partitions) const
  {
    std::printf("\n%u partitions (the octree as near as it gets): compactness, smaller is better; "
                "milliseconds, one thread, least of %d\n",
      partitions, repeats);
    std::printf("%-14s %8s | %9s %9s %9s | %9s %9s %9s\n", "mesh", "vertices", "k-d tree", "octree",
      "k-means", "k-d tree", "octree", "k-means");
    std::vector<double> sums(6, 0);
    std::size_t rows = 0;
    for (const Row& row : this->Rows)
    {
      if (row.partitions != partitions)
      {
        continue;
      }
      ++rows;
      std::printf("%-14s %8zu |", row.mesh.c_str(), row.vertices);
      for (std::size_t m = 0; m < 3; ++m)
      {
        std::printf(" %9.3f", row.figures[m].compactness);
        sums[m] += row.figures[m].compactness;
      }
      std::printf(" |");
      for (std::size_t m = 0; m < 3; ++m)
      {
        std::printf(" %9.2f", 1e3 * row.figures[m].seconds);
        sums[3 + m] += 1e3 * row.figures[m].seconds;
      }
      std::printf("\n");
    }
    const auto count = static_cast<double>(rows);
    std::printf("%-14s %8s | %9.3f %9.3f %9.3f | %9.2f %9.2f %9.2f\n", "average", "",
      sums[0] / count, sums[1] / count, sums[2] / count, sums[3] / count, sums[4] / count,
      sums[5] / count);
  }

  void PrintSpread() const
  {
    std::printf(
      "\nVertices of the partitions, %u wanted: partitions, least - most (deviation in %% "
      "of the mean)\n",
      mainCount);
    std::printf("%-14s | %-26s | %-26s | %-26s\n", "mesh", "k-d tree", "octree", "k-means");
    for (const Row& row : this->Rows)
    {
      if (row.partitions != mainCount)
      {
        continue;
      }
      std::printf("%-14s", row.mesh.c_str());
      for (const Figure& figure : row.figures)
      {
        char text[64];
        std::snprintf(text, sizeof text, "%u: %.0f - %.0f (%.1f %%)", figure.partitions,
          figure.vertices.minimum, figure.vertices.maximum,
          100 * figure.vertices.standardDeviation / figure.vertices.mean);
        std::printf(" | %-26s", text);
      }
      std::printf("\n");
    }
  }

  // Counts how often the paper's statements hold.
  void PrintOrder() const
  {
    std::size_t octreeFirst = 0, octreeBeforeKd = 0, kdBeforeKMeans = 0, kdFaster = 0,
                octreeFastest = 0;
    for (const Row& row : this->Rows)
    {
      const Figure &kd = row.figures[0], &octree = row.figures[1], &kmeans = row.figures[2];
      octreeFirst += octree.compactness < std::min(kd.compactness, kmeans.compactness);
      octreeBeforeKd += octree.compactness < kd.compactness;
      kdBeforeKMeans += kd.compactness < kmeans.compactness;
      kdFaster += kd.seconds < kmeans.seconds;
      octreeFastest += octree.seconds < kd.seconds;
    }
    std::printf(
      "\nThe paper's claims, of %zu cases: octree most compact in %zu, more compact "
      "than the k-d tree in %zu;\nk-d tree more compact than k-means in %zu, faster in %zu; "
      "octree faster than the k-d tree in %zu\n",
      this->Rows.size(), octreeFirst, octreeBeforeKd, kdBeforeKMeans, kdFaster, octreeFastest);
  }

  std::ofstream Csv;
  std::vector<Row> Rows;
};

vtkSmartPointer<vtkPoints> ToPoints(const Mesh& mesh)
{
  auto points = vtkSmartPointer<vtkPoints>::New();
  points->SetNumberOfPoints(static_cast<vtkIdType>(mesh.points.size()));
  for (std::size_t i = 0; i < mesh.points.size(); ++i)
  {
    points->SetPoint(static_cast<vtkIdType>(i), mesh.points[i].data());
  }
  return points;
}

// Times trees of other libraries over the same points, with about the same number of cells, in turn
// with ours.
void PrintPeers(const NamedMesh& named)
{
  const Mesh& mesh = named.mesh;
  const OctreeClustering searched = Need(ClusterByOctree(mesh.points, { 0, mainCount }));
  const std::uint32_t most = searched.verticesPerPartition;
  const auto points = ToPoints(mesh);
  double kd = std::numeric_limits<double>::infinity(), octree = kd, vtkKd = kd, vtkOctree = kd;
  [[maybe_unused]] double pcl = kd;
  int vtkKdRegions = 0, vtkOctreeRegions = 0;
  [[maybe_unused]] std::size_t pclLeaves = 0;
  const auto once = [](double& least, const auto& run)
  {
    const auto start = std::chrono::steady_clock::now();
    run();
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    least = std::min(least, seconds.count());
  };
  for (int i = 0; i <= repeats; ++i)
  {
    once(kd, [&] { Methods()[0].cluster(mesh, mainCount); });
    once(octree, [&] { Need(ClusterByOctree(mesh.points, { most, {} })); });
    vtkNew<vtkKdTree> kdTree;
    kdTree->SetNumberOfRegionsOrMore(mainCount);
    once(vtkKd, [&] { kdTree->BuildLocatorFromPoints(points); });
    vtkKdRegions = kdTree->GetNumberOfRegions();
    vtkNew<vtkPolyData> cloud;
    cloud->SetPoints(points);
    vtkNew<vtkOctreePointLocator> locator;
    locator->SetDataSet(cloud);
    locator->SetMaximumPointsPerRegion(static_cast<int>(most));
    once(vtkOctree, [&] { locator->BuildLocator(); });
    vtkOctreeRegions = locator->GetNumberOfLeafNodes();
#ifdef KDSTREAM_PCL_PEER
    const PclOctree peer = TimePclOctree(mesh.points, most);
    pcl = std::min(pcl, peer.seconds);
    pclLeaves = peer.leaves;
#endif
  }
  std::printf("%-14s | %6.2f (%u) %6.2f (%d) %5.2f | %6.2f (%u) %6.2f (%d) %5.2f",
    named.name.c_str(), 1e3 * kd, mainCount, 1e3 * vtkKd, vtkKdRegions, kd / vtkKd, 1e3 * octree,
    searched.clusters, 1e3 * vtkOctree, vtkOctreeRegions, octree / vtkOctree);
#ifdef KDSTREAM_PCL_PEER
  std::printf(" | %6.2f (%zu) %5.2f", 1e3 * pcl, pclLeaves, octree / pcl);
#endif
  std::printf("\n");
}

int RunTable2(const std::filesystem::path& folder, const std::vector<NamedMesh>& meshes)
{
  Table table(folder);
  for (const NamedMesh& named : meshes)
  {
    table.Add(named);
  }
  PrintPaper();
  table.Print();
  std::printf(
    "\nPeers: milliseconds (leaves) and ours by theirs: our k-d tree, vtkKdTree; our octree "
    "(N given), vtkOctreePointLocator%s\n",
#ifdef KDSTREAM_PCL_PEER
    "; pcl::octree"
#else
    " (PCL was not found)"
#endif
  );
  for (const NamedMesh& named : meshes)
  {
    PrintPeers(named);
  }
  return table.Finish() ? 0 : 1;
}

// The mesh, moved and scaled into the unit ball, so that one camera sees all meshes completely.
vtkSmartPointer<vtkPolyData> ToPolyData(const Mesh& mesh)
{
  const Box box = BoxOfPoints(mesh.points);
  const auto fromCentre = [&](const Vec3& p)
  {
    return Vec3{ p[0] - (box.lo[0] + box.hi[0]) / 2, p[1] - (box.lo[1] + box.hi[1]) / 2,
      p[2] - (box.lo[2] + box.hi[2]) / 2 };
  };
  double radius = 0;
  for (const Vec3& p : mesh.points)
  {
    const Vec3 d = fromCentre(p);
    radius = std::max(radius, std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]));
  }
  vtkNew<vtkPoints> points;
  for (const Vec3& p : mesh.points)
  {
    const Vec3 moved = fromCentre(p);
    points->InsertNextPoint(moved[0] / radius, moved[1] / radius, moved[2] / radius);
  }
  vtkNew<vtkCellArray> triangles;
  for (const Triangle& t : mesh.triangles)
  {
    const vtkIdType ids[] = { t[0], t[1], t[2] };
    triangles->InsertNextCell(3, ids);
  }
  auto result = vtkSmartPointer<vtkPolyData>::New();
  result->SetPoints(points);
  result->SetPolys(triangles);
  return result;
}

PictureCell MakeCell(
  const NamedMesh& named, const std::string& caption, const Clustering& clustering)
{
  const PartitionMeasures measures =
    Need(MeasurePartitions(named.mesh.points, named.mesh.triangles, clustering));
  char text[160];
  std::snprintf(text, sizeof text, "%s: %u partitions, %.0f - %.0f vertices, compactness %.2f",
    caption.c_str(), clustering.clusters, measures.vertices.minimum, measures.vertices.maximum,
    measures.compactness.mean);
  return { ToPolyData(named.mesh), text, clustering.clusterOf };
}

int RunFig5(const std::filesystem::path& folder, const std::vector<NamedMesh>& meshes)
{
  PictureOptions look;
  look.cellWidth = 640;
  look.cellHeight = 560;
  look.azimuth = 20;
  look.elevation = 25;
  std::vector<std::vector<PictureCell>> all;
  for (const NamedMesh& named : meshes)
  {
    // The order of Fig. 5: k-means, octree, k-d tree.
    std::vector<PictureCell> row;
    for (const std::size_t m : { std::size_t{ 2 }, std::size_t{ 1 }, std::size_t{ 0 } })
    {
      const Method& method = Methods()[m];
      row.push_back(MakeCell(named, method.name, method.cluster(named.mesh, mainCount)));
    }
    const std::string file = (folder / ("fig5-" + named.name + ".png")).string();
    if (const Status status = WriteMeshPicture({ row }, look, file); !status)
    {
      return Need(Result<int>(status.GetError()));
    }
    std::printf("%s\n", file.c_str());
    if (all.empty() || all.back().size() == 3)
    {
      all.emplace_back();
    }
    // Partitions of about 1,000 vertices each.
    std::uint32_t partitions = 1;
    while (named.mesh.points.size() / partitions > 1000)
    {
      partitions *= 2;
    }
    all.back().push_back(MakeCell(named, named.name, Methods()[0].cluster(named.mesh, partitions)));
  }
  while (all.size() > 1 && all.back().size() < all.front().size())
  {
    all.back().emplace_back(); // an empty place
  }
  look.oneScale = false;
  const std::string file = (folder / "fig6.png").string();
  if (const Status status = WriteMeshPicture(all, look, file); !status)
  {
    return Need(Result<int>(status.GetError()));
  }
  std::printf("%s\n", file.c_str());
  return 0;
}

}

int main(int argc, char** argv)
{
  const std::string_view what = argc > 1 ? argv[1] : "";
  if (argc < 4 || (what != "table2" && what != "fig5"))
  {
    std::cerr << "usage: BenchPartition table2|fig5 OUTPUT_FOLDER MESH.ply …\n";
    return 2;
  }
  const std::filesystem::path folder = argv[2];
  std::filesystem::create_directories(folder);
  std::vector<NamedMesh> meshes;
  for (int i = 3; i < argc; ++i)
  {
    meshes.push_back(ReadWelded(argv[i]));
    if (meshes.back().mesh.points.size() < partitionCounts[2])
    {
      std::cerr << "BenchPartition: error: " << argv[i] << " has too few vertices\n";
      return 1;
    }
  }
  return what == "table2" ? RunTable2(folder, meshes) : RunFig5(folder, meshes);
}
