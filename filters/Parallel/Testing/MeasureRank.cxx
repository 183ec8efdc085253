// SPDX-License-Identifier: BSD-3-Clause
// TestBuildMpi runs this as a rank of a job. It runs a program, and writes the program's peak
// memory as measured by the system. Usage: MeasureRank FOLDER PROGRAM ARGUMENTS...; the bytes are
// written to FOLDER/peak-PROCESS; the exit code is that of the program.
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <string>

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

int main(int argc, char** argv)
{
  if (argc < 3)
  {
    std::cerr << "usage: MeasureRank FOLDER PROGRAM ARGUMENTS...\n";
    return 2;
  }
  const pid_t child = ::fork();
  if (child == 0)
  {
    ::execv(argv[2], argv + 2);
    ::_exit(127);
  }
  int status = 0;
  rusage usage{};
  if (child < 0 || ::wait4(child, &status, 0, &usage) != child)
  {
    return 127;
  }
  std::ofstream(std::string(argv[1]) + "/peak-" + std::to_string(child))
    << static_cast<unsigned long long>(usage.ru_maxrss) * 1024;
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}
