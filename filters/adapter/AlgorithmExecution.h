// SPDX-License-Identifier: BSD-3-Clause
// Core's Execution inside a VTK filter: it uses VTK's threads, progress and abort.
#pragma once

#include "filters/core/Execution.h"

#include <vtkAlgorithm.h>

#include <string_view>
#include <vector>

namespace kdstream
{

// One step of the algorithm, and the part of the filter's progress (0-1) that it takes.
struct StepShare
{
  std::string_view step;
  double begin = 0;
  double end = 1;
};

// Runs on vtkSMPTools, reports through UpdateProgress, and stops when the filter is aborted. Steps
// that are not named in `shares` report no progress, but can be aborted too. The algorithm must
// outlive the result.
Execution MakeAlgorithmExecution(vtkAlgorithm& algorithm, std::vector<StepShare> shares);

}
