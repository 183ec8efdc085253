// SPDX-License-Identifier: BSD-3-Clause
// Runs the programs as a user does, with arguments. Returns exit code, stdout and stderr.
#pragma once

#include "Testing/Fixtures/TemporaryFolder.h"

#include <array>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#include <vector>

namespace kdstream::fixtures
{

struct Outcome
{
  int exitCode = -1; // 128 + the signal, if a signal ended it
  std::string out, err;
  std::uint64_t peakBytes = 0; // the peak of resident memory, as the system counts it
};

// Runs a program with these arguments in `folder`.
inline Outcome RunProgram(const TemporaryFolder& folder, const std::string& program,
  const std::vector<std::string>& arguments)
{
  const std::filesystem::path out = folder / ".stdout", err = folder / ".stderr";
  const pid_t child = ::fork();
  if (child == 0)
  {
    std::vector<char*> argv{ const_cast<char*>(program.c_str()) };
    for (const std::string& argument : arguments)
    {
      argv.push_back(const_cast<char*>(argument.c_str()));
    }
    argv.push_back(nullptr);
    if (::chdir(folder.Path.c_str()) == 0 && std::freopen(out.c_str(), "w", stdout) &&
        std::freopen(err.c_str(), "w", stderr))
    {
      ::execv(program.c_str(), argv.data());
    }
    ::_exit(127);
  }
  int status = 0;
  rusage usage{};
  ::wait4(child, &status, 0, &usage);
  Outcome outcome;
  outcome.peakBytes = static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;
  outcome.exitCode = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  outcome.out = ReadWhole(out);
  outcome.err = ReadWhole(err);
  std::filesystem::remove(out);
  std::filesystem::remove(err);
  return outcome;
}

// Runs kdstream-NAME from the build's bin folder.
inline Outcome RunTool(
  const TemporaryFolder& folder, const std::string& name, const std::vector<std::string>& arguments)
{
  return RunProgram(folder, std::string(KDSTREAM_PROGRAMS) + "/kdstream-" + name, arguments);
}

}
