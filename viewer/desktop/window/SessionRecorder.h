// SPDX-License-Identifier: BSD-3-Clause
// Records what is done in a window as a session file, which can be replayed.
#pragma once

#include "filters/core/Result.h"
#include "viewer/session/SessionFile.h"

#include <fstream>
#include <string>

namespace kdstream
{

// Writes every step to the disk at once. If the user did a step only after everything had arrived,
// a wait is recorded before the step, so that a replay waits there, too.
class SessionRecorder
{
public:
  // Records nothing if `file` is empty. Errors: InputOutput.
  static Result<SessionRecorder> Make(const std::string& file);

  bool IsOn() const { return this->Output.is_open(); }

  // The session is idle. Call this before adding the steps that follow.
  void NoteIdle() { this->IsIdle = true; }
  void Add(const SessionStep& step);
  // Ends the file with a wait for everything that was requested. Errors: InputOutput if anything
  // could not be written.
  Status Finish();

private:
  void Write(const SessionStep& step);

  std::ofstream Output;
  bool IsIdle = false;
  bool HasSteps = false; // since the last wait
};

}
