// SPDX-License-Identifier: BSD-3-Clause
#include "filters/adapter/AlgorithmExecution.h"

#include "filters/adapter/SmpFor.h"

#include <vtkVersionMacros.h>

#include <algorithm>

namespace kdstream
{
namespace
{

bool MustStop(vtkAlgorithm& algorithm)
{
#if VTK_VERSION_NUMBER >= VTK_VERSION_CHECK(9, 3, 0)
  return algorithm.CheckAbort();
#else
  return algorithm.GetAbortExecute() != 0;
#endif
}

}

Execution MakeAlgorithmExecution(vtkAlgorithm& algorithm, std::vector<StepShare> shares)
{
  Execution execution;
  execution.parallelFor = &SmpFor;
  execution.progress = [&algorithm, steps = std::move(shares)](
                         std::string_view step, double fraction)
  {
    const auto share = std::find_if(steps.begin(), steps.end(),
      [&](const StepShare& candidate) { return candidate.step == step; });
    if (share != steps.end())
    {
      algorithm.UpdateProgress(share->begin + (share->end - share->begin) * fraction);
    }
    return !MustStop(algorithm);
  };
  return execution;
}

}
