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

// Those of `names` that `word` may stand for: all that begin with it, from two letters on; else the
// nearest one of which it is a slip, where fewer letters differ than a third of them, and at least
// one may. None if there is no such name.
std::vector<std::string> NamesMeant(const std::string& word, const std::vector<std::string>& names);

}
