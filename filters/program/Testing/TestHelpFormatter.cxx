// SPDX-License-Identifier: BSD-3-Clause
// The help's lines fit, and lose nothing.
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
    "Usage: kdstream-test [OPTIONS] INPUT\n\n"
    "  INPUT                       the mesh\n\n"
    "Partitions:\n"
    "  --vertices-per-partition N  most vertices of a partition, of which a long story is told "
    "elsewhere\n"
    "                              [1 to 1048576, default 2000] (not with --partitions)\n"
    "  --partitions N              how many instead (not with --vertices-per-partition)\n\n"
    "Input:\n"
    "  -w, --weld on|off           join vertices [default on]\n\n"
    "Help:\n"
    "  -h, --help                  this text\n"
    "  --version                   name and version\n\n"
    "Example:\n"
    "  kdstream-test dragon.ply\n");
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
