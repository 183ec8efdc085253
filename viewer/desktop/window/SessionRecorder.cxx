// SPDX-License-Identifier: BSD-3-Clause
// Records what is done in a window as a session file: see SessionRecorder.h.
#include "viewer/desktop/window/SessionRecorder.h"

#include "filters/core/SystemReason.h"

#include <cerrno>

namespace kdstream
{

Result<SessionRecorder> SessionRecorder::Make(const std::string& file)
{
  SessionRecorder recorder;
  if (!file.empty())
  {
    recorder.Output.open(file, std::ios::binary | std::ios::trunc);
    if (!recorder.Output)
    {
      return SystemError("cannot be written", errno);
    }
  }
  return recorder;
}

void SessionRecorder::Add(const SessionStep& step)
{
  if (!this->IsOn())
  {
    return;
  }
  if (this->IsIdle && this->HasSteps)
  {
    this->Write({ SessionStep::Kind::WaitForIdle, {} });
    this->HasSteps = false;
  }
  this->IsIdle = false;
  this->HasSteps = true;
  this->Write(step);
}

Status SessionRecorder::Finish()
{
  if (!this->IsOn())
  {
    return {};
  }
  if (this->HasSteps)
  {
    this->Write({ SessionStep::Kind::WaitForIdle, {} });
  }
  this->Output.close();
  return this->Output ? Status{} : Status(SystemError("cannot be written", errno));
}

void SessionRecorder::Write(const SessionStep& step)
{
  this->Output << FormatSessionStep(step) << "\n" << std::flush;
}

}
