// SPDX-License-Identifier: BSD-3-Clause
// Writes lines of text to a file, or to stderr, on a thread of its own. If a disk is full or slow,
// or nobody reads a pipe, lines are lost, but the caller never waits.
#pragma once

#include "filters/core/Result.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

namespace kdstream
{

class LineLog
{
public:
  // Bytes of lines that may wait for the disk; further lines are lost.
  static constexpr std::size_t waitingBytes = std::size_t{ 4 } << 20;

  // Writes the line, including its end, that says that `count` lines are missing.
  using TellLost = std::string (*)(std::uint64_t count);
  // "# 17 lines were lost"
  static std::string LostAsText(std::uint64_t count);

  // Appends to `file`; "-" is stderr. Errors: InputOutput.
  static Result<std::shared_ptr<LineLog>> Open(
    const std::string& file, TellLost tellLost = LostAsText);
  // Calls End.
  ~LineLog();
  LineLog(const LineLog&) = delete;
  LineLog& operator=(const LineLog&) = delete;

  // Writes the waiting lines, for at most a second. Lines added later are lost.
  void End() noexcept;

  // Adds a line, which includes its end. Never waits. If there is no memory for the line, it is
  // lost. From any thread.
  void Add(std::string_view line) noexcept;

  // The number of lines lost so far, because too many were waiting or because they could not be
  // written. When the log can be written again, a line gives this number.
  std::uint64_t Lost() const;

  // Why the last lost lines could not be written; empty if they were lost because too many were
  // waiting.
  std::string WhyLost() const;

  // Opens a file with the log's name again (log rotation). Later lines go to that file. Errors:
  // InputOutput; then lines still go to the old file.
  Status Reopen();

private:
  struct Writer;
  LineLog(std::string file, std::shared_ptr<Writer> writer);
  std::string File;
  std::shared_ptr<Writer> Lines;
};

}
