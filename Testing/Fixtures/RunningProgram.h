// SPDX-License-Identifier: BSD-3-Clause
// Runs a program in parallel to a test. Its output can be read while it runs, and the program ends
// with the object.
#pragma once

#include <gtest/gtest.h>

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace kdstream::fixtures
{

class RunningProgram
{
public:
  // descriptors: how many the program may have; without a number, as many as this process.
  RunningProgram(const std::string& program, std::vector<std::string> arguments,
    std::optional<rlimit> descriptors = {})
  {
    std::array<int, 2> out{}, error{};
    EXPECT_EQ(::pipe(out.data()), 0);
    EXPECT_EQ(::pipe(error.data()), 0);
    arguments.insert(arguments.begin(), program);
    std::vector<char*> list;
    for (auto& argument : arguments)
    {
      list.push_back(argument.data());
    }
    list.push_back(nullptr);
    this->Id = ::fork();
    if (this->Id == 0)
    {
      ::dup2(out[1], STDOUT_FILENO);
      ::dup2(error[1], STDERR_FILENO);
      for (const int end : { out[0], out[1], error[0], error[1] })
      {
        ::close(end);
      }
      if (descriptors)
      {
        ::setrlimit(RLIMIT_NOFILE, &*descriptors);
      }
      ::execv(program.c_str(), list.data());
      ::_exit(127);
    }
    ::close(out[1]);
    ::close(error[1]);
    this->Out = out[0];
    this->Err = error[0];
  }
  ~RunningProgram()
  {
    if (this->Id > 0)
    {
      this->Signal(SIGKILL);
      this->Wait();
    }
    ::close(this->Out);
    ::close(this->Err);
  }
  RunningProgram(const RunningProgram&) = delete;
  RunningProgram& operator=(const RunningProgram&) = delete;

  // Does nothing if the program has already been waited for.
  void Signal(int signal) const
  {
    if (this->Id > 0)
    {
      ::kill(this->Id, signal);
    }
  }
  // Waits for the program. Returns its exit code, or minus the signal that ended it.
  int Wait()
  {
    int status = 0;
    ::waitpid(this->Id, &status, 0);
    this->Id = -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  }
  // The next lines of its output; "" if it has ended.
  std::string OutLine() const { return ReadLine(this->Out); }
  std::string AnyErrorLine() const { return ReadLine(this->Err); }

private:
  static std::string ReadLine(int file)
  {
    std::string line;
    for (char c = 0; ::read(file, &c, 1) == 1 && c != '\n';)
    {
      line += c;
    }
    return line;
  }

  pid_t Id = -1;
  int Out = -1, Err = -1;
};

// kdstream-serve with a folder, on a free port.
class FolderServer
{
public:
  // programs: the folder of kdstream-serve.
  FolderServer(const std::string& programs, const std::filesystem::path& folder)
    : Program(programs + "/kdstream-serve", { folder.string(), "--port", "0" })
  {
    const std::string ready = "listening on ", line = this->Program.OutLine();
    EXPECT_TRUE(line.starts_with(ready)) << line << this->Program.AnyErrorLine();
    this->Url = line.substr(std::min(ready.size(), line.size()));
  }

  // Sends SIGTERM, and returns the exit code.
  int Stop()
  {
    this->Program.Signal(SIGTERM);
    return this->Program.Wait();
  }

  std::string Url;

private:
  RunningProgram Program;
};

}
