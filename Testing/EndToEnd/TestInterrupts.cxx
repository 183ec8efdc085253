// SPDX-License-Identifier: BSD-3-Clause
// Programs that are ended by a signal say so, and leave no files
// (doc/cli.md#interrupts-and-outputs).
#include "Testing/EndToEnd/ProgramsTest.h"
#include "Testing/Fixtures/Meshes.h"

#include <chrono>
#include <csignal>
#include <thread>

using namespace kdstream;
using namespace kdstream::fixtures;

namespace
{

class Interrupts : public ProgramsTest
{
protected:
  // Runs kdstream-NAME repeatedly, and sends a signal after longer and longer times, until the
  // program ends first. Expects that it ends itself with `line`, and leaves no new files except
  // `made` if it succeeds.
  void ExpectNothingLeft(const std::string& name, std::vector<std::string> arguments,
    const std::string& line, const std::set<std::string>& made)
  {
    const std::set<std::string> before = this->Files();
    const std::string program = std::string(KDSTREAM_PROGRAMS) + "/kdstream-" + name;
    arguments.insert(arguments.begin(), program);
    std::vector<char*> argv;
    for (std::string& argument : arguments)
    {
      argv.push_back(argument.data());
    }
    argv.push_back(nullptr);
    unsigned said = 0;
    for (const int signal : { SIGINT, SIGTERM, SIGHUP })
    {
      bool isQuicker = false;
      for (unsigned milliseconds = 4; !isQuicker; milliseconds += milliseconds / 2)
      {
        const pid_t child = ::fork();
        if (child == 0)
        {
          if (::chdir(this->Folder.Path.c_str()) == 0 && std::freopen("said", "w", stderr) &&
              std::freopen("/dev/null", "w", stdout))
          {
            ::execv(program.c_str(), argv.data());
          }
          ::_exit(127);
        }
        std::this_thread::sleep_for(std::chrono::milliseconds(milliseconds));
        ::kill(child, signal);
        int status = 0;
        ::waitpid(child, &status, 0);
        isQuicker = WIFEXITED(status) && WEXITSTATUS(status) == 0;
        if (WIFEXITED(status) && !isQuicker)
        {
          EXPECT_EQ(WEXITSTATUS(status), 1);
          EXPECT_EQ(ReadWhole(this->Folder / "said"), line) << "after " << milliseconds << " ms";
          ++said;
        }
        std::filesystem::remove(this->Folder / "said");
        for (const std::string& file : made)
        {
          EXPECT_EQ(std::filesystem::remove_all(this->Folder / file) > 0, isQuicker) << file;
        }
        // If the signal came before the program catches signals, nothing has been made yet.
        EXPECT_EQ(this->Files(), before) << "after " << milliseconds << " ms";
      }
    }
    EXPECT_GT(said, 0U);
  }
};

}

TEST_F(Interrupts, OfTheStoresCommands)
{
  this->Write("in.ply", DisplacedSphere(7));
  ASSERT_EQ(this->Build({ "in.ply", "-o", "m.kds", "--quiet" }).exitCode, 0);
  this->ExpectNothingLeft("store", { "extract", "m.kds", "--all", "-o", "new/x.obj", "--quiet" },
    "kdstream-store: error: interrupted: new/x.obj is not written\n", { "new" });
  this->ExpectNothingLeft("store", { "extract", "m.kds", "--all", "-o", "x.glb", "--quiet" },
    "kdstream-store: error: interrupted: x.glb is not written\n", { "x.glb" });
  this->ExpectNothingLeft("store", { "export", "m.kds", "y.glb", "--format", "glb", "--quiet" },
    "kdstream-store: error: interrupted: y.glb is not written\n", { "y.glb" });
  this->ExpectNothingLeft(
    "store", { "verify", "m.kds" }, "kdstream-store: error: interrupted\n", {});
}

TEST_F(Interrupts, OfTheConverter)
{
  if (!std::filesystem::exists(std::string(KDSTREAM_PROGRAMS) + "/kdstream-convert"))
  {
    GTEST_SKIP() << "without VTK";
  }
  this->Write("in.vtp", DisplacedSphere(8));
  for (const std::string file : { "x.wrl", "x.obj" })
  {
    this->ExpectNothingLeft("convert", { "in.vtp", "-o", "new/" + file, "--quiet" },
      "kdstream-convert: error: interrupted: new/" + file + " is not written\n", { "new" });
  }
}

TEST_F(Interrupts, WhatKilledProgramsHaveLeftIsRemoved)
{
  this->Write("in.ply", Torus(40, 20));
  ASSERT_EQ(this->Build({ "in.ply", "-o", "m.kds", "--quiet" }).exitCode, 0);
  for (const std::string file : { "x.obj", "x.glb" })
  {
    this->WriteText("." + file + ".abcdef.unfinished", "v 0 0 0");
    ASSERT_EQ(this->Store({ "extract", "m.kds", "--all", "-o", file }).exitCode, 0);
  }
  this->WriteText(".y.glb.abcdef.unfinished", "glTF");
  ASSERT_EQ(this->Store({ "export", "m.kds", "y.glb", "--format", "glb" }).exitCode, 0);
  EXPECT_EQ(this->Files(), (std::set<std::string>{ "in.ply", "m.kds", "x.glb", "x.obj", "y.glb" }));
}
