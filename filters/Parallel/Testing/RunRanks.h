// SPDX-License-Identifier: BSD-3-Clause
// Runs kdstream-build-mpi on the ranks of a job, for tests.
#pragma once

#include "Testing/EndToEnd/Process.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <string>
#include <vector>

namespace kdstream::fixtures
{

inline const std::string buildMpi = std::string(KDSTREAM_PROGRAMS) + "/kdstream-build-mpi";

// Sets up how ranks run in all tests: more ranks than cores, as root, and with a time limit.
inline void SetUpRanks()
{
  ::setenv("OMPI_ALLOW_RUN_AS_ROOT", "1", 1);
  ::setenv("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1", 1);
  ::setenv("OMPI_MCA_rmaps_base_oversubscribe", "1", 1);
  ::setenv("OMPI_MCA_mpi_yield_when_idle", "1", 1);
  ::setenv("OMPI_MCA_hwloc_base_binding_policy", "none", 1);
  // The same for Open MPI 5, whose launcher is PRRTE.
  ::setenv("PRTE_MCA_rmaps_default_mapping_policy", ":oversubscribe", 1);
  ::setenv("PRTE_MCA_hwloc_default_binding_policy", "none", 1);
  // All ranks are on this host. Over its other networks Open MPI 5 may find no route from the host
  // to itself, which each rank reports for each other rank.
  ::setenv("OMPI_MCA_btl_tcp_if_include", "127.0.0.0/8", 1);
  // Bytes of the file through which a rank sends to the others: within the file size limit of a
  // test. Open MPI 5 makes 16 MiB otherwise; 4 MiB is what Open MPI 4 makes.
  ::setenv("OMPI_MCA_btl_sm_segment_size", "4194304", 1);
  // After a rank has ended with an exit code, Open MPI waits this number of seconds before it kills
  // the others. All have cleaned up by then.
  ::setenv("OMPI_MCA_odls_base_sigkill_timeout", "0", 1);
  // Seconds; a job that hangs fails its test.
  ::setenv("MPIEXEC_TIMEOUT", "300", 1);
}

// The arguments of mpirun: `-np RANKS …`.
inline std::vector<std::string> Ranks(unsigned ranks, const std::vector<std::string>& command)
{
  SetUpRanks();
  std::vector<std::string> all{ KDSTREAM_NUMBER_FLAG, std::to_string(ranks) };
  all.insert(all.end(), command.begin(), command.end());
  return all;
}

// Runs `mpirun -np RANKS kdstream-build-mpi …` in the folder.
inline Outcome RunRanks(
  const TemporaryFolder& folder, unsigned ranks, const std::vector<std::string>& arguments)
{
  std::vector<std::string> command{ buildMpi };
  command.insert(command.end(), arguments.begin(), arguments.end());
  return RunProgram(folder, KDSTREAM_MPIRUN, Ranks(ranks, command));
}

// The files in the folder, except those that are given.
inline std::vector<std::string> Others(
  const TemporaryFolder& folder, const std::vector<std::string>& known)
{
  std::vector<std::string> others;
  for (const auto& entry : std::filesystem::directory_iterator(folder.Path))
  {
    const std::string name = entry.path().filename().string();
    if (std::find(known.begin(), known.end(), name) == known.end())
    {
      others.push_back(name);
    }
  }
  return others;
}

inline void ExpectOneMessage(const Outcome& outcome, const std::string& said, int exitCode = 1)
{
  EXPECT_EQ(outcome.exitCode, exitCode) << outcome.err;
  const std::string prefix = "kdstream-build-mpi: error: ";
  const std::size_t first = outcome.err.find(prefix);
  ASSERT_NE(first, std::string::npos) << outcome.err;
  EXPECT_EQ(outcome.err.find(prefix, first + 1), std::string::npos) << outcome.err;
  EXPECT_NE(outcome.err.find(said), std::string::npos) << outcome.err;
}

// Starts a program in the folder, with its output in the file .said there. Returns its process.
inline pid_t Start(
  const TemporaryFolder& folder, const char* program, std::vector<std::string> arguments)
{
  arguments.insert(arguments.begin(), program);
  std::vector<char*> argv;
  for (std::string& argument : arguments)
  {
    argv.push_back(argument.data());
  }
  argv.push_back(nullptr);
  const std::string out = (folder / ".said").string();
  const pid_t child = ::fork();
  if (child == 0)
  {
    if (::chdir(folder.Path.c_str()) == 0 && std::freopen(out.c_str(), "w", stdout) != nullptr &&
        ::dup2(STDOUT_FILENO, STDERR_FILENO) >= 0)
    {
      ::execv(program, argv.data());
    }
    ::_exit(127);
  }
  return child;
}

// If `store` is false: whether a rank has begun to read, which shows as a folder with a file. If
// true: whether the first rank has begun to write the store, under a temporary name.
inline bool HasBegun(const TemporaryFolder& folder, bool store)
{
  std::error_code gone; // files may be removed during the loop
  for (const auto& entry : std::filesystem::directory_iterator(folder.Path, gone))
  {
    const bool unfinished = entry.path().extension() == ".unfinished";
    if (store ? unfinished
              : entry.is_directory(gone) && !std::filesystem::is_empty(entry.path(), gone))
    {
      return true;
    }
  }
  return false;
}

// The ranks of a job: child processes of mpirun.
inline std::vector<pid_t> ChildrenOf(pid_t parent)
{
  std::ifstream children(
    "/proc/" + std::to_string(parent) + "/task/" + std::to_string(parent) + "/children");
  std::vector<pid_t> all;
  for (pid_t child = 0; children >> child;)
  {
    all.push_back(child);
  }
  return all;
}

}
