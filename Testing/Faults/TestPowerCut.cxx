// SPDX-License-Identifier: BSD-3-Clause
// The power is cut at each moment of a program's work. A file that the program replaces then has
// its old or its new content, and after the program has ended, its new content. Anything else that
// is left does not prevent running the program again. KDSTREAM_ALL_FAULTS=1 tries more of the
// possible states.
#include "Testing/Faults/Operations.h"
#include "Testing/Faults/PowerCut.h"

#include <gtest/gtest.h>

#include <iostream>

using namespace kdstream;

namespace
{

using fixtures::FaultyProgram;
using fixtures::FileTree;
using fixtures::Operation;

bool Is(const FileTree& tree, const std::string& name, const std::string& content)
{
  const auto found = tree.find(name);
  return found != tree.end() && found->second == content;
}

// Checks that all files that an export's list or description names exist. Returns what is wrong, or
// "".
std::string WrongInExport(const FileTree& left, const FileTree& after)
{
  for (const char* const telling : { "web/up/api/models.json", "web/up/api/models.json.gz",
         "web/up/api/models/a/model.json", "web/up/api/models/a/model.json.gz" })
  {
    const auto reported = after.find(telling);
    if (reported == after.end() || !Is(left, telling, reported->second))
    {
      continue;
    }
    for (const auto& [name, content] : after)
    {
      const bool isOfModel = name.starts_with("web/up/api/models/a/") && !name.ends_with('/') &&
                             name.find('.') == name.npos;
      if (isOfModel && !Is(left, name, content))
      {
        return std::string(telling) + " is as after, but not " + name;
      }
    }
  }
  return "";
}

// Checks that each file is complete, with its old or its new content; isDone: its new content.
// Returns what is wrong, or "".
std::string Wrong(const FileTree& before, const FileTree& after, const FileTree& left, bool isDone)
{
  for (const auto& [name, content] : after)
  {
    const auto old = before.find(name);
    if (name.ends_with('/') || Is(left, name, content))
    {
      continue;
    }
    if (isDone)
    {
      return name + " is not durable";
    }
    const bool isOld = old == before.end() ? left.count(name) == 0 : Is(left, name, old->second);
    if (!isOld)
    {
      return name + (left.count(name) == 0 ? " is lost" : " is neither as before nor as after");
    }
  }
  for (const auto& [name, content] : before)
  {
    if (after.count(name) == 0 && left.count(name) != 0 && !Is(left, name, content))
    {
      return name + " was to be removed, and is damaged";
    }
  }
  return WrongInExport(left, after);
}

class PowerCuts : public testing::TestWithParam<const char*>
{
};

}

TEST_P(PowerCuts, OldOrNewNeverNeither)
{
  const Operation& operation = fixtures::OperationOf(GetParam());
  const fixtures::TemporaryFolder folder, records;
  const std::string record = records / "record";
  fixtures::WriteTree(folder.Path, operation.before);
  const auto before = fixtures::ReadTree(folder.Path); // includes all folders
  const auto inodes = fixtures::ReadInodes(folder.Path);
  {
    FaultyProgram program(fixtures::faultLibrary, folder.Path,
      fixtures::ProgramPath(operation.program), operation.arguments, record);
    ASSERT_EQ(program.Run().exitCode, 0);
  }
  const auto after = fixtures::ReadTree(folder.Path);
  const fixtures::PowerCut cut(record, folder.Path, before, inodes);
  ASSERT_GT(cut.Moments(), 5u);
  ASSERT_EQ(cut.After(cut.Moments() - 1, 1), after) << "what is written down is all that was done";

  const bool all = std::getenv("KDSTREAM_ALL_FAULTS") != nullptr;
  const std::uint32_t seeds = all ? 40 : 4;
  std::map<std::string, std::string> found;
  std::uint64_t states = 0, again = 0;
  FaultyProgram program(fixtures::faultLibrary, folder.Path,
    fixtures::ProgramPath(operation.program), operation.arguments);
  for (std::size_t actions = 0; actions < cut.Moments(); ++actions)
  {
    for (std::uint32_t seed = 0; seed < seeds; ++seed, ++states)
    {
      const auto left =
        cut.After(actions, seed < 2 ? seed : static_cast<std::uint32_t>(actions) * seeds + seed);
      const auto wrong = Wrong(before, after, left, actions + 1 == cut.Moments());
      if (!wrong.empty())
      {
        found.emplace(wrong, "after " + std::to_string(actions) + " deeds, seed " +
                               std::to_string(seed) + "\n" + cut.Describe(actions));
      }
      const auto stride = all ? 97u : 997u;
      if (!wrong.empty() || states % stride != 0)
      {
        continue;
      }
      ++again;
      fixtures::WriteTree(folder.Path, left);
      const auto outcome = program.Run();
      const auto now = fixtures::ReadTree(folder.Path);
      std::string problem = outcome.exitCode == 0 ? "" : "it fails: " + outcome.err;
      for (const auto& [name, content] : after)
      {
        problem +=
          Is(now, name, content) || !problem.empty() ? "" : name + " is not as it should be";
      }
      if (!problem.empty())
      {
        found.emplace("done again, " + problem,
          "after " + std::to_string(actions) + " deeds, seed " + std::to_string(seed));
      }
    }
  }
  std::cout << operation.name << ": " << cut.Moments() << " moments, " << states << " states, "
            << again << " times done again, " << found.size() << " kinds of wrong" << std::endl;
  std::size_t reported = 0;
  for (const auto& [wrong, how] : found)
  {
    if (++reported <= 5)
    {
      ADD_FAILURE() << operation.name << ": " << wrong << "\n" << how;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, PowerCuts,
  testing::Values("build", "rebuild", "external", "edit", "extract", "notes", "export",
    "exportagain", "exportanother", "tiles", "glb"),
  [](const auto& tested) { return std::string(tested.param); });
