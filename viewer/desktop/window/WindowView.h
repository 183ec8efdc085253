// SPDX-License-Identifier: BSD-3-Clause
// Shows a view in a window until the user closes it.
#pragma once

#include "filters/core/Result.h"
#include "viewer/desktop/ViewOptions.h"

#include <string>

namespace kdstream
{

// Returns the exit code. Errors: those of DisplayWindow::Make, and of outputs that cannot be
// written at the end. Models that cannot be opened or shown are no errors here: they are reported
// in the window, and on stderr.
Result<int> ViewInWindow(const std::string& program, const ViewOptions& options);

}
