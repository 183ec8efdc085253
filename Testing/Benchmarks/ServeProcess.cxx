// SPDX-License-Identifier: BSD-3-Clause
#include "Testing/Benchmarks/ServeProcess.h"

#include <array>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <string>
#include <sys/wait.h>
#include <unistd.h>

namespace kdstream::benchmarks
{
namespace
{

// The first line that the server prints: it is ready then. Empty if it ends before.
std::string ReadyLine(int pipe)
{
  std::string line;
  char letter = 0;
  while (::read(pipe, &letter, 1) == 1 && letter != '\n')
  {
    line += letter;
  }
  return line;
}

}

ServeProcess::ServeProcess(
  const std::filesystem::path& programs, const std::filesystem::path& stores)
{
  const std::string program = programs / "kdstream-serve";
  const std::string folder = stores;
  std::array<int, 2> ends{};
  if (::pipe(ends.data()) != 0 || (this->Child = ::fork()) < 0)
  {
    std::perror("benchmark: error");
    std::exit(1);
  }
  if (this->Child == 0)
  {
    ::dup2(ends[1], STDOUT_FILENO);
    ::close(ends[0]);
    ::close(ends[1]);
    ::execl(program.c_str(), program.c_str(), folder.c_str(), "--port", "0", nullptr);
    ::_exit(127);
  }
  ::close(ends[1]);
  const std::string line = ReadyLine(ends[0]);
  ::close(ends[0]);
  const std::size_t colon = line.rfind(':');
  const int port = colon == std::string::npos ? 0 : std::atoi(line.c_str() + colon + 1);
  if (port <= 0)
  {
    std::cerr << "benchmark: error: " << program << " does not serve " << folder << "\n";
    std::exit(1);
  }
  this->PortNumber = static_cast<std::uint16_t>(port);
}

ServeProcess::~ServeProcess()
{
  ::kill(this->Child, SIGTERM);
  ::waitpid(this->Child, nullptr, 0);
}

}
