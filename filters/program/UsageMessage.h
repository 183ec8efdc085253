// SPDX-License-Identifier: BSD-3-Clause
// Explains what is wrong with a command line: CLI11's message, and suggestions for misspelt names.
#pragma once

#include <CLI/CLI.hpp>

#include <optional>
#include <string>
#include <vector>

namespace kdstream
{

// The message for an error that CLI11 has found in the command line of `app`. If a command or an
// option is misspelt or misplaced, which causes other errors, that is reported instead, with the
// most similar name.
std::string UsageMessage(const CLI::App& app, const CLI::ParseError& error);

// For a command line that asks for help: the message that the given command does not exist. Nothing
// if no command is given, or if it exists.
std::optional<std::string> UnknownCommand(const CLI::App& app);

// The names that `word` may stand for: all that begin with it, if it has two letters or more;
// otherwise the most similar name, if at most a third of the word's letters differ (one difference
// is always allowed). Empty if there is none.
std::vector<std::string> NamesMeant(const std::string& word, const std::vector<std::string>& names);

// "; did you mean intensity?"; empty if none of the names is similar.
std::string DidYouMean(const std::string& word, const std::vector<std::string>& names);

}
