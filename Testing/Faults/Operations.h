// SPDX-License-Identifier: BSD-3-Clause
// The work that is done again and again while the system fails: each a program in a folder.
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
  // Names of files that need not be the same after each run that is well.
  std::set<std::string> others = {};
  // Whether it tries again by itself what has failed once.
  bool recovers = false;
  // Whether it may be run again once it is done; else it refuses what is there.
  bool repeats = true;
  // What is wrong with how it ended, beside the rules for all; "" if nothing.
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
