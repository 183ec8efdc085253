// SPDX-License-Identifier: BSD-3-Clause
// What all filters do in the same way at the beginning and at the end of RequestData.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/Result.h"

#include <vtkAlgorithm.h>
#include <vtkInformation.h>
#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

#include <string>
#include <vector>

namespace kdstream
{

// Makes an input port accept the types that JoinPolyData accepts.
void AcceptMeshes(vtkInformation& port);

// Joins the input to one vtkPolyData without ghosts (JoinPolyData). The filter gives one warning
// that lists the omitted arrays.
Result<vtkSmartPointer<vtkPolyData>> JoinInput(
  vtkAlgorithm& filter, vtkDataObject& input, bool weldByPlace, const Execution& execution);

// Gives one warning, "left out: WHAT; WHAT"; none if the list is empty.
void WarnOfArrays(vtkAlgorithm& filter, const std::vector<std::string>& leftOut);

// Warns once if all processes have the same mesh, for example because each has read the same file.
void WarnOfSameMesh(vtkAlgorithm& filter);

// Prints the error of a filter that does not read a file, and returns the code for its
// SetErrorCode: UnknownError. If there is no error, or the filter was aborted, prints nothing and
// returns NoError.
unsigned long ReportError(vtkAlgorithm& filter, const Status& status);

}
