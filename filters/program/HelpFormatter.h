// SPDX-License-Identifier: BSD-3-Clause
// The text that --help prints: the same form for every program.
#pragma once

#include <CLI/CLI.hpp>

#include <cstddef>
#include <string>

namespace kdstream
{

// Breaks `text` into lines of at most `width` characters, between words. A line that fits stays
// unchanged. Words that do not fit go to the next line. The continuation of an indented line is
// indented `indent` characters further.
std::string WrapText(const std::string& text, std::size_t width, std::size_t indent = 0);

// The layout of --help: description; usage, with all required arguments; commands; options by
// groups in the order of their addition, groups with required options first, each option with its
// values and its default; the footer, with examples. Lines are at most as long as the terminal is
// wide, and at most 100 characters.
class HelpFormatter : public CLI::Formatter
{
public:
  explicit HelpFormatter(std::size_t width);

  std::string make_help(
    const CLI::App* app, std::string name, CLI::AppFormatMode mode) const override;
  std::string make_description(const CLI::App* app) const override;
  std::string make_usage(const CLI::App* app, std::string name) const override;
  std::string make_positionals(const CLI::App* app) const override;
  std::string make_subcommand(const CLI::App* command) const override;
  std::string make_footer(const CLI::App* app) const override;
  std::string make_option(const CLI::Option* option, bool isPositional) const override;

private:
  std::string MakeCommands(const CLI::App* app) const;
  // For CLI11's option groups: tells which of their options are required.
  std::string MakeChoices(const CLI::App* app) const;
  std::string MakeGroups(const CLI::App* app) const;
  // `name` in the first column, `text` wrapped in the second.
  std::string Row(const std::string& name, const std::string& text) const;

  std::size_t Width;
};

// The width in columns of the terminal on stdout, at most 100; 100 if it is not a terminal.
std::size_t HelpWidth();

// Sets up this help for a program and its commands, and --version, which prints the program's name.
void SetUpHelp(CLI::App& app, const std::string& version);

}
