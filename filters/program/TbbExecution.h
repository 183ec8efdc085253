// SPDX-License-Identifier: BSD-3-Clause
// Core's Execution on oneTBB: for the programs.
#pragma once

#include "filters/core/Execution.h"

namespace kdstream
{

// Runs on `threads` threads, 0 = all of the machine's. The result may be copied; it may not be used
// by two algorithms at the same time.
Execution MakeTbbExecution(unsigned threads);

}
