// SPDX-License-Identifier: BSD-3-Clause
// Every system call of a program fails in its turn, once or from then on, as in SQLite's tests.
// Whatever fails, the program ends with exit code 0 and all of its output, or with an error; no
// file is lost, incomplete or left over. Every test run tries some of the calls, chosen by a seed;
// KDSTREAM_ALL_FAULTS=1 tries all.
#include "Testing/Faults/Operations.h"

#include <gtest/gtest.h>
#include <tbb/version.h>

#include <algorithm>
#include <cstdlib>
#include <iostream>
#include <random>
#include <set>
#include <sstream>

using namespace kdstream;

namespace
{

using fixtures::FaultyProgram;
using fixtures::FileTree;
using fixtures::Operation;

// TBB 2022 (Debian 13) waits for ever if the first memory that it takes for threads is refused: its
// throw_exception spins on a lock that its initialisation holds.
bool IsOfTbb(const std::string& kind, std::uint64_t call, const std::string& wrong)
{
  return TBB_VERSION_MAJOR >= 2022 && kind == "mapping" && call == 1 &&
         wrong.rfind("exit code 142", 0) == 0; // SIGALRM
}

struct Kind
{
  Fault Faults::*fault;
  std::string name;
  int reason;
};

const std::vector<Kind>& Kinds()
{
  static const std::vector<Kind> kinds{ { &Faults::allocation, "allocation", ENOMEM },
    { &Faults::reading, "reading", EIO }, { &Faults::reading, "reading", EINTR },
    { &Faults::writing, "writing", ENOSPC }, { &Faults::writing, "writing", EINTR },
    { &Faults::opening, "opening", EMFILE }, { &Faults::creating, "creating", EACCES },
    { &Faults::looking, "looking", EIO }, { &Faults::syncing, "syncing", EIO },
    { &Faults::sizing, "sizing", ENOSPC }, { &Faults::renaming, "renaming", EIO },
    { &Faults::removing, "removing", EIO }, { &Faults::owning, "owning", EPERM },
    { &Faults::mapping, "mapping", ENOMEM }, { &Faults::starting, "starting", EAGAIN } };
  return kinds;
}

// Checks that there is an error line that names a file of the folder, or the folder (errors of
// memory and threads name no file). Returns what is wrong, or "".
std::string WrongInMessage(const Operation& operation, const Kind& kind, const std::string& said,
  const std::filesystem::path& folder)
{
  const auto start = operation.program + ": error: ";
  const auto line = said.find(start);
  if (line == said.npos)
  {
    return "no error line";
  }
  const auto text = said.substr(line + start.size());
  const bool ofNoFile = kind.fault == &Faults::allocation || kind.fault == &Faults::mapping ||
                        kind.fault == &Faults::starting;
  const auto file = text.substr(0, text.find(": "));
  if (file == "." || file.find(folder.filename()) != file.npos)
  {
    return "";
  }
  for (const char* const name :
    { "a.kds", "mesh.ply", "notes.json", "web", "quotas.db", "out", "new" })
  {
    if (file.find(name) != file.npos)
    {
      return "";
    }
  }
  return ofNoFile ? "" : "no file is named";
}

// Checks that each file is complete, and as it was before or as it is afterwards; and that there is
// no other file. Returns what is wrong, or "".
std::string WrongInFiles(const Operation& operation, const FileTree& after, const FileTree& now,
  bool isDone, bool mayLeave)
{
  for (const auto& [name, content] : now)
  {
    const auto old = operation.before.find(name), made = after.find(name);
    if (operation.others.count(name) != 0)
    {
      continue;
    }
    const bool isFolder = name.ends_with('/');
    if (old == operation.before.end() && made == after.end())
    {
      const auto leaf = name.substr(0, name.size() - (isFolder ? 1 : 0));
      const auto hidden = leaf.find("/.") != leaf.npos || leaf.starts_with('.');
      if (!mayLeave || !hidden)
      {
        return name + " is left over";
      }
      continue;
    }
    const bool isOld = old != operation.before.end() && old->second == content;
    const bool isNew = made != after.end() && made->second == content;
    if (isDone ? !isNew : !isOld && !isNew)
    {
      return name + (isDone ? " is not as it should be" : " is neither as before nor as after") +
             " (" + std::to_string(content.size()) + " bytes)";
    }
  }
  for (const auto& [name, content] : isDone ? after : operation.before)
  {
    if (now.count(name) == 0 && operation.others.count(name) == 0 && after.count(name) != 0)
    {
      return name + " is lost";
    }
  }
  return "";
}

class AtEveryStep : public testing::TestWithParam<const char*>
{
protected:
  const Operation& Of = fixtures::OperationOf(GetParam());
  const FileTree Whole = fixtures::TreeAfter(this->Of);
  const fixtures::TemporaryFolder Folder;
  FaultyProgram Program{ fixtures::faultLibrary, this->Folder.Path,
    fixtures::ProgramPath(this->Of.program), this->Of.arguments };
  std::uint64_t Runs = 0, Done = 0, Failed = 0, Left = 0, Wrong = 0;
  std::map<std::string, std::string> Found; // the first error of each kind

  // Runs once; `call` fails, or all calls from there on. Returns what is wrong, or "".
  std::string Try(const Kind& kind, std::uint64_t call, bool once)
  {
    fixtures::WriteTree(this->Folder.Path, this->Of.before);
    auto& faults = this->Program.What();
    faults.Clear();
    (faults.*kind.fault).Fail(kind.reason, call, once ? call : ~std::uint64_t{ 0 });
    const auto outcome = this->Program.Run();
    faults.Clear();
    ++this->Runs;
    const bool isDone = outcome.exitCode == 0;
    ++(isDone ? this->Done : this->Failed);
    std::string wrong;
    if (outcome.exitCode != 0 && outcome.exitCode != 1)
    {
      wrong = "exit code " + std::to_string(outcome.exitCode);
    }
    if (wrong.empty() && !isDone)
    {
      wrong = WrongInMessage(this->Of, kind, outcome.err, this->Folder.Path);
    }
    if (wrong.empty())
    {
      // A file that cannot be opened, listed or locked cannot be removed; the next run removes it.
      const bool mayLeave =
        kind.fault == &Faults::removing || kind.fault == &Faults::looking ||
        kind.fault == &Faults::owning ||
        (!once && (kind.fault == &Faults::allocation || kind.fault == &Faults::opening));
      const auto now = fixtures::ReadTree(this->Folder.Path);
      wrong = WrongInFiles(this->Of, this->Whole, now, isDone, mayLeave);
      if (wrong.empty() && mayLeave && (this->Of.repeats || !isDone) &&
          !WrongInFiles(this->Of, this->Whole, now, isDone, false).empty())
      {
        ++this->Left;
        wrong =
          this->Program.Run().exitCode != 0 ? "what was left keeps it from being done again" : "";
        wrong = !wrong.empty() ? wrong
                               : WrongInFiles(this->Of, this->Whole,
                                   fixtures::ReadTree(this->Folder.Path), true, false);
        wrong = wrong.empty() ? "" : "done again: " + wrong;
      }
    }
    if (wrong.empty() && this->Of.recovers && once && !isDone && kind.fault != &Faults::allocation)
    {
      wrong = "it does not try again";
    }
    if (wrong.empty())
    {
      wrong = this->Of.check(outcome, this->Folder.Path);
    }
    return wrong.empty() ? "" : wrong + "; it said: " + outcome.err.substr(0, 300);
  }

  // The number of calls of this kind in a run in which none fails.
  std::uint64_t Calls(const Kind& kind)
  {
    fixtures::WriteTree(this->Folder.Path, this->Of.before);
    this->Program.What().Clear();
    const auto outcome = this->Program.Run();
    EXPECT_EQ(outcome.exitCode, 0) << outcome.err;
    return (this->Program.What().*kind.fault).calls;
  }
};

}

TEST_P(AtEveryStep, NothingIsLostOrHalf)
{
  const bool all = std::getenv("KDSTREAM_ALL_FAULTS") != nullptr;
  constexpr std::uint64_t sample = 6;
  std::minstd_rand random(13);
  for (const Kind& kind : Kinds())
  {
    const auto calls = this->Calls(kind);
    const auto before = this->Runs;
    for (const bool once : { true, false })
    {
      if (kind.reason == EINTR && !once)
      {
        continue; // no program is interrupted forever
      }
      const auto step = [&](std::uint64_t call)
      {
        const auto wrong = this->Try(kind, call, once);
        if (!wrong.empty() && !IsOfTbb(kind.name, call, wrong))
        {
          ++this->Wrong;
          std::ostringstream how;
          how << "KDSTREAM_FAULT=" << kind.name << "," << call << "," << (once ? "once" : "on")
              << "," << kind.reason << " (of " << calls << "): " << wrong;
          if (all)
          {
            std::cout << "wrong: " << this->Of.name << " " << how.str() << std::endl;
          }
          this->Found.emplace(kind.name + (once ? " once: " : " on: ") + wrong, how.str());
        }
      };
      const bool waits = this->Of.recovers && !once; // it waits a second before it gives up
      if ((all && !waits) || calls <= sample)
      {
        for (std::uint64_t call = 1; call <= calls; ++call)
        {
          step(call);
        }
      }
      else
      {
        for (std::uint64_t i = 0; i < sample; ++i)
        {
          step(1 + random() % calls);
        }
      }
    }
    if (all)
    {
      std::cout << this->Of.name << ": " << kind.name << "/" << kind.reason << ": " << calls
                << " calls, " << this->Runs - before << " runs" << std::endl;
    }
  }
  std::cout << this->Of.name << ": " << this->Runs << " runs, " << this->Done << " done, "
            << this->Failed << " failed, " << this->Left
            << " left something that the next run removed, " << this->Wrong << " wrong"
            << std::endl;
  for (const auto& [wrong, how] : this->Found)
  {
    ADD_FAILURE() << this->Of.name << " " << how;
  }
}

// CLI11 copies strings in functions that are noexcept.
TEST(TestFaultsAtEveryStep, WithoutMemoryForTheCommandLineAProgramSaysSo)
{
  const Operation& operation = fixtures::OperationOf("verify");
  const fixtures::TemporaryFolder folder;
  fixtures::WriteTree(folder.Path, operation.before);
  FaultyProgram program{ fixtures::faultLibrary, folder.Path,
    fixtures::ProgramPath(operation.program), operation.arguments };
  constexpr std::uint64_t ofCommandLine = 400;
  for (std::uint64_t call = 1; call <= ofCommandLine; ++call)
  {
    program.What().Clear();
    program.What().allocation.Fail(ENOMEM, call, ~std::uint64_t{ 0 });
    const auto outcome = program.Run();
    EXPECT_EQ(outcome.exitCode, 1) << "from allocation " << call << " on: " << outcome.err;
    EXPECT_NE(outcome.err.find("out of memory"), std::string::npos) << outcome.err;
  }
}

INSTANTIATE_TEST_SUITE_P(All, AtEveryStep, testing::ValuesIn(fixtures::operationNames),
  [](const auto& tested) { return std::string(tested.param); });
