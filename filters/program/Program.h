// What every kdstream program does alike: exit codes, the error line, sizes, Ctrl-C, progress
// (doc/cli.md#all-programs).
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/Result.h"
#include "filters/program/ProgressEstimate.h"

#include <CLI/CLI.hpp>

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

namespace kdstream
{

inline constexpr int exitDone = 0;
inline constexpr int exitFailed = 1;
inline constexpr int exitUsage = 2;

// Parses the command line and calls `work`, which returns an exit code. --help and --version end
// with 0, wrong usage with 2. An exception out of `work` is an error like others, memory that runs
// out among them.
int RunProgram(CLI::App& app, int argc, char** argv, const std::function<int()>& work);

// Prints `program: error: FILE: what, where` on stderr; returns the exit code that goes with the
// error: wrong usage for an InvalidArgument, failed work for everything else. `file` may be empty.
int PrintError(std::string_view program, const std::string& file, const Error& error);

// "256M", "1.5G", "4096" (binary units) as bytes.
Result<std::uint64_t> ParseSize(const std::string& text);
// An option of that form, checked while parsing.
CLI::Option* AddSizeOption(
  CLI::App& app, const std::string& name, std::uint64_t& bytes, const std::string& help);

// Memory that is free now, in bytes: the smaller of what the machine and the control group have.
std::uint64_t FreeMemory();

enum class OutputKind
{
  File,  // a regular file, new or replaced
  Stream // also a terminal, a pipe, /dev/stdout
};

// Where an output goes: `file`, or what it links to. Called before the work, so that nothing is
// done in vain. Errors: InvalidArgument where it is one of `inputs`; InputOutput for a folder, for
// something that is no regular file, and where no file can be created.
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

// Progress on stderr: a bar on a terminal, a line every few seconds otherwise, nothing if quiet;
// with the rate of the step and the time left of all steps whose shares are known, or of the step,
// once they can be told (ProgressEstimate.h). Returns false, which cancels the work, once the
// process is interrupted.
class ProgressReporter
{
public:
  explicit ProgressReporter(
    std::string_view program, bool quiet, std::vector<StepShare> shares = {});
  ~ProgressReporter();
  ProgressReporter(const ProgressReporter&) = delete;
  ProgressReporter& operator=(const ProgressReporter&) = delete;

  bool operator()(std::string_view step, double fraction);

private:
  void Show(std::string_view step, double fraction);

  std::string Program;
  bool Quiet, Terminal;
  ProgressEstimate Estimate;
  std::chrono::steady_clock::time_point Begin, LastShown;
  bool LineOpen = false;
};

}
