// SPDX-License-Identifier: BSD-3-Clause
// Core's Execution inside a VTK filter: threads, progress and abort are VTK's.
#pragma once

#include "filters/core/Execution.h"

#include <vtkAlgorithm.h>

#include <string_view>
#include <vector>

namespace kdstream
{

// The part of a filter's progress (0-1) that one step of the algorithm fills.
struct StepShare
{
  std::string_view step;
  double begin = 0;
  double end = 1;
};

// Runs on vtkSMPTools; reports through UpdateProgress; stops when the filter is aborted. Steps that
// `shares` does not name report no progress, but can be aborted too. The algorithm must outlive the
// result.
Execution MakeAlgorithmExecution(vtkAlgorithm& algorithm, std::vector<StepShare> shares);

}
