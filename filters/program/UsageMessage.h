// SPDX-License-Identifier: BSD-3-Clause
// What is wrong with a command line: CLI11's message, and what was meant by a misspelt name.
#pragma once

#include <CLI/CLI.hpp>

#include <optional>
#include <string>
#include <vector>

namespace kdstream
{

// The message of an error that CLI11 has found in the command line of `app`. Where a command or an
// option is misspelt or stands in the wrong place, which causes other errors, that is reported
// instead, with the nearest name.
std::string UsageMessage(const CLI::App& app, const CLI::ParseError& error);

// Of a command line that asks for help, what to tell instead: that there is no such command. None
// where none is named, or one that there is.
std::optional<std::string> UnknownCommand(const CLI::App& app);

// The names that `word` may stand for: all that begin with it, if it has two letters or more; else
// the nearest name, if at most a third of the word's letters differ (one always may). Empty if there
// is none.
std::vector<std::string> NamesMeant(const std::string& word, const std::vector<std::string>& names);

// "; did you mean intensity?"; empty where none of them may be meant.
std::string DidYouMean(const std::string& word, const std::vector<std::string>& names);

}
