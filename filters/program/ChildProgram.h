// SPDX-License-Identifier: BSD-3-Clause
// Runs another of our programs. Its messages come through a pipe, and it ends if the program that
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
  // The path of a program in the folder of this one; it may not exist.
  static std::filesystem::path Beside(const std::string& name);

  // Starts the program. Its stderr is read here; its input and output are empty. Errors:
  // LimitExceeded, with the operating system's reason. If the file cannot be executed, the process
  // ends with exit code 127.
  static Result<ChildProgram> Start(
    const std::filesystem::path& program, const std::vector<std::string>& arguments);

  ChildProgram(ChildProgram&& other) noexcept;
  ChildProgram& operator=(ChildProgram&&) = delete;
  // Stops the program if it has not ended.
  ~ChildProgram();

  // Waits up to 100 ms for messages, and appends those that have come. Returns false when there
  // will be no more.
  bool Read(std::string& messages);

  // Waits until the program has ended. Returns its status as waitpid does.
  int Wait();
  // Asks the program to end, and kills it if it has not ended within two seconds. Returns its
  // status.
  int Stop();

private:
  ChildProgram(int process, int messages);

  int Process = -1; // -1: it has ended, and its status was read
  int Messages = -1;
};

}
