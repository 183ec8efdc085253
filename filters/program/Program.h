// SPDX-License-Identifier: BSD-3-Clause
// Shared by all kdstream programs: the command line, exit codes, the error line, sizes, outputs,
// Ctrl-C (doc/cli.md#all-programs).
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

// Parses the command line and calls `work`, which returns an exit code. Adds --version, and sets up
// --help (HelpFormatter.h); both end with 0. Wrong usage ends with 2 and a line that says what is
// wrong (UsageMessage.h). An exception from `work`, such as lack of memory, is handled like other
// errors.
int RunProgram(CLI::App& app, int argc, char** argv, const std::function<int()>& work);

// The first half of RunProgram. Returns whether there is work to do: false after the help or the
// version was printed. Errors: InvalidArgument for wrong usage.
Result<bool> ParseCommandLine(CLI::App& app, int argc, char** argv);

// Prints `program: error: FILE: what, where: what to do` on stderr. Returns the exit code for the
// error: wrong usage for InvalidArgument, failed work for everything else. FILE is the file in the
// error; if it has none, `file`, which may be empty. For an interruption (Cancelled) the line names
// no input file, and says that `output`, if there is one, was not written.
int PrintError(std::string_view program, const std::string& file, const Error& error,
  const std::string& output = {});

// Prints on stderr the last line of a program that has made a file: "kdstream-build: wrote m.kds:
// 14 MB in 3.4 s". With `content`, which may be empty, before the size: "kdstream-store: wrote
// m.ply: 4096 triangles, 80 kB in 0.1 s".
void PrintWritten(
  std::string_view program, const std::string& file, const std::string& content, double seconds);

// Parses "256M", "1.5G" (binary units), or a number of bytes.
Result<std::uint64_t> ParseSize(const std::string& text);
// The option with this name, which must exist. CLI11's own search (also App::count) is noexcept and
// copies names: if memory ran out there, a signal would kill the program.
CLI::Option* FindOption(const CLI::App& app, const std::string& name);
// Adds an option of this form, which is checked while parsing.
CLI::Option* AddSizeOption(
  CLI::App& app, const std::string& name, std::uint64_t& bytes, const std::string& help);

enum class OutputKind
{
  File,  // a regular file, new or replaced
  Stream // also a terminal, a pipe, /dev/stdout; not an existing store
};

// The file that is written: `file`, or the file to which it links. Call it before the work, so that
// no work is wasted. Errors: InvalidArgument if it is one of `inputs`, or an existing store if
// `kind` is Stream; InputOutput for a folder, for something that is not a regular file, and if no
// file can be created.
Result<std::filesystem::path> CheckOutput(
  const std::string& file, OutputKind kind, std::initializer_list<std::string> inputs);

// Checks while parsing that a text can be displayed: at most 4096 bytes of UTF-8 without control
// characters.
CLI::Option* CheckText(CLI::Option* option);

// From now on SIGINT, SIGTERM and SIGHUP set the flag that Interrupted returns; a second signal
// ends the process. Writing to a file that has reached its size limit (SIGXFSZ) becomes an error,
// like a full disk.
void CatchInterrupts();
// From now on these signals end the process at once: with the error line of an interruption
// (`output` as in PrintError) and exitFailed. For work that has nothing to remove yet, and for
// libraries that cannot be stopped.
void EndAtInterrupts(std::string_view program, const std::string& output);
// From now on signals end the process again, without a line.
void ReleaseInterrupts();
bool Interrupted();
// Serial, without progress; cancelled once the process is interrupted.
Execution UntilInterrupted();

}
