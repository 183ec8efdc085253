// SPDX-License-Identifier: BSD-3-Clause
// The options in --help, in doc/cli.md and in the manual are the same and take the same values, for
// every program that was built.
#include "Testing/EndToEnd/Process.h"

#include <gtest/gtest.h>

#include <array>
#include <cctype>
#include <map>
#include <set>
#include <sstream>

namespace
{

using namespace kdstream::fixtures;

using Options = std::set<std::string>;

// The options "--like-this" in a text, except those that every program has.
Options OptionsIn(const std::string& text)
{
  Options options;
  for (std::size_t at = text.find("--"); at != std::string::npos; at = text.find("--", at))
  {
    std::size_t end = at + 2;
    while (end < text.size() &&
           (std::islower(static_cast<unsigned char>(text[end])) != 0 || text[end] == '-'))
    {
      ++end;
    }
    if (end > at + 2 && text[at + 2] != '-')
    {
      options.insert(text.substr(at, end - at));
    }
    at = end;
  }
  options.erase("--help");
  options.erase("--version");
  return options;
}

// The part of the document below "## NAME", up to the next heading of that kind.
std::string SectionOf(const std::string& document, const std::string& name)
{
  const std::string heading = "\n## " + name + "\n";
  const std::size_t begin = document.find(heading);
  if (begin == std::string::npos)
  {
    ADD_FAILURE() << "doc/cli.md has no section " << name;
    return {};
  }
  const std::size_t end = document.find("\n## ", begin + heading.size());
  return document.substr(begin, end - begin);
}

// The options that a section's tables list: those in the first column.
Options ListedOptions(const std::string& section)
{
  Options options;
  std::istringstream lines(section);
  for (std::string line; std::getline(lines, line);)
  {
    if (line.starts_with("| "))
    {
      // Text after a bar inside `code` still belongs to the first column.
      options.merge(OptionsIn(line.substr(0, line.find(" | "))));
    }
  }
  return options;
}

using Values = std::map<std::string, std::string>;

// Adds the names in a text such as "-o, --output STORE.kds", each with the value that it takes; ""
// for a flag.
void AddValues(const std::string& text, Values& values)
{
  std::vector<std::string> names;
  std::string value;
  std::istringstream words(text);
  for (std::string word; words >> word;)
  {
    if (word.back() == ',')
    {
      word.pop_back();
    }
    (word[0] == '-' ? names.emplace_back() : value) = word;
  }
  for (const std::string& name : names)
  {
    values[name] = value;
  }
}

// The values that the options in a help text take, from its lines "  --NAME VALUE    description".
Values OfferedValues(const std::string& help)
{
  Values values;
  std::istringstream lines(help);
  for (std::string line; std::getline(lines, line);)
  {
    if (line.starts_with("  -"))
    {
      AddValues(line.substr(2, line.find("  ", 2) - 2), values);
    }
  }
  return values;
}

// The values that the options in a section's tables take, from `--NAME VALUE` in the first column.
Values ListedValues(const std::string& section)
{
  Values values;
  std::istringstream lines(section);
  for (std::string line; std::getline(lines, line);)
  {
    if (!line.starts_with("| `-"))
    {
      continue;
    }
    std::erase(line, '\\'); // written in front of bars
    const std::string names = line.substr(2, line.find(" | ") - 2);
    for (std::size_t begin = names.find("`-"); begin != std::string::npos;)
    {
      const std::size_t end = names.find('`', begin + 1);
      AddValues(names.substr(begin + 1, end - begin - 1), values);
      begin = names.find("`-", end + 1);
    }
  }
  values.erase("-o"); // is in the table with --output, which has the value
  return values;
}

// The commands that a section describes: its headings "### NAME" with a single word.
std::vector<std::string> CommandsOf(const std::string& section)
{
  std::vector<std::string> commands;
  std::istringstream lines(section);
  for (std::string line; std::getline(lines, line);)
  {
    const std::string name = line.starts_with("### ") ? line.substr(4) : "";
    if (!name.empty() && name.find(' ') == std::string::npos &&
        std::islower(static_cast<unsigned char>(name[0])) != 0)
    {
      commands.push_back(name);
    }
  }
  return commands;
}

constexpr std::array programNames{ "build", "store", "serve", "view", "convert", "generate" };

TEST(CommandLine, HelpAndDocumentListTheSameOptions)
{
  const TemporaryFolder folder;
  const std::string document = ReadWhole(KDSTREAM_CLI_DOCUMENT);
  unsigned programs = 0;
  for (const char* const name : programNames)
  {
    SCOPED_TRACE(name);
    const std::string program = "kdstream-" + std::string(name);
    if (!std::filesystem::exists(std::filesystem::path(KDSTREAM_PROGRAMS) / program))
    {
      continue; // not in this build
    }
    ++programs;
    const std::string section = SectionOf(document, program);
    std::string helpTexts = RunTool(folder, name, { "--help" }).out;
    Options offered = OptionsIn(helpTexts);
    for (const std::string& command : CommandsOf(section))
    {
      const Outcome help = RunTool(folder, name, { command, "--help" });
      EXPECT_NE(help.out.find(program + " " + command), std::string::npos)
        << "there is no command " << command;
      offered.merge(OptionsIn(help.out));
      helpTexts += help.out;
    }
    EXPECT_FALSE(offered.empty());
    const Options reported = OptionsIn(section);
    for (const std::string& option : offered)
    {
      EXPECT_EQ(reported.count(option), 1U) << option << " is not in doc/cli.md";
    }
    for (const std::string& option : ListedOptions(section))
    {
      EXPECT_EQ(offered.count(option), 1U) << option << " is not in --help";
    }
    const Values helpValues = OfferedValues(helpTexts);
    for (const auto& [option, value] : ListedValues(section))
    {
      ASSERT_EQ(helpValues.count(option), 1U) << option;
      EXPECT_EQ(value, helpValues.at(option)) << option << " in doc/cli.md and in --help";
    }
  }
  EXPECT_GE(programs, 2U) << "kdstream-build and kdstream-store are always there";
}

// The options in a text in roff, and the values that they take.
Values ManualValues(std::string page)
{
  Values values;
  std::erase(page, '\\');
  std::istringstream lines(page);
  for (std::string line; std::getline(lines, line);)
  {
    if (line.starts_with(".B -"))
    {
      AddValues(line.substr(3), values);
    }
  }
  return values;
}

TEST(CommandLine, TheManualHasTheOptionsOfHelp)
{
  const TemporaryFolder folder;
  const std::string document = ReadWhole(KDSTREAM_CLI_DOCUMENT);
  for (const char* const name : programNames)
  {
    SCOPED_TRACE(name);
    const std::string program = "kdstream-" + std::string(name);
    const auto page = ReadWhole(std::filesystem::path(KDSTREAM_MANUAL) / (program + ".1"));
    if (page.empty() ||
        !std::filesystem::exists(std::filesystem::path(KDSTREAM_PROGRAMS) / program))
    {
      continue; // not in this build
    }
    std::string helpTexts = RunTool(folder, name, { "--help" }).out;
    for (const std::string& command : CommandsOf(SectionOf(document, program)))
    {
      helpTexts += RunTool(folder, name, { command, "--help" }).out;
    }
    EXPECT_EQ(ManualValues(page), OfferedValues(helpTexts));
    EXPECT_TRUE(
      page.find("\n.SH NAME\n" + std::string("kdstream\\-") + name + " \\- ") != std::string::npos);
  }
}

}
