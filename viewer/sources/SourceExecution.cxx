// SPDX-License-Identifier: BSD-3-Clause
#include "viewer/sources/SourceExecution.h"

#include "filters/adapter/AlgorithmExecution.h"

#include <vtkVersionMacros.h>

#include <algorithm>

namespace kdstream
{

void ForgetAbort(vtkAlgorithm& source)
{
  // VTK 9.1 does this only before RequestData, 9.3 never.
  source.AbortExecute = 0;
#if VTK_VERSION_NUMBER >= VTK_VERSION_CHECK(9, 3, 0)
  source.SetAbortOutput(false); // CheckAbort would return it while the source opens
#endif
}

Execution MakeOpeningExecution(vtkAlgorithm& source)
{
  Execution execution = MakeAlgorithmExecution(source, {});
  execution.progress = [&source, mayGoOn = execution.progress](
                         std::string_view step, double fraction)
  {
    source.UpdateProgress(0);
    return mayGoOn(step, fraction);
  };
  return execution;
}

Execution MakeReadingExecution(vtkAlgorithm& source)
{
  Execution execution = MakeAlgorithmExecution(source, {});
  execution.progress = [&source, mayGoOn = execution.progress](
                         std::string_view step, double fraction)
  {
    const double done = step == "pieces" ? 0.8 * fraction
                        : step == "glue" ? 0.8 + 0.1 * fraction
                                         : 0;
    source.UpdateProgress(std::max(source.GetProgress(), done));
    return mayGoOn(step, fraction);
  };
  return execution;
}

}
