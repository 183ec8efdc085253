// SPDX-License-Identifier: BSD-3-Clause
// Runs a program repeatedly in a folder while its system calls fail.
#pragma once

#include "Testing/Faults/Faults.h"
#include "Testing/Fixtures/TemporaryFolder.h"

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace kdstream::fixtures
{

// The files below a folder: content by name relative to the folder. Names of folders end with '/'.
using FileTree = std::map<std::string, std::string>;

inline FileTree ReadTree(const std::filesystem::path& folder)
{
  FileTree tree;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
  {
    const auto name = entry.path().lexically_relative(folder).string();
    if (entry.is_directory())
    {
      tree[name + "/"];
    }
    else
    {
      tree[name] = ReadWhole(entry.path());
    }
  }
  return tree;
}

// Makes the folder contain exactly these files. The folder itself stays the same one.
inline void WriteTree(const std::filesystem::path& folder, const FileTree& tree)
{
  std::filesystem::create_directories(folder);
  for (const auto& entry : std::filesystem::directory_iterator(folder))
  {
    std::filesystem::remove_all(entry.path());
  }
  for (const auto& [name, content] : tree)
  {
    if (name.ends_with('/'))
    {
      std::filesystem::create_directories(folder / name);
    }
    else
    {
      std::filesystem::create_directories((folder / name).parent_path());
      std::ofstream(folder / name, std::ios::binary) << content;
    }
  }
}

class FaultyProgram
{
public:
  struct Outcome
  {
    int exitCode = -1; // 128 + the signal, if a signal ended it
    std::string out, err;
  };

  // library: FaultShim.cxx. record: a file for the record of file operations, or "".
  FaultyProgram(const std::string& library, std::filesystem::path folder, std::string program,
    std::vector<std::string> arguments, const std::string& record = {})
  {
    const std::string shared = this->Own / "faults", out = this->Own / "out",
                      err = this->Own / "err";
    this->Shared = MapFaults(shared.c_str(), true);
    std::array<int, 2> ask{}, answer{};
    if (::pipe(ask.data()) != 0 || ::pipe(answer.data()) != 0)
    {
      std::abort();
    }
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
      ::close(ask[1]);
      ::close(answer[0]);
      const rlimit noCore{};
      ::setrlimit(RLIMIT_CORE, &noCore);
      constexpr int flags = O_CREAT | O_RDWR | O_APPEND;
      ::dup2(::open(out.c_str(), flags, 0600), STDOUT_FILENO);
      ::dup2(::open(err.c_str(), flags, 0600), STDERR_FILENO);
      const auto runs = std::to_string(ask[0]) + "," + std::to_string(answer[1]);
      ::setenv(runsVariable, runs.c_str(), 1);
      ::setenv(faultsVariable, shared.c_str(), 1);
      ::setenv("LD_PRELOAD", library.c_str(), 1);
      if (!record.empty())
      {
        ::setenv(recordVariable, record.c_str(), 1);
      }
      if (::chdir(folder.c_str()) == 0)
      {
        ::execv(program.c_str(), list.data());
      }
      ::_exit(127);
    }
    ::close(ask[0]);
    ::close(answer[1]);
    this->Ask = ask[1];
    this->Answer = answer[0];
  }
  ~FaultyProgram()
  {
    ::close(this->Ask); // which makes the program end
    ::close(this->Answer);
    ::waitpid(this->Id, nullptr, 0);
    ::munmap(this->Shared, sizeof(Faults));
  }
  FaultyProgram(const FaultyProgram&) = delete;
  FaultyProgram& operator=(const FaultyProgram&) = delete;

  // What fails in the next run. (A function named after its type would be an error for g++.)
  Faults& What() { return *this->Shared; }

  Outcome Run()
  {
    for (const char* const name : { "out", "err" })
    {
      (void)!::truncate((this->Own / name).c_str(), 0);
    }
    this->Shared->struck = 0;
    int status = -1;
    Outcome outcome;
    if (::write(this->Ask, "r", 1) == 1 &&
        ::read(this->Answer, &status, sizeof(status)) == sizeof(status))
    {
      outcome.exitCode = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    }
    outcome.out = ReadWhole(this->Own / "out");
    outcome.err = ReadWhole(this->Own / "err");
    return outcome;
  }

private:
  const TemporaryFolder Own;
  Faults* Shared = nullptr;
  pid_t Id = -1;
  int Ask = -1, Answer = -1;
};

}
