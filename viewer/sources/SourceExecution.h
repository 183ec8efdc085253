// SPDX-License-Identifier: BSD-3-Clause
// How sources run: on VTK's threads. While they wait, they report unchanged progress again and
// again, so that an observer can abort. Any other thread can abort, too, by
// vtkAlgorithm::SetAbortExecute.
#pragma once

#include "filters/core/Execution.h"

#include <vtkAlgorithm.h>

namespace kdstream
{

// Call when an Update begins: an earlier abort no longer counts.
void ForgetAbort(vtkAlgorithm& source);

// For opening a model, before the output information is known: progress stays 0.
Execution MakeOpeningExecution(vtkAlgorithm& source);

// For reading. Progress never falls, even if a step begins again. Step "pieces" is four fifths of
// the progress, "glue" a tenth; the other steps leave it unchanged.
Execution MakeReadingExecution(vtkAlgorithm& source);

}
