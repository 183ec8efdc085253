// SPDX-License-Identifier: BSD-3-Clause
#include "filters/program/Program.h"

#include "filters/core/CaughtError.h"
#include "filters/core/SystemReason.h"
#include "filters/core/Texts.h"
#include "filters/files/WriteWhole.h"
#include "filters/program/HelpFormatter.h"
#include "filters/program/UsageMessage.h"
#include "kdstream/Version.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <iostream>
#include <new>

namespace kdstream
{
namespace
{

constexpr const char* optionsHint = " (see --help)";

std::atomic<bool> interrupted{ false };

extern "C" void OnInterrupt(int signal)
{
  interrupted = true;
  std::signal(signal, SIG_DFL); // a second signal ends the process
}

// The line that EndAtInterrupts prints. It is prepared in advance, because a signal handler may do
// very little.
std::array<char, 8192> interruptLine{};
std::size_t interruptLength = 0;

extern "C" void EndAtInterrupt(int)
{
  [[maybe_unused]] const auto written =
    ::write(STDERR_FILENO, interruptLine.data(), interruptLength);
  ::_exit(exitFailed);
}

// Ends the program with an error message if memory ran out in a function that is noexcept, which
// would abort it: CLI11 copies strings in such functions.
[[noreturn]] void EndWithoutMemory();
const std::terminate_handler otherwise = std::set_terminate(&EndWithoutMemory);

[[noreturn]] void EndWithoutMemory()
{
  if (std::current_exception())
  {
    try
    {
      throw;
    }
    catch (const std::bad_alloc&)
    {
      for (const std::string_view part : { std::string_view(program_invocation_short_name),
             std::string_view(": error: out of memory\n") })
      {
        [[maybe_unused]] const auto written = ::write(STDERR_FILENO, part.data(), part.size());
      }
      ::_exit(exitFailed);
    }
    catch (...)
    {
    }
  }
  otherwise();
  std::abort();
}

std::string InterruptLine(std::string_view program, const std::string& output)
{
  return std::string(program) + ": error: interrupted" +
         (output.empty() ? "" : ": " + output + " is not written") + "\n";
}

// Whether the file begins like a store: an SQLite database of the application "KDS1"
// (doc/formats.md).
bool IsStore(const std::filesystem::path& file)
{
  constexpr std::size_t applicationBegin = 68, applicationSize = 4;
  std::string bytes(applicationBegin + applicationSize, ' ');
  std::ifstream stream(file, std::ios::binary);
  return stream.read(bytes.data(), std::streamsize(bytes.size())) && bytes.starts_with("SQLite") &&
         bytes.substr(applicationBegin) == "KDS1";
}

}

Result<bool> ParseCommandLine(CLI::App& app, int argc, char** argv)
{
  SetUpHelp(app, KDSTREAM_VERSION);
  try
  {
    app.parse(argc, argv);
  }
  catch (const CLI::Success& success)
  {
    if (const auto unknown = UnknownCommand(app))
    {
      return Error{ ErrorCode::InvalidArgument, *unknown + optionsHint };
    }
    app.exit(success); // prints the help or the version
    return false;
  }
  catch (const CLI::ParseError& error)
  {
    return Error{ ErrorCode::InvalidArgument, UsageMessage(app, error) + optionsHint };
  }
  return true;
}

int RunProgram(CLI::App& app, int argc, char** argv, const std::function<int()>& work)
{
  const Result<bool> wanted = ParseCommandLine(app, argc, argv);
  if (!wanted)
  {
    return PrintError(app.get_name(), "", wanted.GetError());
  }
  try
  {
    return *wanted ? work() : exitDone;
  }
  catch (...)
  {
    return PrintError(app.get_name(), "", CaughtError());
  }
}

namespace
{

const char* AdviceOf(Remedy remedy)
{
  switch (remedy)
  {
    case Remedy::Repair:
      return ": correct the file, or export it again";
    case Remedy::CopyAgain:
      return ": copy the file again, or export it again";
    case Remedy::Rename:
      return ": give the file the ending of its format, or export it again";
    case Remedy::Retry:
      return ": wait until no program writes to it, then try again";
    case Remedy::SaveOtherwise:
      return ": export it in another way, for example as .ply";
    case Remedy::Divide:
      return ": divide it into several files";
    case Remedy::Unknown:
    case Remedy::InMessage:
      break;
  }
  return "";
}

}

int PrintError(
  std::string_view program, const std::string& file, const Error& error, const std::string& output)
{
  if (error.code == ErrorCode::Cancelled) // not the fault of a file
  {
    std::cerr << InterruptLine(program, output);
    return exitFailed;
  }
  const std::string& named = error.file.empty() ? file : error.file;
  std::cerr << program << ": error: " << named << (named.empty() ? "" : ": ") << error.message
            << (error.place.empty() ? "" : ", ") << error.place << AdviceOf(error.remedy) << "\n";
  return error.code == ErrorCode::InvalidArgument ? exitUsage : exitFailed;
}

void PrintWritten(
  std::string_view program, const std::string& file, const std::string& content, double seconds)
{
  std::error_code failed;
  const std::uintmax_t bytes = std::filesystem::file_size(file, failed);
  char time[32] = {};
  std::snprintf(time, sizeof(time), "%.1f s", seconds);
  std::cerr << program << ": wrote " << file << ": " << content << (content.empty() ? "" : ", ")
            << (failed ? "" : BytesText(double(bytes)) + " in ")
            << (seconds < 10 ? time : DurationText(seconds)) << "\n";
}

Result<std::uint64_t> ParseSize(const std::string& text)
{
  const Error bad{ ErrorCode::InvalidArgument,
    "\"" + text + "\" is not a size: give a number and K, M or G, such as 256M or 1.5G" };
  std::size_t end = 0;
  double value = 0;
  try
  {
    value = std::stod(text, &end);
  }
  catch (const std::exception&)
  {
    return bad;
  }
  const std::string unit = text.substr(end);
  const std::string units = "KMG";
  double factor = 1;
  if (unit.size() == 1 && units.find(unit[0]) != std::string::npos)
  {
    factor = double(std::uint64_t{ 1 } << (10 * (units.find(unit[0]) + 1)));
  }
  else if (!unit.empty())
  {
    return bad;
  }
  if (!(value >= 0) || value * factor > 9e18)
  {
    return bad;
  }
  return static_cast<std::uint64_t>(value * factor);
}

CLI::Option* FindOption(const CLI::App& app, const std::string& name)
{
  // The non-const overload returns options that may be changed, as App::get_option does.
  return const_cast<CLI::App&>(app)
    .get_options([&](const CLI::Option* option) { return option->check_name(name); })
    .at(0);
}

CLI::Option* AddSizeOption(
  CLI::App& app, const std::string& name, std::uint64_t& bytes, const std::string& help)
{
  return app
    .add_option_function<std::string>(
      name,
      [&bytes, name](const std::string& text)
      {
        const Result<std::uint64_t> size = ParseSize(text);
        if (!size)
        {
          throw CLI::ValidationError(name, size.GetError().message);
        }
        bytes = *size;
      },
      help)
    ->type_name("SIZE");
}

Result<std::filesystem::path> CheckOutput(
  const std::string& file, OutputKind kind, std::initializer_list<std::string> inputs)
{
  namespace fs = std::filesystem;
  std::error_code status;
  fs::path target = file;
  constexpr unsigned mostLinks = 40; // the limit of the kernel
  if (kind == OutputKind::Stream && NamesDescriptor(target))
  {
    return target;
  }
  for (unsigned i = 0; i < mostLinks && fs::is_symlink(target, status); ++i)
  {
    target = target.parent_path() / fs::read_symlink(target, status);
  }
  // Works also for files that do not exist yet; empty if unknown.
  const auto place = [&](const fs::path& path)
  { return fs::weakly_canonical(fs::absolute(path, status), status); };
  const fs::path there = place(target);
  for (const std::string& input : inputs)
  {
    const bool isSame = !there.empty() && !input.empty() && there == place(input);
    if (isSame || fs::equivalent(target, input, status))
    {
      return Error{ ErrorCode::InvalidArgument,
        "is the same file as the input " + input + ", and would replace it" };
    }
  }
  const bool exists = fs::exists(target, status);
  if (exists && fs::is_directory(target, status))
  {
    return Error{ ErrorCode::InputOutput, "is a folder" };
  }
  if (exists && !fs::is_regular_file(target, status))
  {
    return kind == OutputKind::Stream
             ? Result<fs::path>(target)
             : Error{ ErrorCode::InputOutput, "cannot be written: it is not a regular file" };
  }
  if (exists && kind == OutputKind::Stream && IsStore(target))
  {
    return Error{ ErrorCode::InvalidArgument, "is a store, which would be overwritten" };
  }
  const fs::path folder = target.has_parent_path() ? target.parent_path() : ".";
  if (fs::exists(folder, status) && !fs::is_directory(folder, status))
  {
    return Error{ ErrorCode::InputOutput,
      "cannot be created in " + folder.string() + ", which is a file, not a folder" };
  }
  if (::access(folder.c_str(), W_OK | X_OK) != 0)
  {
    return SystemError("cannot create a file in " + folder.string(), errno);
  }
  return target;
}

CLI::Option* CheckText(CLI::Option* option)
{
  return option->check(
    [](const std::string& text) -> std::string
    {
      if (text.size() > 4096)
      {
        return "is longer than 4096 bytes";
      }
      for (const char c : text)
      {
        if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F)
        {
          return "contains control characters";
        }
      }
      return IsUtf8(text) ? "" : "is not UTF-8";
    },
    "TEXT");
}

void CatchInterrupts()
{
  for (const int signal : { SIGINT, SIGTERM, SIGHUP })
  {
    std::signal(signal, OnInterrupt);
  }
  std::signal(SIGXFSZ, SIG_IGN);
}

void EndAtInterrupts(std::string_view program, const std::string& output)
{
  ReleaseInterrupts();
  // On a terminal, progress may be displayed in the same line.
  const std::string line =
    (::isatty(STDERR_FILENO) == 1 ? "\n" : "") + InterruptLine(program, output);
  interruptLength = std::min(line.size(), interruptLine.size());
  std::copy_n(line.begin(), interruptLength, interruptLine.begin());
  for (const int signal : { SIGINT, SIGTERM, SIGHUP })
  {
    std::signal(signal, EndAtInterrupt);
  }
}

void ReleaseInterrupts()
{
  for (const int signal : { SIGINT, SIGTERM, SIGHUP })
  {
    std::signal(signal, SIG_DFL);
  }
}

bool Interrupted()
{
  return interrupted;
}

Execution UntilInterrupted()
{
  Execution execution;
  execution.progress = [](std::string_view, double) { return !Interrupted(); };
  return execution;
}

}
