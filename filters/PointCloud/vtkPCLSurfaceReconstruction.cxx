// SPDX-License-Identifier: BSD-3-Clause
// Steps:
// 1. convert the input to one cloud: its points and normals, in core's types
// 2. reconstruct the surface (SurfaceReconstruction)
// 3. make the output's points, arrays and triangles.
#include "vtkPCLSurfaceReconstruction.h"

#include "filters/PointCloud/SurfaceReconstruction.h"
#include "filters/adapter/AlgorithmExecution.h"
#include "filters/adapter/FilterRequest.h"
#include "filters/adapter/PolyDataMesh.h"
#include "filters/adapter/RangedSetters.h"

#include <vtkCellArray.h>
#include <vtkErrorCode.h>
#include <vtkFloatArray.h>
#include <vtkIdList.h>
#include <vtkInformation.h>
#include <vtkInformationVector.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>

#include <new>
#include <numeric>

vtkStandardNewMacro(vtkPCLSurfaceReconstruction);

KDSTREAM_SET_IN_RANGE(vtkPCLSurfaceReconstruction, NumberOfNeighbors, int, 3, 1000)
KDSTREAM_SET_IN_RANGE(vtkPCLSurfaceReconstruction, NormalRadius, double, 0.0, VTK_DOUBLE_MAX)
KDSTREAM_SET_IN_RANGE(vtkPCLSurfaceReconstruction, SearchRadius, double, 0.0, VTK_DOUBLE_MAX)
KDSTREAM_SET_IN_RANGE(vtkPCLSurfaceReconstruction, Mu, double, 0.0, VTK_DOUBLE_MAX)
KDSTREAM_SET_IN_RANGE(vtkPCLSurfaceReconstruction, MaximumNumberOfNeighbors, int, 3, 10000)
KDSTREAM_SET_IN_RANGE(vtkPCLSurfaceReconstruction, MaximumSurfaceAngle, double, 0.0, 180.0)
KDSTREAM_SET_IN_RANGE(vtkPCLSurfaceReconstruction, MinimumAngle, double, 0.0, 180.0)
KDSTREAM_SET_IN_RANGE(vtkPCLSurfaceReconstruction, MaximumAngle, double, 0.0, 180.0)
KDSTREAM_SET_IN_RANGE(vtkPCLSurfaceReconstruction, Depth, int, 0, 12)
KDSTREAM_SET_IN_RANGE(vtkPCLSurfaceReconstruction, SamplesPerNode, double, 0.5, 100.0)
KDSTREAM_SET_IN_RANGE(vtkPCLSurfaceReconstruction, PointWeight, double, 0.0, 100.0)
KDSTREAM_SET_IN_RANGE(vtkPCLSurfaceReconstruction, TrimDistance, double, 0.0, VTK_DOUBLE_MAX)
KDSTREAM_SET_FINITE(vtkPCLSurfaceReconstruction, ViewPoint)

namespace
{

using namespace kdstream;

std::vector<Vec3> ReadNormals(vtkPolyData& input)
{
  vtkDataArray* const array = input.GetPointData()->GetNormals();
  std::vector<Vec3> normals;
  if (array && array->GetNumberOfComponents() == 3 &&
      array->GetNumberOfTuples() == input.GetNumberOfPoints())
  {
    normals.resize(static_cast<std::size_t>(array->GetNumberOfTuples()));
    for (std::size_t i = 0; i < normals.size(); ++i)
    {
      array->GetTuple(static_cast<vtkIdType>(i), normals[i].data());
    }
  }
  return normals;
}

// Adds the surface's own points, each with the data of the nearest input point.
void FillPoints(const Reconstruction& surface, vtkPolyData& input, vtkPolyData& output)
{
  const auto count = static_cast<vtkIdType>(surface.points.size());
  vtkNew<vtkPoints> points;
  points->SetDataType(input.GetPoints()->GetDataType() == VTK_FLOAT ? VTK_FLOAT : VTK_DOUBLE);
  points->SetNumberOfPoints(count);
  vtkNew<vtkIdList> from, to;
  from->SetNumberOfIds(count);
  to->SetNumberOfIds(count);
  for (vtkIdType i = 0; i < count; ++i)
  {
    const auto point = static_cast<std::size_t>(i);
    points->SetPoint(i, surface.points[point].data());
    from->SetId(i, vtkIdType{ surface.nearest[point] });
    to->SetId(i, i);
  }
  output.SetPoints(points);
  vtkPointData* const data = output.GetPointData();
  data->CopyNormalsOff(); // the surface has its own normals
  data->CopyAllocate(input.GetPointData(), count);
  data->CopyData(input.GetPointData(), from, to);
}

void AddNormals(const std::vector<Vec3>& normals, vtkPolyData& output)
{
  vtkNew<vtkFloatArray> array;
  array->SetName("Normals");
  array->SetNumberOfComponents(3);
  array->SetNumberOfTuples(static_cast<vtkIdType>(normals.size()));
  for (std::size_t i = 0; i < normals.size(); ++i)
  {
    array->SetTuple(static_cast<vtkIdType>(i), normals[i].data());
  }
  output.GetPointData()->SetNormals(array);
}

void FillTriangles(const std::vector<Triangle>& triangles, vtkPolyData& output)
{
  vtkNew<vtkCellArray> cells;
  const auto count = static_cast<vtkIdType>(triangles.size());
  cells->AllocateExact(count, 3 * count);
  for (const Triangle& t : triangles)
  {
    const vtkIdType ids[] = { t[0], t[1], t[2] };
    cells->InsertNextCell(3, ids);
  }
  output.SetPolys(cells);
}

}

vtkPCLSurfaceReconstruction::vtkPCLSurfaceReconstruction() = default;

const char* vtkPCLSurfaceReconstruction::GetMethodAsString() const
{
  return this->Method == POISSON ? "Poisson" : "Greedy";
}

const char* vtkPCLSurfaceReconstruction::GetOrientationAsString() const
{
  return this->Orientation == TOWARDS_VIEWPOINT ? "TowardsViewPoint" : "NeighborsAgree";
}

int vtkPCLSurfaceReconstruction::FillInputPortInformation(int, vtkInformation* info)
{
  AcceptMeshes(*info);
  return 1;
}

int vtkPCLSurfaceReconstruction::RequestData(
  vtkInformation*, vtkInformationVector** inputVector, vtkInformationVector* outputVector)
{
  vtkPolyData* const output = vtkPolyData::GetData(outputVector);
  this->SetErrorCode(vtkErrorCode::NoError);
  const Execution execution =
    MakeAlgorithmExecution(*this, { { "neighbors", 0, 0.2 }, { "normals", 0.2, SurfaceProgress },
                                    { "surface", SurfaceProgress, 1 } });
  const auto joined =
    JoinInput(*this, *vtkDataObject::GetData(inputVector[0]), this->WeldByPlace, execution);
  if (!joined)
  {
    this->SetErrorCode(ReportError(*this, joined.GetError()));
    return 0;
  }
  vtkPolyData* const input = *joined;
  if (input->GetNumberOfPoints() == 0)
  {
    return 1;
  }
  ReconstructionOptions options;
  options.method = this->Method == POISSON ? ReconstructionOptions::Method::Poisson
                                           : ReconstructionOptions::Method::Greedy;
  options.neighbors = static_cast<std::uint32_t>(this->NumberOfNeighbors);
  options.normalRadius = this->NormalRadius;
  options.towardsViewpoint = this->Orientation == TOWARDS_VIEWPOINT;
  options.viewpoint = { this->ViewPoint[0], this->ViewPoint[1], this->ViewPoint[2] };
  options.searchRadius = this->SearchRadius;
  options.mu = this->Mu;
  options.maximumNeighbors = static_cast<std::uint32_t>(this->MaximumNumberOfNeighbors);
  options.maximumSurfaceAngle = this->MaximumSurfaceAngle;
  options.minimumAngle = this->MinimumAngle;
  options.maximumAngle = this->MaximumAngle;
  options.depth = static_cast<std::uint32_t>(this->Depth);
  options.samplesPerNode = this->SamplesPerNode;
  options.pointWeight = this->PointWeight;
  options.trimDistance = this->TrimDistance;

  const Result<std::vector<Vec3>> points = ReadPoints(*input, execution);
  Result<Reconstruction> surface = Error{};
  if (!points)
  {
    surface = points.GetError();
  }
  else
  {
    const std::vector<Vec3> normals =
      this->UseInputNormals ? ReadNormals(*input) : std::vector<Vec3>{};
    surface = ReconstructSurface(*points, normals, options, execution);
  }
  if (!surface)
  {
    this->SetErrorCode(ReportError(*this, surface.GetError()));
    return this->GetErrorCode() == vtkErrorCode::NoError ? 1 : 0;
  }
  if (this->Method == POISSON)
  {
    FillPoints(*surface, *input, *output);
  }
  else
  {
    output->SetPoints(input->GetPoints());
    output->GetPointData()->PassData(input->GetPointData());
  }
  AddNormals(surface->normals, *output);
  FillTriangles(surface->triangles, *output);
  return 1;
}

void vtkPCLSurfaceReconstruction::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "Method: " << this->GetMethodAsString() << "\n";
  os << indent << "UseInputNormals: " << (this->UseInputNormals ? "on" : "off") << "\n";
  os << indent << "NumberOfNeighbors: " << this->NumberOfNeighbors << "\n";
  os << indent << "NormalRadius: " << this->NormalRadius << "\n";
  os << indent << "Orientation: " << this->GetOrientationAsString() << "\n";
  os << indent << "ViewPoint: (" << this->ViewPoint[0] << ", " << this->ViewPoint[1] << ", "
     << this->ViewPoint[2] << ")\n";
  os << indent << "SearchRadius: " << this->SearchRadius << "\n";
  os << indent << "Mu: " << this->Mu << "\n";
  os << indent << "MaximumNumberOfNeighbors: " << this->MaximumNumberOfNeighbors << "\n";
  os << indent << "MaximumSurfaceAngle: " << this->MaximumSurfaceAngle << "\n";
  os << indent << "MinimumAngle: " << this->MinimumAngle << "\n";
  os << indent << "MaximumAngle: " << this->MaximumAngle << "\n";
  os << indent << "Depth: " << this->Depth << "\n";
  os << indent << "SamplesPerNode: " << this->SamplesPerNode << "\n";
  os << indent << "PointWeight: " << this->PointWeight << "\n";
  os << indent << "TrimDistance: " << this->TrimDistance << "\n";
  os << indent << "WeldByPlace: " << (this->WeldByPlace ? "on" : "off") << "\n";
}
