// SPDX-License-Identifier: BSD-3-Clause
#include "Testing/Benchmarks/MeasuredRun.h"

#include <cstdlib>
#include <iostream>

#include <chrono>
#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

namespace kdstream::benchmarks
{

Cost RunMeasured(const std::vector<std::string>& command, const std::filesystem::path& output)
{
  std::vector<char*> arguments;
  for (const std::string& word : command)
  {
    arguments.push_back(const_cast<char*>(word.c_str()));
  }
  arguments.push_back(nullptr);
  const auto begin = std::chrono::steady_clock::now();
  const pid_t child = ::fork();
  if (child == 0)
  {
    const int file = ::open(output.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
    ::dup2(file, STDOUT_FILENO);
    ::execv(arguments[0], arguments.data());
    ::_exit(127);
  }
  int status = 0;
  rusage usage{};
  if (child < 0 || ::wait4(child, &status, 0, &usage) != child || !WIFEXITED(status) ||
      WEXITSTATUS(status) != 0)
  {
    std::cerr << "benchmark: error: " << command[0] << " failed\n";
    std::exit(1);
  }
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
  const auto of = [](const timeval& time)
  { return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec); };
  return { seconds.count(), of(usage.ru_utime) + of(usage.ru_stime),
    static_cast<double>(usage.ru_maxrss) / 1024, {} };
}

}
