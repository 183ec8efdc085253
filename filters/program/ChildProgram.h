// SPDX-License-Identifier: BSD-3-Clause
// Runs another of our programs: its messages come through a pipe, and it ends if the program that
// started it ends.
#pragma once

#include "filters/core/Result.h"

#include <filesystem>
#include <string>
#include <vector>

namespace kdstream
{

class ChildProgram
{
public:
  // Where a program of this name lies: beside this one. It need not be there.
  static std::filesystem::path Beside(const std::string& name);

  // Starts it: its stderr is read here, and its input and output are empty. Errors: LimitExceeded
  // with the operating system's reason. A file that cannot be executed ends with the exit code 127.
  static Result<ChildProgram> Start(
    const std::filesystem::path& program, const std::vector<std::string>& arguments);

  ChildProgram(ChildProgram&& other) noexcept;
  ChildProgram& operator=(ChildProgram&&) = delete;
  // Stops it, if it has not ended.
  ~ChildProgram();

  // Waits up to 100 ms for messages, and appends what has come. False when there will be no more.
  bool Read(std::string& messages);

  // Waits until it has ended. Returns how, as waitpid does.
  int Wait();
  // Asks it to end, and ends it where it has not within two seconds. Returns how it ended.
  int Stop();

private:
  ChildProgram(int process, int messages);

  int Process = -1; // -1: it has ended, and was waited for
  int Messages = -1;
};

}
