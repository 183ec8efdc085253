// SPDX-License-Identifier: BSD-3-Clause
// What is done in a window, as a session file that plays again.
#pragma once

#include "filters/core/Result.h"
#include "viewer/session/SessionFile.h"

#include <fstream>
#include <string>

namespace kdstream
{

// Every step is on the disk as soon as it is taken. What is played again waits where somebody has
// waited: a step that comes when all was there has a wait before it.
class SessionRecorder
{
public:
  // Records nothing where `file` is empty. Errors: InputOutput.
  static Result<SessionRecorder> Make(const std::string& file);

  bool IsOn() const { return this->Output.is_open(); }

  // The session is idle; call before the steps that come then.
  void NoteIdle() { this->IsIdle = true; }
  void Add(const SessionStep& step);
  // All that was asked for at the end is waited for too. Errors: InputOutput where anything could
  // not be written.
  Status Finish();

private:
  void Write(const SessionStep& step);

  std::ofstream Output;
  bool IsIdle = false;
  bool HasSteps = false; // since the last wait
};

}
