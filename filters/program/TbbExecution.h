// SPDX-License-Identifier: BSD-3-Clause
// Core's Execution on oneTBB: for the programs.
#pragma once

#include "filters/core/Execution.h"

namespace kdstream
{

// Runs on `threads` threads; 0 = as many as the machine has. The result may be copied, but two
// algorithms must not use it at the same time.
Execution MakeTbbExecution(unsigned threads);

}
