// SPDX-License-Identifier: BSD-3-Clause
// A look without a screen: one model, or a session file, and what is written of it.
#pragma once

#include "filters/core/Result.h"
#include "viewer/client/ModelSource.h"
#include "viewer/desktop/ViewOptions.h"
#include "viewer/session/SessionFile.h"

#include <string>
#include <vector>

namespace kdstream
{

// The steps of a session file, whose pictures can be written; none if no file is named. Errors:
// NotFound; those of ParseSession.
Result<std::vector<SessionStep>> ReadReplay(const std::string& file);

// Plays, and writes the outputs. Returns the exit code: a part of the model that could not be
// loaded makes it a failure, but the session goes on without that part. Errors: those of what
// cannot be played or written; InvalidArgument where a model has to be chosen.
Result<int> ViewHeadless(const std::string& program, const ViewOptions& options,
  const std::vector<SessionStep>& replay, ModelSource& source);

}
