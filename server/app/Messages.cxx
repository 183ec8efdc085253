// SPDX-License-Identifier: BSD-3-Clause
#include "server/app/Messages.h"

#include "filters/core/Texts.h"

#include <iostream>

namespace kdstream
{

void Messages::Warn(const std::string& file, const std::string& what)
{
  this->Say("warning: " + file + (file.empty() ? "" : ": ") + what);
}

void Messages::Fail(const std::string& what)
{
  this->Say("error: " + what);
}

void Messages::Say(const std::string& what)
{
  // The name of a file may come from a stranger: it must not start a line of its own.
  const auto line = this->Program + ": " + WithoutControls(what) + "\n";
  const std::lock_guard lock(this->Mutex);
  if (this->Later)
  {
    this->Later->Add(line);
    return;
  }
  std::cerr << line << std::flush;
}

Status Messages::WaitForNobody()
{
  auto log = LineLog::Open("-");
  KDSTREAM_TRY(log);
  const std::lock_guard lock(this->Mutex);
  this->Later = std::move(*log);
  return {};
}

void Messages::End()
{
  const std::lock_guard lock(this->Mutex);
  if (this->Later)
  {
    this->Later->End();
  }
}

std::uint64_t Messages::Lost() const
{
  const std::lock_guard lock(this->Mutex);
  return this->Later ? this->Later->Lost() : 0;
}

}
