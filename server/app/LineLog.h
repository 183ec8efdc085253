// SPDX-License-Identifier: BSD-3-Clause
// Lines of text for a file, or for stderr. A thread of their own writes them. So a disk that is
// full or slow, or a pipe that nobody reads, costs lines, never the caller's time.
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
  // Lines that wait for the disk take at most so many bytes; further ones are lost.
  static constexpr std::size_t waitingBytes = std::size_t{ 4 } << 20;

  // The line, with its end, that says that `count` lines are missing.
  using TellLost = std::string (*)(std::uint64_t count);
  // "# 17 lines were lost"
  static std::string LostAsText(std::uint64_t count);

  // Appends to `file`; "-" is stderr. Errors: InputOutput.
  static Result<std::shared_ptr<LineLog>> Open(
    const std::string& file, TellLost tellLost = LostAsText);
  // What End does.
  ~LineLog();
  LineLog(const LineLog&) = delete;
  LineLog& operator=(const LineLog&) = delete;

  // Writes what waits, for at most a second. What comes later is lost.
  void End() noexcept;

  // With its end. Waits for nobody, and what there is no memory for is lost. From any thread.
  void Add(std::string_view line) noexcept;

  // How many lines have been lost so far, be it that too many waited or that they could not be
  // written. The log itself says how many, once it takes lines again.
  std::uint64_t Lost() const;

  // Why the last lines that could not be written were not; empty where too many waited.
  std::string WhyLost() const;

  // What comes from now on goes to what has the file's name now: log rotation. Errors: InputOutput;
  // then the lines go on where they went.
  Status Reopen();

private:
  struct Writer;
  LineLog(std::string file, std::shared_ptr<Writer> writer);
  std::string File;
  std::shared_ptr<Writer> Lines;
};

}
