// SPDX-License-Identifier: BSD-3-Clause
// The lines of the help fit the width, and no text is lost.
#include "filters/program/HelpFormatter.h"

#include <gtest/gtest.h>

#include <sstream>

using namespace kdstream;

namespace
{

std::size_t LongestLine(const std::string& text)
{
  std::istringstream lines(text);
  std::size_t longest = 0;
  for (std::string line; std::getline(lines, line);)
  {
    longest = std::max(longest, line.size());
  }
  return longest;
}

std::string Help(std::size_t width)
{
  CLI::App app("Cuts a mesh into partitions, and writes them to a store that is streamed from.",
    "kdstream-test");
  std::string input, title, weld = "on";
  unsigned size = 2000, number = 0;
  app.add_option("INPUT", input, "the mesh")->required();
  auto* const sizeOption = app
                             .add_option("--vertices-per-partition", size,
                               "most vertices of a partition, of which a long "
                               "story is told elsewhere")
                             ->check(CLI::Range(1U, 1U << 20))
                             ->capture_default_str()
                             ->group("Partitions");
  app.add_option("--partitions", number, "how many instead")
    ->excludes(sizeOption)
    ->group("Partitions");
  app.add_option("-o,--output", title, "the store")
    ->required()
    ->type_name("STORE")
    ->group("Output");
  app.add_option("-w,--weld", weld, "join vertices")
    ->check(CLI::IsMember({ "on", "off" }))
    ->capture_default_str()
    ->group("Input");
  app.footer("Example:\n  kdstream-test dragon.ply");
  SetUpHelp(app, "1.2.3");
  app.formatter(std::make_shared<HelpFormatter>(width));
  return app.help();
}

}

TEST(HelpFormatter, WrapsBetweenWordsAndKeepsLines)
{
  EXPECT_EQ(WrapText("one two three four", 9), "one two\nthree\nfour");
  EXPECT_EQ(WrapText("  one two three", 10, 2), "  one two\n    three");
  EXPECT_EQ(WrapText("a\n\nb", 10), "a\n\nb");
  EXPECT_EQ(WrapText("incomprehensibilities are long", 5), "incomprehensibilities\nare\nlong");
  EXPECT_EQ(WrapText("", 5), "");
  EXPECT_EQ(
    WrapText("  .ply     a mesh\n  .xyz.gz  points", 20), "  .ply     a mesh\n  .xyz.gz  points")
    << "columns";
}

TEST(HelpFormatter, NoLineIsWiderThanTheTerminal)
{
  for (const std::size_t width : { 60U, 80U, 100U })
  {
    EXPECT_LE(LongestLine(Help(width)), width);
  }
  EXPECT_GT(LongestLine(Help(100)), 80U) << "the width is used";
}

TEST(HelpFormatter, GroupsValuesDefaultsAndTheExample)
{
  EXPECT_EQ(Help(100),
    "Cuts a mesh into partitions, and writes them to a store that is streamed from.\n\n"
    "Usage: kdstream-test INPUT -o STORE [options]\n\n"
    "  INPUT                       the mesh\n\n"
    "Partitions:\n"
    "  --vertices-per-partition N  most vertices of a partition, of which a long story is told "
    "elsewhere\n"
    "                              [1 to 1048576, default 2000] (not with --partitions)\n"
    "  --partitions N              how many instead (not with --vertices-per-partition)\n\n"
    "Output:\n"
    "  -o, --output STORE          the store\n\n"
    "Input:\n"
    "  -w, --weld on|off           join vertices [default on]\n\n"
    "Help:\n"
    "  -h, --help                  this text\n"
    "  --version                   name and version\n\n"
    "Example:\n"
    "  kdstream-test dragon.ply\n");
}

TEST(HelpFormatter, ACommandPrintsOnlyItsOwn)
{
  CLI::App app("Looks at stores.", "kdstream-test");
  app.require_subcommand(1);
  CLI::App* const extract = app.add_subcommand("extract", "writes a mesh out of the store");
  std::string store, output;
  unsigned level = 0;
  bool all = false, quiet = false;
  extract->add_option("STORE", store, "the store")->required();
  CLI::App* const what = extract->add_option_group("WHAT", "exactly one of");
  what->add_option("--level", level, "level D")->type_name("D");
  what->add_flag("--all", all, "all of it");
  what->require_option(1);
  extract->add_option("-o,--output", output, "the mesh")
    ->required()
    ->type_name("FILE")
    ->group("Output");
  extract->add_flag("--quiet", quiet, "no line at the end")->group("Output");
  app.footer("Examples:\n  kdstream-test extract a.kds --all -o a.ply");
  extract->footer("Example:\n  kdstream-test extract b.kds --all -o b.ply");
  SetUpHelp(app, "1.2.3");
  EXPECT_EQ(extract->help("kdstream-test"),
    "Writes a mesh out of the store.\n\n"
    "Usage: kdstream-test extract STORE WHAT -o FILE [options]\n\n"
    "  STORE                       the store\n\n"
    "WHAT, exactly one of:\n"
    "  --level D                   level D\n"
    "  --all                       all of it\n\n"
    "Output:\n"
    "  -o, --output FILE           the mesh\n"
    "  --quiet                     no line at the end\n\n"
    "Help:\n"
    "  -h, --help                  this text\n\n"
    "Example:\n"
    "  kdstream-test extract b.kds --all -o b.ply\n");
  EXPECT_EQ(app.help(), "Looks at stores.\n\n"
                        "Usage: kdstream-test COMMAND [options]\n\n"
                        "Commands:\n"
                        "  extract                     writes a mesh out of the store\n\n"
                        "Help:\n"
                        "  -h, --help                  this text\n"
                        "  --version                   name and version\n\n"
                        "Examples:\n"
                        "  kdstream-test extract a.kds --all -o a.ply\n");
}

TEST(HelpFormatter, VersionNamesTheProgram)
{
  CLI::App app("", "kdstream-test");
  SetUpHelp(app, "1.2.3");
  try
  {
    app.parse(std::vector<std::string>{ "--version" });
    FAIL();
  }
  catch (const CLI::CallForVersion& version)
  {
    EXPECT_EQ(std::string(version.what()), "kdstream-test 1.2.3");
  }
}
