// SPDX-License-Identifier: BSD-3-Clause
// The operations that are repeated while system calls fail. Each is a program in a folder.
#pragma once

#include "Testing/Faults/FaultyProgram.h"

#include <filesystem>
#include <functional>
#include <set>
#include <string>
#include <vector>

namespace kdstream::fixtures
{

inline const std::string faultLibrary = KDSTREAM_FAULTS;

// A program in a folder of files.
struct Operation
{
  std::string name, program;
  std::vector<std::string> arguments;
  FileTree before;
  // Names of files that may differ from one successful run to another.
  std::set<std::string> others = {};
  // Whether the program itself tries again after a failure.
  bool recovers = false;
  // Whether the program may run again after it has succeeded; else it refuses the existing output.
  bool repeats = true;
  // Checks how a run ended, in addition to the rules for all operations. Returns what is wrong, or
  // "".
  std::function<std::string(const FaultyProgram::Outcome&, const std::filesystem::path&)> check =
    [](const auto&, const auto&) { return std::string(); };
};

inline constexpr const char* operationNames[] = { "build", "rebuild", "external", "edit", "verify",
  "extract", "notes", "export", "exportagain", "exportanother", "tiles", "glb", "quotas" };

const Operation& OperationOf(const std::string& name);
std::string ProgramPath(const std::string& program);
// The folder after the work, without faults.
FileTree TreeAfter(const Operation& operation);

}
