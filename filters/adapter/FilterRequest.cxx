// SPDX-License-Identifier: BSD-3-Clause
#include "filters/adapter/FilterRequest.h"

#include "filters/adapter/JoinPolyData.h"

#include <vtkErrorCode.h>

namespace kdstream
{

void AcceptMeshes(vtkInformation& port)
{
  port.Remove(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE());
  // If a composite type is missing here, VTK runs the filter block by block.
  for (const char* const type : { "vtkPolyData", "vtkDataObjectTree" })
  {
    port.Append(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), type);
  }
}

Result<vtkSmartPointer<vtkPolyData>> JoinInput(
  vtkAlgorithm& filter, vtkDataObject& input, bool weldByPlace, const Execution& execution)
{
  const Result<JoinedPolyData> joined = JoinPolyData(input, weldByPlace, execution);
  KDSTREAM_TRY(joined);
  WarnOfArrays(filter, joined->leftOut);
  return joined->mesh;
}

void WarnOfArrays(vtkAlgorithm& filter, const std::vector<std::string>& leftOut)
{
  std::string text;
  for (const std::string& array : leftOut)
  {
    text += (text.empty() ? "left out: " : "; ") + array;
  }
  if (!text.empty())
  {
    vtkWarningWithObjectMacro(&filter, << text);
  }
}

void WarnOfSameMesh(vtkAlgorithm& filter)
{
  vtkWarningWithObjectMacro(&filter,
    << "all processes have the same mesh, so the result contains it once per process: let one "
       "process read it and give the others an empty vtkPolyData, or give each process its part");
}

unsigned long ReportError(vtkAlgorithm& filter, const Status& status)
{
  if (status || status.GetError().code == ErrorCode::Cancelled)
  {
    return vtkErrorCode::NoError;
  }
  vtkErrorWithObjectMacro(&filter, << status.GetError().message);
  return vtkErrorCode::UnknownError;
}

}
