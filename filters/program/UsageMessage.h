// SPDX-License-Identifier: BSD-3-Clause
// What is wrong with a command line: CLI11's message, and what was meant by a misspelt name.
#pragma once

#include <CLI/CLI.hpp>

#include <optional>
#include <string>
#include <vector>

namespace kdstream
{

// The message of an error that CLI11 has found in the command line of `app`. If a command or an
// option is misspelt or misplaced, which causes other errors, that is reported instead, with the
// nearest name.
std::string UsageMessage(const CLI::App& app, const CLI::ParseError& error);

// For a command line that asks for help: the message that the named command does not exist. Nothing
// if no command is named, or if it exists.
std::optional<std::string> UnknownCommand(const CLI::App& app);

// The names that `word` may stand for: all that begin with it, if it has two letters or more; else
// the nearest name, if at most a third of the word's letters differ (one difference is always
// allowed). Empty if there is none.
std::vector<std::string> NamesMeant(const std::string& word, const std::vector<std::string>& names);

// "; did you mean intensity?"; empty where none of them may be meant.
std::string DidYouMean(const std::string& word, const std::vector<std::string>& names);

}
