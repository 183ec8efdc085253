// SPDX-License-Identifier: BSD-3-Clause
#include "filters/convert/Reconstruct.h"

#ifdef KDSTREAM_HAS_PCL
#include "filters/adapter/PolyDataAttributes.h"
#include "filters/convert/PolyDataParts.h"
#include "filters/convert/VtkMessages.h"

#include <vtkCallbackCommand.h>
#include <vtkNew.h>
#include <vtkPCLSurfaceReconstruction.h>
#include <vtkPoints.h>
#endif

namespace kdstream
{

#ifdef KDSTREAM_HAS_PCL
namespace
{

Status FillPolyData(const Mesh& mesh, vtkPolyData& output)
{
  vtkNew<vtkPoints> points;
  points->SetDataType(mesh.scalarType == ScalarType::Float32 ? VTK_FLOAT : VTK_DOUBLE);
  points->SetNumberOfPoints(static_cast<vtkIdType>(mesh.points.size()));
  for (std::size_t i = 0; i < mesh.points.size(); ++i)
  {
    points->SetPoint(static_cast<vtkIdType>(i), mesh.points[i].data());
  }
  output.SetPoints(points);
  return WriteAttributes(mesh.attributes, output);
}

}

Result<ForeignMesh> ReconstructMesh(
  ForeignMesh cloud, Reconstruct method, const Execution& execution)
{
  if (!cloud.mesh.triangles.empty())
  {
    return Error{ ErrorCode::InvalidInput, "has " + std::to_string(cloud.mesh.triangles.size()) +
                                             " triangles; --reconstruct is for point clouds" };
  }
  vtkNew<vtkPolyData> input;
  KDSTREAM_TRY(FillPolyData(cloud.mesh, *input));
  cloud.mesh = Mesh{};
  VtkMessages messages;
  vtkNew<vtkPCLSurfaceReconstruction> filter;
  filter->SetInputData(input);
  filter->SetMethod(method == Reconstruct::Poisson ? vtkPCLSurfaceReconstruction::POISSON
                                                   : vtkPCLSurfaceReconstruction::GREEDY);
  vtkNew<vtkCallbackCommand> command;
  command->SetClientData(const_cast<Execution*>(&execution));
  command->SetCallback(
    [](vtkObject* caller, unsigned long, void* data, void* fraction)
    {
      // A share of the whole would not change for most of the time.
      const double ofNormals =
        *static_cast<const double*>(fraction) / vtkPCLSurfaceReconstruction::SurfaceProgress;
      const Execution& report = *static_cast<Execution*>(data);
      const bool goOn =
        ofNormals < 1 ? report.progress("normals", ofNormals) : report.progress("surface", 0);
      static_cast<vtkAlgorithm*>(caller)->SetAbortExecute(goOn ? 0 : 1);
    });
  filter->AddObserver(vtkCommand::ProgressEvent, command);
  filter->Update();
  Status status = execution.Report("surface", 0);
  if (status)
  {
    status = messages.FirstError();
  }
  if (!status)
  {
    Error error = status.GetError();
    const std::string name = "vtkPCLSurfaceReconstruction: ";
    error.message.erase(0, error.message.rfind(name, 0) == 0 ? name.size() : 0);
    return error;
  }
  Result<ForeignMesh> surface = ReadPolyData(*filter->GetOutput(), execution);
  if (surface && surface->mesh.triangles.empty())
  {
    return Error{ ErrorCode::InvalidInput, "no surface was found: its points do not lie on one" };
  }
  if (surface)
  {
    surface->warnings.insert(
      surface->warnings.begin(), cloud.warnings.begin(), cloud.warnings.end());
  }
  return surface;
}

#else

Result<ForeignMesh> ReconstructMesh(ForeignMesh, Reconstruct, const Execution&)
{
  return Error{ ErrorCode::Unsupported,
    "--reconstruct needs PCL, but kdstream-convert was built without it: install PCL (Debian: "
    "libpcl-dev) and build kdstream-convert again" };
}

#endif

}
