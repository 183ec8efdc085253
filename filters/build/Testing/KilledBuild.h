// SPDX-License-Identifier: BSD-3-Clause
// Builds that are killed before they finish, for the tests of builds out of core.
#pragma once

#include "filters/build/ExternalBuilder.h"
#include "filters/core/Execution.h"

#include <gtest/gtest.h>

#include <atomic>
#include <csignal>
#include <cstddef>
#include <string_view>

#include <sys/wait.h>
#include <unistd.h>

namespace kdstream
{

// Runs a build in a process of its own, which is killed before the k-th of its steps (file
// operations and progress reports). build(execution) -> Result must use this probe. Returns whether
// it was killed.
template <class Build>
bool BuildAndKillAt(std::size_t k, ExternalBuildProbe& probe, const Build& build)
{
  const pid_t child = ::fork();
  if (child == 0)
  {
    std::atomic<std::size_t> steps{ 0 };
    const auto step = [&]()
    {
      if (steps++ == k)
      {
        ::kill(::getpid(), SIGKILL);
      }
    };
    probe.hook = [&](FileOperation) { step(); };
    Execution execution;
    execution.progress = [&](std::string_view, double)
    {
      step();
      return true;
    };
    ::_exit(build(execution) ? 0 : 1);
  }
  int state = 0;
  ::waitpid(child, &state, 0);
  EXPECT_TRUE(WIFSIGNALED(state) ? WTERMSIG(state) == SIGKILL : WEXITSTATUS(state) == 0);
  return WIFSIGNALED(state);
}

}
