// SPDX-License-Identifier: BSD-3-Clause
// What is wrong with a command line, in the words of a person.
#pragma once

#include <CLI/CLI.hpp>

#include <string>
#include <vector>

namespace kdstream
{

// What to tell of an error that CLI11 has found in the command line of `app`: which option or word
// is meant, what would be right, and the nearest name of one that was misspelt.
std::string UsageMessage(const CLI::App& app, const CLI::ParseError& error);

// The one of `names` that `word` is a slip of: fewer letters differ than a third of them, and at
// least one may; empty if there is none.
std::string NearestName(const std::string& word, const std::vector<std::string>& names);

}
