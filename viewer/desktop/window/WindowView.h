// SPDX-License-Identifier: BSD-3-Clause
// A view in a window, until somebody closes it.
#pragma once

#include "filters/core/Result.h"
#include "viewer/desktop/ViewOptions.h"

#include <string>

namespace kdstream
{

// Returns the exit code. Errors: those of DisplayWindow::Make, and of outputs that cannot be
// written at the end. Models that cannot be opened or shown are reported in the window, and on
// stderr.
Result<int> ViewInWindow(const std::string& program, const ViewOptions& options);

}
