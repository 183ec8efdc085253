// SPDX-License-Identifier: BSD-3-Clause
// The messages of kdstream-serve on stderr.
//
// During the start each line is written before the work continues. Later a thread of its own writes
// them, like the logs: if nobody reads stderr, lines are lost, but no client waits.
#pragma once

#include "filters/core/Result.h"
#include "server/app/LineLog.h"

#include <cstdint>
#include <memory>
#include <mutex>
#include <string>

namespace kdstream
{

// All functions from any thread.
class Messages
{
public:
  explicit Messages(std::string program)
    : Program(std::move(program))
  {
  }

  // "kdstream-serve: warning: FILE: what": an error after which the server continues. The file may
  // be "".
  void Warn(const std::string& file, const std::string& what);
  // "kdstream-serve: error: what"
  void Fail(const std::string& what);
  // "kdstream-serve: what"
  void Say(const std::string& what);

  // From now on nobody waits for stderr. Errors: InputOutput.
  Status WaitForNobody();
  // Writes what has been said, for at most a second.
  void End();
  // Lines that could not be written since then.
  std::uint64_t Lost() const;

private:
  const std::string Program;
  mutable std::mutex Mutex;
  std::shared_ptr<LineLog> Later; // null while the program starts
};

}
