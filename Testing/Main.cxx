// SPDX-License-Identifier: BSD-3-Clause
// The main function of every test program. A program contains the tests of one library. Arguments
// are names of its sources, without ".cxx": `CoreTests TestKdTree TestRegion` runs the tests of
// these two. Without arguments all tests run. If sources are named, only the part of --gtest_filter
// after its "-" is used, to leave out tests; else the whole filter is used.
#include <gtest/gtest.h>

#include <filesystem>
#include <iostream>
#include <set>
#include <string>

namespace
{

// A filter for the tests of these sources. Names of sources without tests stay in `sources`.
std::string FilterOf(std::set<std::string>& sources)
{
  std::set<std::string> found;
  std::string filter;
  const auto& program = *testing::UnitTest::GetInstance();
  for (int i = 0; i < program.total_test_suite_count(); ++i)
  {
    const auto& suite = *program.GetTestSuite(i);
    for (int j = 0; j < suite.total_test_count(); ++j)
    {
      const auto& test = *suite.GetTestInfo(j);
      const auto source = std::filesystem::path(test.file()).stem().string();
      if (sources.count(source) > 0)
      {
        found.insert(source);
        filter += (filter.empty() ? "" : ":") + (suite.name() + ('.' + std::string(test.name())));
      }
    }
  }
  for (const auto& source : found)
  {
    sources.erase(source);
  }
  return filter;
}

}

int main(int argc, char** argv)
{
  testing::InitGoogleTest(&argc, argv);
  std::set<std::string> sources(argv + 1, argv + argc);
  if (!sources.empty())
  {
    const auto filter = FilterOf(sources);
    for (const auto& source : sources)
    {
      std::cerr << argv[0] << ": no test is in a source named " << source << ".cxx\n";
    }
    if (!sources.empty())
    {
      return 2;
    }
    const std::string asked = GTEST_FLAG_GET(filter);
    const auto without = asked.find('-');
    GTEST_FLAG_SET(filter, filter + (without == std::string::npos ? "" : asked.substr(without)));
  }
  return RUN_ALL_TESTS();
}
