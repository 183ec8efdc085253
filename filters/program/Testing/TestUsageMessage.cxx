// SPDX-License-Identifier: BSD-3-Clause
// Messages for wrong command lines report the cause, where CLI11 reports its consequence.
#include "filters/program/HelpFormatter.h"
#include "filters/program/UsageMessage.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>

using namespace kdstream;

namespace
{

// The message of a program with options of every kind.
std::string MessageOf(std::vector<std::string> arguments)
{
  CLI::App app("", "kdstream-test");
  std::string input, output, title, folder, color, weld;
  std::uint16_t port = 0;
  unsigned threads = 0;
  double radius = 0;
  bool all = false;
  app.add_option("INPUT", input)->required();
  app.add_option("-o,--output", output, "the store to write")->required();
  auto* const titleOption = app.add_option("--title", title);
  app.add_option("--port", port);
  app.add_option("--partitions", port)->type_name("K");
  app.add_option("--radius", radius);
  app.add_option("--threads", threads)->check(CLI::Range(1U, 1024U));
  app.add_option("--weld", weld)->check(CLI::IsMember({ "on", "off" }));
  app.add_option("--temp-dir", folder)->check(CLI::ExistingDirectory);
  app.add_option("--credit", color)->excludes(titleOption);
  app.add_flag("--all", all)->needs(titleOption);
  std::reverse(arguments.begin(), arguments.end()); // the order that CLI11 requires for a vector
  try
  {
    app.parse(arguments);
  }
  catch (const CLI::ParseError& error)
  {
    return UsageMessage(app, error);
  }
  return "";
}

std::string MessageOfCommand(std::vector<std::string> arguments)
{
  CLI::App app("", "kdstream-test");
  app.require_subcommand(1);
  app.set_version_flag("--version", "1.2.3");
  std::string store;
  unsigned level = 0, partition = 0;
  app.add_subcommand("info")->add_option("STORE", store)->required();
  CLI::App* const extract = app.add_subcommand("extract");
  extract->add_option("STORE", store)->required();
  auto* const what = extract->add_option_group("what");
  what->add_option("--level", level);
  what->add_option("--partition", partition);
  what->require_option(1);
  std::reverse(arguments.begin(), arguments.end());
  try
  {
    app.parse(arguments);
  }
  catch (const CLI::Success&) // help
  {
    return UnknownCommand(app).value_or("");
  }
  catch (const CLI::ParseError& error)
  {
    return UsageMessage(app, error);
  }
  return "";
}

const std::vector<std::string> right{ "in.ply", "-o", "out.kds" };

std::string MessageWith(std::vector<std::string> more)
{
  more.insert(more.begin(), right.begin(), right.end());
  return MessageOf(more);
}

}

TEST(UsageMessage, UnknownOptionsAreNamedWithTheNearest)
{
  EXPECT_EQ(MessageOf(right), "");
  EXPECT_EQ(MessageWith({ "--tittle", "x" }), "there is no option --tittle; did you mean --title?");
  EXPECT_EQ(
    MessageOf({ "--tittle", "x", "in.ply" }), "there is no option --tittle; did you mean --title?");
  EXPECT_EQ(
    MessageOf({ "in.ply", "--outptu=x" }), "there is no option --outptu; did you mean --output?");
  EXPECT_EQ(MessageWith({ "--frobnicate" }), "there is no option --frobnicate");
}

TEST(UsageMessage, CommandsToo)
{
  EXPECT_EQ(
    MessageOfCommand({ "inof", "m.kds" }), "there is no command \"inof\"; did you mean info?");
  EXPECT_EQ(
    MessageOfCommand({ "frobnicate" }), "there is no command \"frobnicate\"; use info or extract");
  // The help of a command that does not exist would be the help of the program.
  EXPECT_EQ(MessageOfCommand({ "frobnicate", "--help" }),
    "there is no command \"frobnicate\"; use info or extract");
  EXPECT_EQ(
    MessageOfCommand({ "--help", "inof" }), "there is no command \"inof\"; did you mean info?");
  EXPECT_EQ(MessageOfCommand({ "--help" }), "");
  EXPECT_EQ(MessageOfCommand({ "info", "--help" }), "");
  EXPECT_EQ(MessageOfCommand({}), "a command is missing: info or extract");
  // The command is named, whatever options precede or follow it.
  EXPECT_EQ(MessageOfCommand({ "inof", "m.kds", "--json" }),
    "there is no command \"inof\"; did you mean info?");
  EXPECT_EQ(MessageOfCommand({ "--level", "3", "extrat", "m.kds" }),
    "there is no command \"extrat\"; did you mean extract?");
  EXPECT_EQ(MessageOfCommand({ "--jsn" }), "there is no option --jsn");
  EXPECT_EQ(MessageOfCommand({ "--level", "3", "extract", "m.kds" }),
    "--level belongs after the command: kdstream-test extract … --level");
  EXPECT_EQ(MessageOfCommand({ "--level=3", "extract", "m.kds" }),
    "--level belongs after the command: kdstream-test extract … --level");
  EXPECT_EQ(
    MessageOfCommand({ "m.kds", "info" }), "the command must come first: kdstream-test info m.kds");
  EXPECT_EQ(MessageOfCommand({ "m.kds", "extract", "--level", "3" }),
    "the command must come first: kdstream-test extract m.kds");
  EXPECT_EQ(MessageOfCommand({ "m.kds", "info", "other.kds" }),
    "the command must come first: kdstream-test info m.kds");
  EXPECT_EQ(
    MessageOfCommand({ "extract", "m.kds", "--version" }), "--version belongs before the command");
  EXPECT_EQ(MessageOfCommand({ "extract", "m.kds", "--lvel", "3" }),
    "there is no option --lvel; did you mean --level?");
}

TEST(UsageMessage, MessagesOfCli11AreInPlainWords)
{
  EXPECT_EQ(MessageWith({ "--weld", "ON" }), "--weld: \"ON\" is not one of on or off");
  EXPECT_EQ(MessageWith({ "--port=-1" }), "--port: \"-1\" is not a valid value");
  EXPECT_EQ(MessageWith({ "--title" }), "--title needs a value");
  EXPECT_EQ(MessageOfCommand({ "extract", "m.kds" }), "one of --level or --partition is missing");
  EXPECT_EQ(MessageOfCommand({ "extract", "m.kds", "--level", "1", "--partition", "2" }),
    "give only one of --level or --partition, not 2");
}

// The option and the right form are named, whatever CLI11's words are.
TEST(UsageMessage, OtherErrorsAreThoseOfCli11)
{
  const std::pair<std::string, std::vector<std::string>> cases[] = { { "other.ply",
                                                                       { "other.ply" } },
    { "--title", { "--title" } }, { "--credit", { "--title", "a", "--credit", "b" } },
    { "--title", { "--all" } }, { "--port", { "--port", "99999" } },
    { "--radius", { "--radius", "wide" } }, { "1024", { "--threads", "0" } },
    { "off", { "--weld", "maybe" } }, { "/no/such", { "--temp-dir", "/no/such" } } };
  for (const auto& [named, arguments] : cases)
  {
    EXPECT_NE(MessageWith(arguments).find(named), std::string::npos) << MessageWith(arguments);
  }
  EXPECT_NE(MessageOf({ "in.ply" }).find("--output"), std::string::npos);
  EXPECT_NE(MessageOf({ "-o", "m.kds" }).find("INPUT"), std::string::npos);
  EXPECT_NE(MessageOfCommand({ "extract", "m.kds" }).find("--partition"), std::string::npos);
}

TEST(UsageMessage, NamesMeant)
{
  using Names = std::vector<std::string>;
  EXPECT_EQ(NamesMeant("--tilte", { "--time", "--title" }), Names{ "--title" })
    << "letters swapped";
  EXPECT_EQ(NamesMeant("--levels", { "--level", "--partition" }), Names{ "--level" });
  EXPECT_EQ(NamesMeant("--xyz", { "--level", "--partition" }), Names{});
  // The beginning of a name counts more than a few wrong letters.
  EXPECT_EQ(NamesMeant("--vertice", { "--version", "--vertices-per-partition" }),
    Names{ "--vertices-per-partition" });
  EXPECT_EQ(NamesMeant("--mem", { "--median", "--memory" }), Names{ "--memory" });
  EXPECT_EQ(NamesMeant("--part", { "--partitions", "--level", "--partitioner" }),
    (Names{ "--partitions", "--partitioner" }));
  EXPECT_EQ(NamesMeant("ver", { "info", "verify" }), Names{ "verify" });
  EXPECT_EQ(NamesMeant("--x", { "--xyzzy" }), Names{}) << "one letter is no beginning";
}
