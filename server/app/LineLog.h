// SPDX-License-Identifier: BSD-3-Clause
// Writes lines of text to a file, or to stderr, on a thread of its own. So a disk that is full or
// slow, or a pipe that nobody reads, costs lines, never the caller's time.
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
  // The most bytes of lines that wait for the disk; further lines are lost.
  static constexpr std::size_t waitingBytes = std::size_t{ 4 } << 20;

  // The line, with its end, that says that `count` lines are missing.
  using TellLost = std::string (*)(std::uint64_t count);
  // "# 17 lines were lost"
  static std::string LostAsText(std::uint64_t count);

  // Appends to `file`; "-" is stderr. Errors: InputOutput.
  static Result<std::shared_ptr<LineLog>> Open(
    const std::string& file, TellLost tellLost = LostAsText);
  // Does what End does.
  ~LineLog();
  LineLog(const LineLog&) = delete;
  LineLog& operator=(const LineLog&) = delete;

  // Writes what waits, for at most a second. What comes later is lost.
  void End() noexcept;

  // A line with its end. Never waits; lines for which there is no memory are lost. From any thread.
  void Add(std::string_view line) noexcept;

  // The number of lines lost so far, because too many waited or because they could not be written.
  // When the log can be written again, it says how many.
  std::uint64_t Lost() const;

  // Why the last lines that could not be written were not; empty where too many waited.
  std::string WhyLost() const;

  // Opens the file of the log's name anew (log rotation); later lines go there. Errors:
  // InputOutput; then lines still go to the old file.
  Status Reopen();

private:
  struct Writer;
  LineLog(std::string file, std::shared_ptr<Writer> writer);
  std::string File;
  std::shared_ptr<Writer> Lines;
};

}
