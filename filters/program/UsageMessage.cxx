// SPDX-License-Identifier: BSD-3-Clause
#include "filters/program/UsageMessage.h"

#include <algorithm>
#include <iterator>
#include <numeric>

namespace kdstream
{
namespace
{

// Letters that are put in, left out, exchanged, or swapped with the next one.
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

// "a, b or c".
std::string AnyOf(const std::vector<std::string>& names)
{
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i)
  {
    text += (i == 0 ? "" : i + 1 == names.size() ? " or " : ", ") + names[i];
  }
  return text;
}

// The entries of "a,b,c", each up to "->", behind which CLI11 tells what it becomes.
std::vector<std::string> EntriesOf(const std::string& list)
{
  std::vector<std::string> entries;
  for (std::string entry : CLI::detail::split(list, ','))
  {
    entry = CLI::detail::trim_copy(entry.substr(0, entry.find("->")));
    if (!entry.empty())
    {
      entries.push_back(entry);
    }
  }
  return entries;
}

// The program, the commands that were given, and the groups of options of each.
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

// "--title" of the word "--title=x"; none if the word is no option.
std::optional<std::string> OptionOf(const std::string& word)
{
  return word.size() > 1 && word[0] == '-' && word != "--"
           ? std::optional<std::string>(word.substr(0, word.find('=')))
           : std::nullopt;
}

// The command that was given, if there was one.
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

// The word that was most likely meant as the command: the nearest to one, else the first that is no
// option; none if there are only options.
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
  return "there is no command " + Quoted(*word) +
         (meant.empty() ? "; there is " + AnyOf(names) : meant);
}

// An option of the command that stands before it.
std::optional<std::string> EarlyOption(const CLI::App& app)
{
  const CLI::App* const command = GivenCommand(app);
  const std::vector<std::string> names =
    command ? OptionNames(*command) : std::vector<std::string>();
  for (const std::string& word : app.remaining())
  {
    if (const auto name = OptionOf(word); name && Contains(names, *name))
    {
      return *name + " belongs behind the command: " + app.get_name() + " " + command->get_name() +
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
  return "the command stands first: " + app.get_name() + " " + command->get_name() + " " + words[0];
}

// An option that there is not explains most that follows from it, so it is looked for first.
std::optional<std::string> UnknownOption(const CLI::App& app)
{
  const std::vector<std::string> names = OptionNames(app);
  for (const std::string& word : app.remaining(true))
  {
    if (const auto name = OptionOf(word))
    {
      return Contains(names, *name) // of the program, behind the command
               ? *name + " belongs before the command"
               : "there is no option " + *name + DidYouMean(*name, names);
    }
  }
  return {};
}

// What is between two parts of a text that CLI11 makes; none if it has another form.
std::optional<std::string> Between(
  const std::string& text, const std::string& before, const std::string& after)
{
  const std::size_t begin = text.find(before);
  if (begin == std::string::npos)
  {
    return {};
  }
  const std::size_t from = begin + before.size();
  const std::size_t end = after.empty() ? text.size() : text.find(after, from);
  return end == std::string::npos ? std::nullopt
                                  : std::optional<std::string>(text.substr(from, end - from));
}

// Of a text that has failed a check, which CLI11 told as `told`; ours are passed on.
std::string WordsOfCheck(const std::string& told)
{
  if (StartsWith(told, "Value "))
  {
    const auto value = Between(told, "Value ", " not in range ");
    const auto range = Between(told, " not in range ", "");
    return value && range ? Quoted(*value) + " is not a number from " + *range : told;
  }
  if (StartsWith(told, "Check ")) // of a name that stands for something
  {
    const std::size_t list = told.find('{');
    const std::size_t end = told.find('}', list);
    if (list != std::string::npos && end != std::string::npos)
    {
      const std::string value = told.substr(6, told.find(' ', 6) - 6);
      return Quoted(value) + " is not " + AnyOf(EntriesOf(told.substr(list + 1, end - list - 1)));
    }
  }
  if (const std::size_t middle = told.rfind(" not in {"); middle != std::string::npos)
  {
    const std::vector<std::string> names =
      EntriesOf(told.substr(middle + 9, told.rfind('}') - middle - 9));
    return Quoted(told.substr(0, middle)) + " is not " + AnyOf(names);
  }
  for (const auto& [theirs, ours] :
    { std::pair{ "Directory does not exist: ", "there is no folder " },
      { "Directory is actually a file: ", "this is a file, not a folder: " },
      { "File does not exist: ", "there is no file " },
      { "File is actually a directory: ", "this is a folder, not a file: " } })
  {
    if (StartsWith(told, theirs))
    {
      return ours + told.substr(std::string(theirs).size());
    }
  }
  return told;
}

// A value that is no number of the option's type.
std::string WordsOfConversion(const CLI::App& app, const std::string& told)
{
  const auto name = Between(told, "Could not convert: ", " = ");
  const auto value = Between(told, " = ", "");
  if (!name || !value)
  {
    return told;
  }
  std::string type;
  for (const CLI::App* const part : Parsed(app))
  {
    const CLI::Option* const option = part->get_option_no_throw(*name);
    type = option ? option->get_type_name() : type;
  }
  return *name + ": " + Quoted(*value) +
         (type.empty()                 ? " is not a value that it takes"
           : StartsWith(type, "FLOAT") ? " is not a number"
                                       : " is not a whole number, or out of range");
}

std::string WordsOfMissing(const CLI::App& app, const std::string& told)
{
  if (StartsWith(told, "A subcommand"))
  {
    return MissingCommand(app);
  }
  if (const auto list = Between(told, "from [", "]"))
  {
    const bool several = told.find("At least 1") != std::string::npos;
    return (several ? "at least one of " : "exactly one of ") + AnyOf(EntriesOf(*list)) +
           " is needed";
  }
  const auto name = Between(told, "", " is required");
  if (!name)
  {
    return told;
  }
  std::string what;
  for (const CLI::App* const part : Parsed(app))
  {
    const CLI::Option* const option = part->get_option_no_throw(*name);
    what = option ? option->get_description() : what;
  }
  return *name + " is missing" + (what.empty() ? "" : ": ") + what;
}

std::string WordsOfMismatch(const std::string& told)
{
  const std::string name = told.substr(0, told.find(": "));
  if (told.find(" required ") != std::string::npos && told.find("missing") != std::string::npos)
  {
    return name + " needs a value";
  }
  if (told.find("At Most 1 required") != std::string::npos)
  {
    return name + " may be given once";
  }
  return told;
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
  const bool lacksCommand = app.get_require_subcommand_min() > 0 && !GivenCommand(app);
  return lacksCommand && WordForCommand(app) ? std::optional(MissingCommand(app)) : std::nullopt;
}

std::string UsageMessage(const CLI::App& app, const CLI::ParseError& error)
{
  if (const auto unknown = UnknownCommand(app))
  {
    return *unknown;
  }
  if (const auto early = EarlyOption(app))
  {
    return *early;
  }
  if (const auto unknown = UnknownOption(app))
  {
    return *unknown;
  }
  if (const auto early = EarlyWord(app))
  {
    return *early;
  }
  const std::string told = error.what();
  if (dynamic_cast<const CLI::ExtrasError*>(&error))
  {
    const std::vector<std::string> words = app.remaining(true);
    return "nothing is expected after the other arguments, but there is " +
           Quoted(words.empty() ? told : words[0]);
  }
  if (dynamic_cast<const CLI::RequiredError*>(&error))
  {
    return WordsOfMissing(app, told);
  }
  if (dynamic_cast<const CLI::ConversionError*>(&error))
  {
    return WordsOfConversion(app, told);
  }
  if (dynamic_cast<const CLI::ArgumentMismatch*>(&error))
  {
    return WordsOfMismatch(told);
  }
  if (dynamic_cast<const CLI::ExcludesError*>(&error))
  {
    const auto first = Between(told, "", " excludes "), second = Between(told, " excludes ", "");
    return first && second ? *first + " and " + *second + " cannot be given together" : told;
  }
  if (dynamic_cast<const CLI::RequiresError*>(&error))
  {
    const auto first = Between(told, "", " requires "), second = Between(told, " requires ", "");
    return first && second ? *first + " needs " + *second : told;
  }
  if (dynamic_cast<const CLI::ValidationError*>(&error))
  {
    const std::size_t colon = told.find(": ");
    return colon == std::string::npos
             ? WordsOfCheck(told)
             : told.substr(0, colon) + ": " + WordsOfCheck(told.substr(colon + 2));
  }
  return told;
}

}
