// SPDX-License-Identifier: BSD-3-Clause
// A program run to its end and measured from outside: what benchmarks of whole builds compare.
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
  double seconds = 0;   // of the clock
  double processor = 0; // user and system, all threads
  double mebibytes = 0; // peak resident
  Json steps;           // seconds each, where the caller knows them
};

// command: the program's path and its arguments. Its standard output goes into the file `output`.
// If it fails, the benchmark ends with a message.
Cost RunMeasured(const std::vector<std::string>& command, const std::filesystem::path& output);

}
