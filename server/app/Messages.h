// SPDX-License-Identifier: BSD-3-Clause
// The messages of kdstream-serve on stderr.
//
// While the program starts, each line is written before the work continues. Later a thread of its
// own writes the lines, as for the logs: if nobody reads stderr, lines are lost, but no client
// waits.
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

  // Writes "kdstream-serve: warning: FILE: what", for an error after which the server continues.
  // The file may be "".
  void Warn(const std::string& file, const std::string& what);
  // Writes "kdstream-serve: error: what".
  void Fail(const std::string& what);
  // Writes "kdstream-serve: what".
  void Say(const std::string& what);

  // From now on no caller waits for stderr. Errors: InputOutput.
  Status WaitForNobody();
  // Writes the lines that still wait, for at most a second.
  void End();
  // The number of lines lost since WaitForNobody.
  std::uint64_t Lost() const;

private:
  const std::string Program;
  mutable std::mutex Mutex;
  std::shared_ptr<LineLog> Later; // null while the program starts
};

}
