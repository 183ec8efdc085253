// SPDX-License-Identifier: BSD-3-Clause
#include "Testing/Benchmarks/LevelPeers.h"

#include <vtkBinnedDecimation.h>
#include <vtkCellArray.h>
#include <vtkCellArrayIterator.h>
#include <vtkCleanPolyData.h>
#include <vtkDecimatePro.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkQuadricClustering.h>
#include <vtkQuadricDecimation.h>

#ifdef KDSTREAM_MESHOPTIMIZER
#include <meshoptimizer.h>
#endif

#include <chrono>

namespace kdstream::bench
{
namespace
{

constexpr int mostDivisions = 2048;

vtkSmartPointer<vtkPolyData> ToPolyData(const Mesh& mesh)
{
  auto data = vtkSmartPointer<vtkPolyData>::New();
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  for (const Vec3& p : mesh.points)
  {
    points->InsertNextPoint(p.data());
  }
  vtkNew<vtkCellArray> cells;
  for (const Triangle& t : mesh.triangles)
  {
    const vtkIdType ids[] = { t[0], t[1], t[2] };
    cells->InsertNextCell(3, ids);
  }
  data->SetPoints(points);
  data->SetPolys(cells);
  // vtkQuadricDecimation does not accept points that no triangle uses.
  vtkNew<vtkCleanPolyData> clean;
  clean->SetInputData(data);
  clean->PointMergingOff();
  clean->ConvertPolysToLinesOff();
  clean->Update();
  return clean->GetOutput();
}

Mesh FromPolyData(vtkPolyData* data)
{
  Mesh mesh;
  mesh.points.resize(static_cast<std::size_t>(data->GetNumberOfPoints()));
  for (std::size_t i = 0; i < mesh.points.size(); ++i)
  {
    data->GetPoint(static_cast<vtkIdType>(i), mesh.points[i].data());
  }
  const auto cells = vtk::TakeSmartPointer(data->GetPolys()->NewIterator());
  for (cells->GoToFirstCell(); !cells->IsDoneWithTraversal(); cells->GoToNextCell())
  {
    vtkIdType count = 0;
    const vtkIdType* ids = nullptr;
    cells->GetCurrentCell(count, ids);
    if (count == 3)
    {
      mesh.triangles.push_back({ static_cast<VertexId>(ids[0]), static_cast<VertexId>(ids[1]),
        static_cast<VertexId>(ids[2]) });
    }
  }
  return mesh;
}

double Now()
{
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

template <class Filter>
PeerMesh Run(const std::string& method, Filter* filter, vtkPolyData* input)
{
  filter->SetInputData(input);
  const double start = Now();
  filter->Update();
  const double seconds = Now() - start;
  return { method, FromPolyData(filter->GetOutput()), seconds };
}

// make(n) returns the peer's mesh with n divisions along a side. The number of triangles nearly
// always grows with n.
template <class Make>
PeerMesh SearchDivisions(std::size_t triangles, const Make& make)
{
  int low = 1, high = 2;
  PeerMesh best = make(high);
  while (best.mesh.triangles.size() < triangles && high < mostDivisions)
  {
    low = high;
    high *= 2;
    best = make(high);
  }
  while (high - low > 1)
  {
    const int middle = low + (high - low) / 2;
    PeerMesh tried = make(middle);
    if (tried.mesh.triangles.size() < triangles)
    {
      low = middle;
    }
    else
    {
      high = middle;
      best = std::move(tried);
    }
  }
  return best;
}

#ifdef KDSTREAM_MESHOPTIMIZER
PeerMesh RunMeshoptimizer(const Mesh& mesh, std::size_t triangles)
{
  std::vector<float> positions;
  for (const Vec3& p : mesh.points)
  {
    positions.insert(positions.end(),
      { static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2]) });
  }
  std::vector<unsigned int> indices;
  for (const Triangle& t : mesh.triangles)
  {
    indices.insert(indices.end(), { t[0], t[1], t[2] });
  }
  std::vector<unsigned int> simplified(indices.size());
  const double start = Now();
  simplified.resize(meshopt_simplify(simplified.data(), indices.data(), indices.size(),
    positions.data(), mesh.points.size(), 3 * sizeof(float), 3 * triangles, 1.0F));
  PeerMesh peer{ "meshopt_simplify", { mesh.points, {} }, Now() - start };
  for (std::size_t i = 0; i + 2 < simplified.size(); i += 3)
  {
    peer.mesh.triangles.push_back({ simplified[i], simplified[i + 1], simplified[i + 2] });
  }
  return peer;
}
#endif

}

LevelPeers::LevelPeers(const Mesh& mesh)
  : Input(mesh)
  , Data(ToPolyData(mesh))
{
}

std::vector<PeerMesh> LevelPeers::ByTarget(std::size_t triangles) const
{
  const double reduction = 1 - double(triangles) / double(this->Input.triangles.size());
  std::vector<PeerMesh> peers;
  vtkNew<vtkQuadricDecimation> quadric;
  quadric->SetTargetReduction(reduction);
  peers.push_back(Run("vtkQuadricDecimation", quadric.Get(), this->Data));
  vtkNew<vtkDecimatePro> pro;
  pro->SetTargetReduction(reduction);
  pro->PreserveTopologyOff();
  peers.push_back(Run("vtkDecimatePro", pro.Get(), this->Data));
#ifdef KDSTREAM_MESHOPTIMIZER
  peers.push_back(RunMeshoptimizer(this->Input, triangles));
#endif
  return peers;
}

std::vector<PeerMesh> LevelPeers::ByGrid(std::size_t triangles) const
{
  const auto clustering = [&](int n)
  {
    vtkNew<vtkQuadricClustering> filter;
    filter->AutoAdjustNumberOfDivisionsOff();
    filter->SetNumberOfDivisions(n, n, n);
    return Run("vtkQuadricClustering", filter.Get(), this->Data);
  };
  const auto binned = [&](int n)
  {
    vtkNew<vtkBinnedDecimation> filter;
    filter->AutoAdjustNumberOfDivisionsOff();
    filter->SetNumberOfDivisions(n, n, n);
    filter->SetPointGenerationMode(vtkBinnedDecimation::BIN_AVERAGES);
    return Run("vtkBinnedDecimation", filter.Get(), this->Data);
  };
  std::vector<PeerMesh> peers;
  peers.push_back(SearchDivisions(triangles, clustering));
  peers.push_back(SearchDivisions(triangles, binned));
  return peers;
}

}
