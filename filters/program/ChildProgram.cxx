// SPDX-License-Identifier: BSD-3-Clause
// Runs one of our programs from another: see ChildProgram.h.
#include "filters/program/ChildProgram.h"

#include "filters/core/SystemReason.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <thread>
#include <utility>

namespace kdstream
{
namespace
{

using namespace std::chrono_literals;

constexpr auto patienceWithChild = 2s; // between asking the process to end and killing it
constexpr int childPollMilliseconds = 100;

}

std::filesystem::path ChildProgram::Beside(const std::string& name)
{
  std::error_code status;
  return std::filesystem::read_symlink("/proc/self/exe", status).parent_path() / name;
}

Result<ChildProgram> ChildProgram::Start(
  const std::filesystem::path& program, const std::vector<std::string>& arguments)
{
  const auto failed = [&program]
  {
    return Error{ ErrorCode::LimitExceeded,
      "cannot start " + program.filename().string() + ": " + SystemReason(errno) };
  };
  std::array<int, 2> ends{};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0)
  {
    return failed();
  }
  std::vector<char*> argv{ const_cast<char*>(program.c_str()) };
  for (const std::string& argument : arguments)
  {
    argv.push_back(const_cast<char*>(argument.c_str()));
  }
  argv.push_back(nullptr);
  const pid_t parent = ::getpid();
  const pid_t process = ::fork();
  if (process == 0)
  {
    // The process must not outlive its parent, however the parent ends.
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    const int nothing = ::open("/dev/null", O_RDWR);
    ::dup2(nothing, STDIN_FILENO);
    ::dup2(nothing, STDOUT_FILENO);
    ::dup2(ends[1], STDERR_FILENO);
    if (::getppid() == parent)
    {
      ::execv(program.c_str(), argv.data());
    }
    ::_exit(127);
  }
  Error error = failed();
  ::close(ends[1]);
  if (process < 0)
  {
    ::close(ends[0]);
    return error;
  }
  return ChildProgram(process, ends[0]);
}

ChildProgram::ChildProgram(int process, int messages)
  : Process(process)
  , Messages(messages)
{
}

ChildProgram::ChildProgram(ChildProgram&& other) noexcept
  : Process(std::exchange(other.Process, -1))
  , Messages(std::exchange(other.Messages, -1))
{
}

ChildProgram::~ChildProgram()
{
  if (this->Messages >= 0)
  {
    ::close(this->Messages);
  }
  if (this->Process >= 0)
  {
    this->Stop();
  }
}

bool ChildProgram::Read(std::string& messages)
{
  pollfd waiting{ this->Messages, POLLIN, 0 };
  if (::poll(&waiting, 1, childPollMilliseconds) <= 0)
  {
    return true;
  }
  std::array<char, 4096> bytes;
  const ssize_t got = ::read(this->Messages, bytes.data(), bytes.size());
  if (got > 0)
  {
    messages.append(bytes.data(), static_cast<std::size_t>(got));
  }
  return got > 0 || (got < 0 && errno == EINTR);
}

int ChildProgram::Wait()
{
  int status = 0;
  while (::waitpid(this->Process, &status, 0) < 0 && errno == EINTR)
  {
  }
  this->Process = -1;
  return status;
}

int ChildProgram::Stop()
{
  ::kill(this->Process, SIGTERM);
  const auto last = std::chrono::steady_clock::now() + patienceWithChild;
  int status = 0;
  while (::waitpid(this->Process, &status, WNOHANG) == 0)
  {
    if (std::chrono::steady_clock::now() > last)
    {
      ::kill(this->Process, SIGKILL);
      return this->Wait();
    }
    std::this_thread::sleep_for(5ms);
  }
  this->Process = -1;
  return status;
}

}
