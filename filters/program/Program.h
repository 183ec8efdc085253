// SPDX-License-Identifier: BSD-3-Clause
// What every kdstream program does alike: the command line, exit codes, the error line, sizes,
// outputs, Ctrl-C (doc/cli.md#all-programs).
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/Result.h"
#include "filters/program/ProgressReporter.h"

#include <CLI/CLI.hpp>

#include <cstdint>
#include <filesystem>
#include <functional>
#include <initializer_list>
#include <string>
#include <string_view>

namespace kdstream
{

inline constexpr int exitDone = 0;
inline constexpr int exitFailed = 1;
inline constexpr int exitUsage = 2;

// Parses the command line and calls `work`, which returns an exit code. Adds --version and gives
// --help its form (HelpFormatter.h); both end with 0, wrong usage with 2 and a line that says what
// is wrong with it (UsageMessage.h). An exception out of `work` is an error like others, memory
// that runs out among them.
int RunProgram(CLI::App& app, int argc, char** argv, const std::function<int()>& work);

// Its first half: whether there is work to do; false once the help or the version was printed.
// Errors: InvalidArgument for wrong usage.
Result<bool> ParseCommandLine(CLI::App& app, int argc, char** argv);

// Prints `program: error: FILE: what, where: what to do` on stderr; returns the exit code that goes
// with the error: wrong usage for an InvalidArgument, failed work for everything else. FILE is the
// one that the error names, else `file`, which may be empty. Work that was interrupted (Cancelled)
// says so, blames no file, and names `output`, if there is one, as not written.
int PrintError(std::string_view program, const std::string& file, const Error& error,
  const std::string& output = {});

// The last line of a program that has made a file, on stderr:
// "kdstream-build: wrote m.kds: 14 MB in 3.4 s"; with `content`, which may be empty, before the
// size: "kdstream-store: wrote m.ply: 4096 triangles, 80 kB in 0.1 s".
void PrintWritten(
  std::string_view program, const std::string& file, const std::string& content, double seconds);

// "256M", "1.5G" (binary units), or a number of bytes.
Result<std::uint64_t> ParseSize(const std::string& text);
// The option of that name, which is there. CLI11's own search (also App::count) is noexcept and
// copies names: where memory runs out in it the program ends by a signal.
CLI::Option* FindOption(const CLI::App& app, const std::string& name);
// An option of that form, checked while parsing.
CLI::Option* AddSizeOption(
  CLI::App& app, const std::string& name, std::uint64_t& bytes, const std::string& help);

enum class OutputKind
{
  File,  // a regular file, new or replaced
  Stream // also a terminal, a pipe, /dev/stdout; no store that is there
};

// Where an output goes: `file`, or what it links to. Called before the work, so that nothing is
// done in vain. Errors: InvalidArgument where it is one of `inputs`, or a store that is not a place
// for a Stream; InputOutput for a folder, for something that is no regular file, and where no file
// can be created.
Result<std::filesystem::path> CheckOutput(
  const std::string& file, OutputKind kind, std::initializer_list<std::string> inputs);

// Checks while parsing that a text can be shown: at most 4096 bytes of UTF-8 without control
// characters.
CLI::Option* CheckText(CLI::Option* option);

// From now on SIGINT, SIGTERM and SIGHUP set the flag that Interrupted tells, once; a second one
// ends the process. A file that may not grow any more
// (SIGXFSZ) is an error of writing, like a full disk.
void CatchInterrupts();
// Signals end the process again.
void ReleaseInterrupts();
bool Interrupted();

}
