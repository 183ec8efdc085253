// SPDX-License-Identifier: BSD-3-Clause
// The execution of sources: on VTK's threads. While they wait, the unchanged progress is reported,
// so that an observer can abort; so can any other thread, by vtkAlgorithm::SetAbortExecute.
#pragma once

#include "filters/core/Execution.h"

#include <vtkAlgorithm.h>

namespace kdstream
{

// Called when an Update begins: an earlier abort no longer counts.
void ForgetAbort(vtkAlgorithm& source);

// For opening, before the output information is known: progress is 0.
Execution MakeOpeningExecution(vtkAlgorithm& source);

// For reading. Progress never falls, although steps begin anew: "pieces" are four fifths of it,
// "glue" a tenth; all other steps report only that time passes.
Execution MakeReadingExecution(vtkAlgorithm& source);

}
