// SPDX-License-Identifier: BSD-3-Clause
// How sources run: on VTK's threads. While they wait, the unchanged progress is reported, so that
// an observer can stop them; so can any other thread, by vtkAlgorithm::SetAbortExecute.
#pragma once

#include "filters/core/Execution.h"

#include <vtkAlgorithm.h>

namespace kdstream
{

// Where an Update begins: an abort of before counts no more.
void ForgetAbort(vtkAlgorithm& source);

// For what is opened before the information of a pipeline is told: progress is 0.
Execution MakeOpeningExecution(vtkAlgorithm& source);

// For what is read then. Progress never falls, though steps begin anew: "pieces" are four fifths of
// it, "glue" is a tenth; of all others nothing but the time is reported.
Execution MakeReadingExecution(vtkAlgorithm& source);

}
