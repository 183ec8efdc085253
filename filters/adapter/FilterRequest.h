// SPDX-License-Identifier: BSD-3-Clause
// What all filters do at the begin and at the end of RequestData, in one way.
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

// Lets an input port take what JoinPolyData does.
void AcceptMeshes(vtkInformation& port);

// The input as one vtkPolyData without ghosts (JoinPolyData); the filter gives one warning that
// lists the arrays left out.
Result<vtkSmartPointer<vtkPolyData>> JoinInput(
  vtkAlgorithm& filter, vtkDataObject& input, bool weldByPlace, const Execution& execution);

// "left out: WHAT; WHAT", as one warning; none if it is empty.
void WarnOfArrays(vtkAlgorithm& filter, const std::vector<std::string>& leftOut);

// One warning where all processes have the same mesh, as where each has read the same file.
void WarnOfSameMesh(vtkAlgorithm& filter);

// Prints the error of a filter that reads no file, and returns the code for its SetErrorCode:
// UnknownError. Without an error, or where the filter was aborted, prints nothing and returns
// NoError.
unsigned long ReportError(vtkAlgorithm& filter, const Status& status);

}
