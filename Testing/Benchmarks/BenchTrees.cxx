// SPDX-License-Identifier: BSD-3-Clause
// The cost in VTK of finding each point's partition: vtkKdTreePartition compared with
// vtkKdTree::BuildLocatorFromPoints. They take turns, and the shortest time of several runs counts.
// Usage:
//   BenchTrees MESH.ply …
// vtkKdTree gets only the points, and makes at least as many regions as there are partitions. It
// copies the coordinates as floats and orders them by region, nothing else. Ours always computes
// PartitionId. It runs with only the points, and with the mesh; each time with port 1, which cuts
// nothing (but checks the mesh's cells), and with port 0, the partitions.
#include "filters/adapter/Testing/SmpBackend.h"

#include <vtkCellArray.h>
#include <vtkKdMeshReader.h>
#include <vtkKdTree.h>
#include <vtkKdTreePartition.h>
#include <vtkNew.h>
#include <vtkPartitionedDataSet.h>
#include <vtkPolyData.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <limits>

namespace
{

constexpr int repeats = 7;

class Least
{
public:
  void Time(const std::function<void()>& run)
  {
    const auto start = std::chrono::steady_clock::now();
    run();
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    this->Seconds = std::min(this->Seconds, seconds.count());
  }
  double Milliseconds() const { return 1e3 * this->Seconds; }

private:
  double Seconds = std::numeric_limits<double>::infinity();
};

void Compare(vtkPolyData* mesh, const char* name, int threads)
{
  vtkNew<vtkPolyData> cloud; // it has no cells, so only the points are read
  cloud->SetPoints(mesh->GetPoints());
  vtkNew<vtkKdTreePartition> points, whole;
  points->SetInputData(cloud);
  whole->SetInputData(mesh);
  points->GeneratePartitionIdsOn();
  whole->GeneratePartitionIdsOn();
  whole->Update();
  const auto partitions = static_cast<int>(whole->GetOutput()->GetNumberOfPartitions());
  Least tree, cloudCut, ids, cut, peer;
  int regions = 0;
  for (int i = 0; i < repeats; ++i)
  {
    vtkNew<vtkKdTree> kdTree;
    kdTree->SetNumberOfRegionsOrMore(partitions);
    peer.Time([&] { kdTree->BuildLocatorFromPoints(mesh->GetPoints()); });
    regions = kdTree->GetNumberOfRegions();
    points->Modified();
    tree.Time([&] { points->Update(1); });
    points->Modified();
    cloudCut.Time([&] { points->Update(); });
    mesh->GetPolys()->GetConnectivityArray()->Modified(); // so that VTK computes ranges again
    whole->Modified();
    ids.Time([&] { whole->Update(1); });
    whole->Modified();
    cut.Time([&] { whole->Update(); });
  }
  const double base = peer.Milliseconds();
  std::printf("%-16s %9lld %7d %6d %7d | %9.1f", name,
    static_cast<long long>(mesh->GetNumberOfPoints()), threads, partitions, regions, base);
  for (const Least& each : { tree, cloudCut, ids, cut })
  {
    std::printf(" | %8.1f %5.2f", each.Milliseconds(), each.Milliseconds() / base);
  }
  std::printf("\n");
}

}

int main(int argc, char** argv)
{
  std::printf(
    "Milliseconds, the least of %d, and times those of vtkKdTree (one thread always)\n", repeats);
  std::printf("%-16s %9s %7s %6s %7s | %9s | %14s | %14s | %14s | %14s\n", "mesh", "points",
    "threads", "parts", "regions", "vtkKdTree", "points, port 1", "points, port 0", "mesh, port 1",
    "mesh, port 0");
  for (int i = 1; i < argc; ++i)
  {
    vtkNew<vtkKdMeshReader> reader;
    reader->SetFileName(argv[i]);
    reader->Update();
    if (reader->GetErrorCode() != 0)
    {
      return 1;
    }
    for (const int threads : { 1, 2 })
    {
      kdstream::testing::UseSmpBackend("TBB", threads);
      Compare(reader->GetOutput(), std::filesystem::path(argv[i]).stem().c_str(), threads);
    }
  }
  return 0;
}
