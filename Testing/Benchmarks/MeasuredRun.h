// SPDX-License-Identifier: BSD-3-Clause
// Runs a program to its end and measures it from outside, for benchmarks that compare whole builds.
#pragma once

#include <nlohmann/json.hpp>

#include <filesystem>
#include <string>
#include <vector>

namespace kdstream::benchmarks
{

using Json = nlohmann::json;

struct Cost
{
  double seconds = 0;   // elapsed time
  double processor = 0; // user and system time of all threads
  double mebibytes = 0; // peak resident memory
  Json steps;           // seconds of each step, if the caller knows them
};

// command: the program's path and its arguments. Its standard output goes into the file `output`.
// If it fails, the benchmark ends with a message.
Cost RunMeasured(const std::vector<std::string>& command, const std::filesystem::path& output);

}
