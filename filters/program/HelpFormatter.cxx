// SPDX-License-Identifier: BSD-3-Clause
#include "filters/program/HelpFormatter.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <memory>
#include <sstream>
#include <vector>

namespace kdstream
{
namespace
{

constexpr std::size_t mostColumns = 100, leastColumns = 40;
constexpr std::size_t secondColumn = 30; // where the descriptions of options begin
const std::string otherGroup = "Help";   // the group of --help and --version, printed last

std::size_t IndentOf(const std::string& line)
{
  return std::min(line.find_first_not_of(' '), line.size());
}

// The type of an option's value: CLI11 writes "TEXT:{on,off}", "UINT:UINT in [1 - 1024]", "FILE".
struct ValueWords
{
  std::string name;  // "on|off", "N", "FILE"
  std::string range; // "1 to 1024"; empty if none is known
};

ValueWords WordsOf(const CLI::Option& option)
{
  const std::string type = option.get_type_name();
  ValueWords words{ type.substr(0, type.find(':')), {} };
  if (words.name == "UINT" || words.name == "INT")
  {
    words.name = "N";
  }
  else if (words.name == "FLOAT")
  {
    words.name = "X";
  }
  if (const std::size_t begin = type.find(":{"), end = type.find('}', begin);
      begin != std::string::npos && end != std::string::npos)
  {
    words.name = type.substr(begin + 2, end - begin - 2);
    std::replace(words.name.begin(), words.name.end(), ',', '|');
  }
  const std::size_t begin = type.find(" in ["), end = type.find(']', begin);
  const std::size_t middle = type.find(" - ", begin);
  if (begin != std::string::npos && middle < end && end != std::string::npos)
  {
    words.range = type.substr(begin + 5, middle - begin - 5) + " to " +
                  type.substr(middle + 3, end - middle - 3);
  }
  return words;
}

// Restrictions of an option: "(not with --partitions)", "[1 to 1024, default 2000]".
std::string Conditions(const CLI::Option& option, const ValueWords& words)
{
  std::string inBrackets = words.range;
  if (!option.get_default_str().empty())
  {
    inBrackets += (inBrackets.empty() ? "default " : ", default ") + option.get_default_str();
  }
  std::string text = inBrackets.empty() ? "" : " [" + inBrackets + "]";
  const auto list = [&text](const char* what, const std::set<CLI::Option*>& options)
  {
    std::string separator = what;
    for (const CLI::Option* const other : options)
    {
      text += separator + other->get_name();
      separator = ", ";
    }
    text += options.empty() ? "" : ")";
  };
  list(" (needs ", option.get_needs());
  list(" (not with ", option.get_excludes());
  return text;
}

std::vector<const CLI::App*> CommandsOf(const CLI::App& app)
{
  return app.get_subcommands([](const CLI::App* command) { return !command->get_name().empty(); });
}

// The option groups, which CLI11 stores as commands without a name.
std::vector<const CLI::App*> ChoicesOf(const CLI::App& app)
{
  return app.get_subcommands([](const CLI::App* command) { return command->get_name().empty(); });
}

}

std::string WrapText(const std::string& text, std::size_t width, std::size_t indent)
{
  std::string wrapped;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);)
  {
    if (line.size() <= width) // keeps its columns
    {
      wrapped += line + "\n";
      continue;
    }
    const std::size_t own = IndentOf(line);
    const std::string further(own == 0 ? 0 : own + indent, ' ');
    std::istringstream words(line);
    std::string current(own, ' ');
    bool empty = true;
    for (std::string word; words >> word; empty = false)
    {
      if (!empty && current.size() + 1 + word.size() > width)
      {
        wrapped += current + "\n";
        current = further;
        empty = true;
      }
      current += (empty ? "" : " ") + word;
    }
    wrapped += current + "\n";
  }
  if (!wrapped.empty())
  {
    wrapped.pop_back();
  }
  return wrapped;
}

HelpFormatter::HelpFormatter(std::size_t width)
  : Width(width)
{
}

std::string HelpFormatter::Row(const std::string& name, const std::string& text) const
{
  std::string row = "  " + name;
  const bool beside = row.size() + 2 <= secondColumn;
  row +=
    beside ? std::string(secondColumn - row.size(), ' ') : "\n" + std::string(secondColumn, ' ');
  std::istringstream lines(WrapText(text, this->Width - secondColumn));
  std::string separator;
  for (std::string line; std::getline(lines, line);)
  {
    row += separator + line;
    separator = "\n" + std::string(secondColumn, ' ');
  }
  return row + "\n";
}

std::string HelpFormatter::make_description(const CLI::App* app) const
{
  std::string text = app->get_description();
  if (app->get_parent() != nullptr &&
      !text.empty()) // the list of commands shows it without a full stop
  {
    text[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(text[0])));
    text += ".";
  }
  return WrapText(text, this->Width) + "\n\n";
}

std::string HelpFormatter::make_usage(const CLI::App* app, std::string name) const
{
  std::string usage = "Usage: " + name;
  if (!CommandsOf(*app).empty() && app->get_require_subcommand_min() > 0)
  {
    usage += " COMMAND";
  }
  for (const CLI::Option* const option :
    app->get_options([](const CLI::Option* o) { return o->get_positional(); }))
  {
    usage += " " + this->make_option_usage(option);
  }
  for (const CLI::App* const choice : ChoicesOf(*app))
  {
    usage += " " + choice->get_group();
  }
  for (const CLI::Option* const option :
    app->get_options([](const CLI::Option* o) { return o->nonpositional() && o->get_required(); }))
  {
    const std::string names = option->get_name(false, true);
    usage += " " + names.substr(0, names.find(',')) + " " + WordsOf(*option).name;
  }
  return WrapText(usage + " [options]", this->Width) + "\n";
}

std::string HelpFormatter::make_positionals(const CLI::App* app) const
{
  std::string text;
  for (const CLI::Option* const option :
    app->get_options([](const CLI::Option* o) { return o->get_positional(); }))
  {
    text += this->make_option(option, true);
  }
  return text.empty() ? text : "\n" + text;
}

std::string HelpFormatter::make_help(
  const CLI::App* app, std::string name, CLI::AppFormatMode /*mode*/) const
{
  return this->make_description(app) + this->make_usage(app, name) + this->make_positionals(app) +
         this->MakeCommands(app) + this->MakeChoices(app) + this->MakeGroups(app) + "\n" +
         this->make_footer(app);
}

std::string HelpFormatter::MakeCommands(const CLI::App* app) const
{
  std::string text;
  for (const CLI::App* const command : CommandsOf(*app))
  {
    text += this->make_subcommand(command);
  }
  return text.empty() ? text : "\nCommands:\n" + text;
}

std::string HelpFormatter::MakeChoices(const CLI::App* app) const
{
  std::string text;
  for (const CLI::App* const choice : ChoicesOf(*app))
  {
    text += "\n" + choice->get_group() + ", " + choice->get_description() + ":\n";
    for (const CLI::Option* const option : choice->get_options([&](const CLI::Option* o)
           { return o != choice->get_help_ptr() && !o->get_group().empty(); }))
    {
      text += this->make_option(option, false);
    }
  }
  return text;
}

std::string HelpFormatter::MakeGroups(const CLI::App* app) const
{
  std::vector<std::string> groups = app->get_groups();
  std::stable_partition(
    groups.begin(), groups.end(), [](const std::string& group) { return group != otherGroup; });
  std::string text;
  for (const std::string& group : groups)
  {
    std::string options;
    for (const CLI::Option* const option : app->get_options(
           [&](const CLI::Option* o) { return o->get_group() == group && o->nonpositional(); }))
    {
      options += this->make_option(option, false);
    }
    if (!group.empty() && !options.empty())
    {
      text.append("\n").append(group).append(":\n").append(options);
    }
  }
  return text;
}

std::string HelpFormatter::make_subcommand(const CLI::App* command) const
{
  return this->Row(command->get_name(), command->get_description());
}

std::string HelpFormatter::make_footer(const CLI::App* app) const
{
  return app->get_footer().empty() ? "" : WrapText(app->get_footer(), this->Width, 4) + "\n";
}

std::string HelpFormatter::make_option(const CLI::Option* option, bool isPositional) const
{
  std::string name = option->get_name(isPositional, !isPositional);
  if (const std::size_t comma = name.find(','); comma != std::string::npos)
  {
    name.insert(comma + 1, " ");
  }
  const bool takesValue = option->get_type_size() != 0;
  const ValueWords words = takesValue ? WordsOf(*option) : ValueWords{};
  name += isPositional || words.name.empty() ? "" : " " + words.name;
  return this->Row(name, option->get_description() + Conditions(*option, words));
}

std::size_t HelpWidth()
{
  winsize size{};
  const bool known = ::ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0;
  return known ? std::clamp<std::size_t>(size.ws_col, leastColumns, mostColumns) : mostColumns;
}

void SetUpHelp(CLI::App& app, const std::string& version)
{
  app.set_version_flag("--version", app.get_name() + " " + version, "name and version")
    ->group(otherGroup);
  const auto formatter = std::make_shared<HelpFormatter>(HelpWidth());
  std::vector<CLI::App*> all{ &app };
  for (std::size_t i = 0; i < all.size(); ++i)
  {
    all[i]->formatter(formatter);
    if (CLI::Option* const help = all[i]->get_help_ptr())
    {
      help->group(otherGroup);
      help->description("this text");
    }
    const std::vector<CLI::App*> commands = all[i]->get_subcommands([](CLI::App*) { return true; });
    all.insert(all.end(), commands.begin(), commands.end());
  }
}

}
