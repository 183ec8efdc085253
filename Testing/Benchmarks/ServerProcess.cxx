// SPDX-License-Identifier: BSD-3-Clause
#include "Testing/Benchmarks/ServerProcess.h"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <iterator>

namespace kdstream::benchmarks
{

ServerProcess::ServerProcess(const std::vector<std::string>& command,
  const std::filesystem::path& log, std::optional<rlim_t> descriptors)
{
  std::vector<char*> arguments;
  for (const std::string& word : command)
  {
    arguments.push_back(const_cast<char*>(word.c_str()));
  }
  arguments.push_back(nullptr);
  std::array<int, 2> out{ -1, -1 };
  if (::pipe2(out.data(), O_CLOEXEC) != 0)
  {
    std::cerr << "benchmark: error: no pipe\n";
    std::exit(1);
  }
  this->Id = ::fork();
  if (this->Id == 0)
  {
    const int file = ::open(log.c_str(), O_WRONLY | O_CREAT | O_APPEND, 0644);
    ::dup2(out[1], STDOUT_FILENO);
    ::dup2(file, STDERR_FILENO);
    ::close(file);
    if (descriptors)
    {
      const rlimit limit{ *descriptors, *descriptors };
      ::setrlimit(RLIMIT_NOFILE, &limit);
    }
    ::execv(arguments[0], arguments.data());
    ::_exit(127);
  }
  ::close(out[1]);
  this->Out = out[0];
}

ServerProcess::~ServerProcess()
{
  if (this->Id > 0)
  {
    ::kill(this->Id, SIGKILL);
    ::waitpid(this->Id, nullptr, 0);
  }
  ::close(this->Out);
}

std::uint16_t ServerProcess::ReadPort() const
{
  std::string line;
  for (char c = 0; ::read(this->Out, &c, 1) == 1 && c != '\n';)
  {
    line += c;
  }
  const auto colon = line.rfind(':');
  if (line.rfind("listening on ", 0) != 0 || colon == std::string::npos)
  {
    std::cerr << "benchmark: error: the server did not start\n";
    std::exit(1);
  }
  return static_cast<std::uint16_t>(std::atoi(line.c_str() + colon + 1));
}

double ServerProcess::ResidentMebibytes() const
{
  std::ifstream statm("/proc/" + std::to_string(this->Id) + "/statm");
  double all = 0, resident = 0;
  statm >> all >> resident;
  return resident * static_cast<double>(::sysconf(_SC_PAGESIZE)) / (1 << 20);
}

std::size_t ServerProcess::Descriptors() const
{
  std::error_code error;
  const std::filesystem::directory_iterator files(
    "/proc/" + std::to_string(this->Id) + "/fd", error);
  return static_cast<std::size_t>(std::distance(begin(files), end(files)));
}

bool ServerProcess::IsAlive() const
{
  siginfo_t ended{};
  return this->Id > 0 &&
         ::waitid(P_PID, static_cast<id_t>(this->Id), &ended, WEXITED | WNOHANG | WNOWAIT) == 0 &&
         ended.si_pid == 0;
}

bool ServerProcess::End()
{
  int status = 0;
  ::kill(this->Id, SIGTERM);
  const bool ended = ::waitpid(this->Id, &status, 0) == this->Id;
  this->Id = -1;
  return ended && WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

}
