// SPDX-License-Identifier: BSD-3-Clause
#include "filters/program/UsageMessage.h"

#include <algorithm>
#include <iterator>
#include <numeric>
#include <regex>
#include <sstream>

namespace kdstream
{
namespace
{

// The number of letters that are inserted, omitted, replaced, or swapped with the next one.
std::size_t Slips(const std::string& a, const std::string& b)
{
  std::vector<std::size_t> before(b.size() + 1), last(b.size() + 1), current(b.size() + 1);
  std::iota(last.begin(), last.end(), std::size_t{ 0 });
  for (std::size_t i = 1; i <= a.size(); ++i)
  {
    current[0] = i;
    for (std::size_t k = 1; k <= b.size(); ++k)
    {
      current[k] =
        std::min({ last[k] + 1, current[k - 1] + 1, last[k - 1] + (a[i - 1] == b[k - 1] ? 0 : 1) });
      if (i > 1 && k > 1 && a[i - 1] == b[k - 2] && a[i - 2] == b[k - 1])
      {
        current[k] = std::min(current[k], before[k - 2] + 1);
      }
    }
    std::swap(before, last);
    std::swap(last, current);
  }
  return last[b.size()];
}

std::string Quoted(const std::string& text)
{
  return "\"" + text + "\"";
}

// A list in words: "a, b or c".
std::string AnyOf(const std::vector<std::string>& names)
{
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i)
  {
    text += (i == 0 ? "" : i + 1 == names.size() ? " or " : ", ") + names[i];
  }
  return text;
}

// The program, the commands that were given, and the option groups of each.
std::vector<const CLI::App*> Parsed(const CLI::App& app)
{
  std::vector<const CLI::App*> all{ &app };
  for (std::size_t i = 0; i < all.size(); ++i)
  {
    for (const CLI::App* const sub : all[i]->get_subcommands([](const CLI::App*) { return true; }))
    {
      if (sub->get_name().empty() || sub->parsed())
      {
        all.push_back(sub);
      }
    }
  }
  return all;
}

std::vector<std::string> OptionNames(const CLI::App& app)
{
  std::vector<std::string> names;
  for (const CLI::App* const part : Parsed(app))
  {
    for (const CLI::Option* const option : part->get_options({}))
    {
      for (const std::string& name : option->get_lnames())
      {
        names.push_back("--" + name);
      }
    }
  }
  return names;
}

std::vector<std::string> CommandNames(const CLI::App& app)
{
  std::vector<std::string> names;
  for (const CLI::App* const command :
    app.get_subcommands([](const CLI::App* sub) { return !sub->get_name().empty(); }))
  {
    names.push_back(command->get_name());
  }
  return names;
}

bool StartsWith(const std::string& text, const std::string& start)
{
  return text.rfind(start, 0) == 0;
}

bool Contains(const std::vector<std::string>& names, const std::string& name)
{
  return std::find(names.begin(), names.end(), name) != names.end();
}

// The option in a word: "--title" in "--title=x"; nothing if the word is not an option.
std::optional<std::string> OptionOf(const std::string& word)
{
  return word.size() > 1 && word[0] == '-' && word != "--"
           ? std::optional<std::string>(word.substr(0, word.find('=')))
           : std::nullopt;
}

// The command that was given, if any.
const CLI::App* GivenCommand(const CLI::App& app)
{
  for (const CLI::App* const command : app.get_subcommands())
  {
    if (!command->get_name().empty())
    {
      return command;
    }
  }
  return nullptr;
}

bool LacksCommand(const CLI::App& app)
{
  return app.get_require_subcommand_min() > 0 && !GivenCommand(app);
}

// The word that was probably meant as the command: the one most similar to a command's name;
// otherwise the first that is not an option. Nothing if there are only options.
std::optional<std::string> WordForCommand(const CLI::App& app)
{
  std::optional<std::string> first;
  for (const std::string& word : app.remaining(true))
  {
    if (OptionOf(word))
    {
      continue;
    }
    if (!NamesMeant(word, CommandNames(app)).empty())
    {
      return word;
    }
    first = first ? first : word;
  }
  return first;
}

std::string MissingCommand(const CLI::App& app)
{
  const std::vector<std::string> names = CommandNames(app);
  const std::optional<std::string> word = WordForCommand(app);
  if (!word)
  {
    return "a command is missing: " + AnyOf(names);
  }
  const std::string meant = DidYouMean(*word, names);
  return "there is no command " + Quoted(*word) + (meant.empty() ? "; use " + AnyOf(names) : meant);
}

// An option of the command that was written before the command.
std::optional<std::string> EarlyOption(const CLI::App& app)
{
  const CLI::App* const command = GivenCommand(app);
  const std::vector<std::string> names =
    command ? OptionNames(*command) : std::vector<std::string>();
  for (const std::string& word : app.remaining())
  {
    if (const auto name = OptionOf(word); name && Contains(names, *name))
    {
      return *name + " belongs after the command: " + app.get_name() + " " + command->get_name() +
             " … " + *name;
    }
  }
  return {};
}

// A word before the command, such as the file that the command is about.
std::optional<std::string> EarlyWord(const CLI::App& app)
{
  const CLI::App* const command = GivenCommand(app);
  const std::vector<std::string> words = app.remaining();
  if (!command || words.empty() || OptionOf(words[0]))
  {
    return {};
  }
  return "the command must come first: " + app.get_name() + " " + command->get_name() + " " +
         words[0];
}

// An unknown option explains most other errors, so it is looked for first.
std::optional<std::string> UnknownOption(const CLI::App& app)
{
  const std::vector<std::string> names = OptionNames(app);
  for (const std::string& word : app.remaining(true))
  {
    if (const auto name = OptionOf(word))
    {
      return Contains(names, *name) // of the program, after the command
               ? *name + " belongs before the command"
               : "there is no option " + *name + DidYouMean(*name, names);
    }
  }
  return {};
}

// CLI11's "a,b,,c", in which an element without a group is empty.
std::vector<std::string> ListOf(const std::string& text)
{
  std::vector<std::string> names;
  std::string name;
  for (std::istringstream words(text); std::getline(words, name, ',');)
  {
    if (!name.empty())
    {
      names.push_back(name);
    }
  }
  return names;
}

// CLI11's message in plain words; unknown messages stay unchanged.
std::string PlainMessage(const std::string& message)
{
  constexpr std::size_t longest = 2000; // std::regex needs stack for each letter
  if (message.size() > longest)
  {
    return message;
  }
  std::smatch part;
  const auto is = [&](const char* form)
  { return std::regex_match(message, part, std::regex(form)); };
  if (is("Exactly 1 option from \\[(.*)\\] is required and (\\d+) were given"))
  {
    return "give only one of " + AnyOf(ListOf(part[1])) + ", not " + part[2].str();
  }
  if (is("Exactly 1 option from \\[(.*)\\] is required"))
  {
    return "one of " + AnyOf(ListOf(part[1])) + " is missing";
  }
  if (is("At least 1 option from \\[(.*)\\] is required"))
  {
    return "at least one of " + AnyOf(ListOf(part[1])) + " is missing";
  }
  if (is("(\\S+): 1 required .* missing"))
  {
    return part[1].str() + " needs a value";
  }
  if (is("Could not convert: (\\S+) = ([\\s\\S]*)"))
  {
    return part[1].str() + ": " + Quoted(part[2]) + " is not a valid value";
  }
  if (is("(\\S+): ([\\s\\S]*) not in \\{(.*)\\}"))
  {
    return part[1].str() + ": " + Quoted(part[2]) + " is not one of " + AnyOf(ListOf(part[3]));
  }
  return message;
}

}

std::vector<std::string> NamesMeant(const std::string& word, const std::vector<std::string>& names)
{
  constexpr std::size_t leastLetters = 2;
  std::vector<std::string> meant;
  const bool enough = word.size() >= word.find_first_not_of('-') + leastLetters;
  std::copy_if(names.begin(), names.end(), std::back_inserter(meant),
    [&](const std::string& name) { return enough && StartsWith(name, word); });
  if (!meant.empty())
  {
    return meant;
  }
  std::size_t fewest = std::max<std::size_t>(1, word.size() / 3) + 1;
  for (const std::string& name : names)
  {
    if (const std::size_t slips = Slips(word, name); slips < fewest)
    {
      fewest = slips;
      meant = { name };
    }
  }
  return meant;
}

std::string DidYouMean(const std::string& word, const std::vector<std::string>& names)
{
  const std::vector<std::string> meant = NamesMeant(word, names);
  return meant.empty() ? "" : "; did you mean " + AnyOf(meant) + "?";
}

std::optional<std::string> UnknownCommand(const CLI::App& app)
{
  return LacksCommand(app) && WordForCommand(app) ? std::optional(MissingCommand(app))
                                                  : std::nullopt;
}

std::string UsageMessage(const CLI::App& app, const CLI::ParseError& error)
{
  for (const auto& look : { UnknownCommand, EarlyOption, UnknownOption, EarlyWord })
  {
    if (const std::optional<std::string> found = look(app))
    {
      return *found;
    }
  }
  return LacksCommand(app) ? MissingCommand(app) : PlainMessage(error.what());
}

}
