// SPDX-License-Identifier: BSD-3-Clause
// Shows one model, or plays a session file, without a screen, and writes the outputs.
#pragma once

#include "filters/core/Result.h"
#include "viewer/client/ModelSource.h"
#include "viewer/desktop/ViewOptions.h"
#include "viewer/session/SessionFile.h"

#include <string>
#include <vector>

namespace kdstream
{

// Reads the steps of a session file, and checks that its pictures can be written; no steps if no
// file is named. Errors: NotFound; those of ParseSession.
Result<std::vector<SessionStep>> ReadReplay(const std::string& file);

// Plays the session, and writes the outputs. Returns the exit code. A part of the model that cannot
// be loaded does not end the session, but the exit code is that of a failure. Errors: for steps
// that cannot be played and outputs that cannot be written; InvalidArgument if a model must be
// chosen.
Result<int> ViewHeadless(const std::string& program, const ViewOptions& options,
  const std::vector<SessionStep>& replay, ModelSource& source);

}
