#include "filters/program/Program.h"

#include "filters/core/CaughtError.h"
#include "filters/core/SystemReason.h"
#include "filters/core/Texts.h"

#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <fstream>
#include <iostream>

namespace kdstream
{
namespace
{

std::atomic<bool> interrupted{ false };

extern "C" void OnInterrupt(int signal)
{
  interrupted = true;
  std::signal(signal, SIG_DFL); // a second one ends the process
}

}

int RunProgram(CLI::App& app, int argc, char** argv, const std::function<int()>& work)
{
  try
  {
    app.parse(argc, argv);
  }
  catch (const CLI::Success& success)
  {
    app.exit(success); // prints the help or the version
    return exitDone;
  }
  catch (const CLI::ParseError& error)
  {
    std::cerr << app.get_name() << ": error: " << error.what() << " (--help tells the options)\n";
    return exitUsage;
  }
  try
  {
    return work();
  }
  catch (...)
  {
    return PrintError(app.get_name(), "", CaughtError());
  }
}

int PrintError(std::string_view program, const std::string& file, const Error& error)
{
  std::cerr << program << ": error: " << file << (file.empty() ? "" : ": ") << error.message
            << "\n";
  return error.code == ErrorCode::InvalidArgument ? exitUsage : exitFailed;
}

Result<std::uint64_t> ParseSize(const std::string& text)
{
  const Error bad{ ErrorCode::InvalidArgument,
    "\"" + text + "\" is no size; examples: 4096, 256M, 1.5G" };
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

std::uint64_t FreeMemory()
{
  std::uint64_t free = std::uint64_t{ 1 } << 62;
  std::ifstream machine("/proc/meminfo");
  for (std::string key, unit; machine >> key;)
  {
    std::uint64_t kibibytes = 0;
    machine >> kibibytes;
    std::getline(machine, unit);
    if (key == "MemAvailable:")
    {
      free = kibibytes << 10;
    }
  }
  std::uint64_t limit = 0, used = 0;
  std::ifstream groupLimit("/sys/fs/cgroup/memory.max"), groupUse("/sys/fs/cgroup/memory.current");
  if (groupLimit >> limit && groupUse >> used && limit > used)
  {
    free = std::min(free, limit - used);
  }
  return free;
}

Result<std::filesystem::path> CheckOutput(
  const std::string& file, OutputKind kind, std::initializer_list<std::string> inputs)
{
  namespace fs = std::filesystem;
  std::error_code status;
  fs::path target = file;
  constexpr unsigned mostLinks = 40; // as the kernel allows
  for (unsigned i = 0; i < mostLinks && fs::is_symlink(target, status); ++i)
  {
    target = target.parent_path() / fs::read_symlink(target, status);
  }
  for (const std::string& input : inputs)
  {
    if (fs::equivalent(target, input, status))
    {
      return Error{ ErrorCode::InvalidArgument, "is " + input + " itself, which would be lost" };
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
  const fs::path folder = target.has_parent_path() ? target.parent_path() : ".";
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
          return "has control characters";
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

ProgressReporter::ProgressReporter(
  std::string_view program, bool quiet, std::vector<StepShare> shares)
  : Program(program)
  , Quiet(quiet)
  , Terminal(::isatty(STDERR_FILENO) == 1)
  , Estimate(std::move(shares))
  , Begin(std::chrono::steady_clock::now())
  , LastShown(this->Begin)
{
}

ProgressReporter::~ProgressReporter()
{
  if (this->LineOpen)
  {
    std::fputc('\n', stderr);
  }
}

bool ProgressReporter::operator()(std::string_view step, double fraction)
{
  const auto now = std::chrono::steady_clock::now();
  const double done = std::clamp(fraction, 0.0, 1.0);
  this->Estimate.Add(step, done, std::chrono::duration<double>(now - this->Begin).count());
  const double pause = this->Terminal ? 0.1 : 3.0;
  // A line that says that a step has just ended tells nothing of what is to come.
  const bool worthALine = this->Terminal || done < 1;
  if (!this->Quiet && worthALine &&
      std::chrono::duration<double>(now - this->LastShown).count() >= pause)
  {
    this->LastShown = now;
    this->Show(step, done);
  }
  return !Interrupted();
}

void ProgressReporter::Show(std::string_view step, double fraction)
{
  const std::string name(step);
  std::string told;
  const auto append = [&](const char* separator, const char* format, double value)
  {
    char text[64] = {};
    std::snprintf(text, sizeof(text), format, value);
    told += separator;
    told += text;
  };
  const char* separator = this->Terminal ? "  " : ", ";
  if (const std::optional<double> rate = this->Estimate.Rate())
  {
    append(separator, "%.1f %%/s", 100 * *rate);
  }
  if (const std::optional<ProgressEstimate::Time> left = this->Estimate.Left())
  {
    append(separator, "about %.0f s left", std::max(1.0, std::ceil(left->seconds)));
    told += left->whole ? " in all" : " of " + name;
  }
  if (!this->Terminal)
  {
    std::fprintf(stderr, "%s: %s %.0f %%%s\n", this->Program.c_str(), name.c_str(), 100 * fraction,
      told.c_str());
    return;
  }
  constexpr int width = 30;
  const int done = static_cast<int>(fraction * width);
  std::fprintf(stderr, "\r\033[K%-8s [%.*s%*s] %3.0f %%%s", name.c_str(), done,
    "##############################", width - done, "", 100 * fraction, told.c_str());
  this->LineOpen = true;
}

}
