// SPDX-License-Identifier: BSD-3-Clause
// What is done in a window, as a session file that plays again.
#pragma once

#include "filters/core/Result.h"
#include "viewer/session/SessionFile.h"

#include <fstream>
#include <string>

namespace kdstream
{

// Writes every step to the disk at once. If the user waited until everything had arrived before a
// step, a wait is recorded before it, so that a replay waits there, too.
class SessionRecorder
{
public:
  // Records nothing where `file` is empty. Errors: InputOutput.
  static Result<SessionRecorder> Make(const std::string& file);

  bool IsOn() const { return this->Output.is_open(); }

  // The session is idle; call before the steps that come then.
  void NoteIdle() { this->IsIdle = true; }
  void Add(const SessionStep& step);
  // Ends with a wait for everything that was requested. Errors: InputOutput if anything could not
  // be written.
  Status Finish();

private:
  void Write(const SessionStep& step);

  std::ofstream Output;
  bool IsIdle = false;
  bool HasSteps = false; // since the last wait
};

}
