// SPDX-License-Identifier: BSD-3-Clause
// Steps: 1. a folder for the PLY  2. start kdstream-convert, its stderr a pipe  3. read that until
// it ends: progress, warnings, the error  4. how it ended.
#include "filters/app/ConvertedInput.h"

#include "filters/core/SystemReason.h"
#include "filters/meshio/FileEnding.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <optional>
#include <thread>

namespace kdstream
{
namespace
{

using namespace std::chrono_literals;

constexpr auto patience = 2s;         // between asking the process to end and ending it
constexpr int pollMilliseconds = 100; // between two looks for an interrupt
constexpr std::size_t longestLine = 4096;
const std::string programName = "kdstream-convert";

// Without it the input cannot be read, or a cloud that the build reads itself gets no surface.
Result<std::filesystem::path> FindProgram(const std::filesystem::path& input)
{
  std::error_code status;
  const std::filesystem::path self = std::filesystem::read_symlink("/proc/self/exe", status);
  const std::filesystem::path program = self.parent_path() / programName;
  if (status || ::access(program.c_str(), X_OK) != 0)
  {
    const bool foreign = NeedsConversion(input);
    return Error{ ErrorCode::Unsupported,
      (foreign ? "this format is read by " : "--reconstruct needs ") + programName +
        ", which is not there (it was looked for at " + program.string() +
        "): build it (cmake --build build/release --target kdstream-convert; it needs VTK" +
        (foreign ? "), or convert the file to .ply" : " and PCL)") };
  }
  return program;
}

// The process and the end of a pipe on which its stderr comes.
struct Child
{
  pid_t process = -1;
  int messages = -1;
};

Result<Child> Start(const std::filesystem::path& program, const std::vector<std::string>& arguments)
{
  std::array<int, 2> ends{};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0)
  {
    return Error{ ErrorCode::LimitExceeded,
      "cannot start " + programName + ": " + SystemReason(errno) };
  }
  std::vector<char*> argv{ const_cast<char*>(program.c_str()) };
  for (const std::string& argument : arguments)
  {
    argv.push_back(const_cast<char*>(argument.c_str()));
  }
  argv.push_back(nullptr);
  const pid_t parent = ::getpid();
  const pid_t process = ::fork();
  if (process == 0)
  {
    // It does not outlive the build, however that ends.
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    const int nothing = ::open("/dev/null", O_RDWR);
    ::dup2(nothing, STDIN_FILENO);
    ::dup2(nothing, STDOUT_FILENO);
    ::dup2(ends[1], STDERR_FILENO);
    if (::getppid() == parent)
    {
      ::execv(program.c_str(), argv.data());
    }
    ::_exit(127);
  }
  const Error failed{ ErrorCode::LimitExceeded,
    "cannot start " + programName + ": " + SystemReason(errno) };
  ::close(ends[1]);
  if (process < 0)
  {
    ::close(ends[0]);
    return failed;
  }
  return Child{ process, ends[0] };
}

// The process' lines as they come.
class Messages
{
public:
  explicit Messages(std::string input)
    : Input(std::move(input))
  {
  }

  void Add(std::string_view bytes)
  {
    for (const char c : bytes)
    {
      if (c == '\n')
      {
        this->Understand();
        this->Line.clear();
      }
      else if (this->Line.size() < longestLine)
      {
        this->Line += c;
      }
    }
  }
  void Finish() { this->Add("\n"); }

  std::string step = "convert";
  double fraction = 0;
  std::vector<std::string> warnings;
  std::optional<Error> error;

private:
  void Understand()
  {
    const std::string warning = programName + ": warning: " + this->Input + ": ";
    const std::string failure = programName + ": error: ";
    const std::string ofInput = failure + this->Input + ": ";
    if (this->Line.rfind(warning, 0) == 0)
    {
      this->warnings.push_back(this->Line.substr(warning.size()));
    }
    else if (this->Line.rfind(ofInput, 0) == 0)
    {
      this->error = Error{ ErrorCode::InvalidInput, this->Line.substr(ofInput.size()) };
    }
    else if (this->Line.rfind(failure, 0) == 0)
    {
      const std::string rest = this->Line.substr(failure.size());
      const std::size_t colon = rest.find(": ");
      this->error = colon == std::string::npos ? Error{ ErrorCode::InputOutput, rest }
                                               : Error{ ErrorCode::InputOutput,
                                                   rest.substr(colon + 2), rest.substr(0, colon) };
    }
    else if (this->Line.rfind(convertProgressMark, 0) == 0)
    {
      this->UnderstandProgress(this->Line.substr(convertProgressMark.size()));
    }
  }

  // "0.25 surface"
  void UnderstandProgress(const std::string& told)
  {
    char* rest = nullptr;
    this->fraction = std::strtod(told.c_str(), &rest);
    const std::string name = *rest == ' ' ? rest + 1 : "";
    this->step = name.empty() || name == "read" ? "convert" : name;
  }

  std::string Input, Line;
};

// Reads the process' messages until it closes them. Errors: Cancelled.
Status Listen(const Child& child, Messages& messages, const Execution& execution)
{
  for (;;)
  {
    KDSTREAM_TRY(execution.Report(messages.step, messages.fraction));
    pollfd waiting{ child.messages, POLLIN, 0 };
    if (::poll(&waiting, 1, pollMilliseconds) <= 0)
    {
      continue;
    }
    std::array<char, 4096> bytes;
    const ssize_t got = ::read(child.messages, bytes.data(), bytes.size());
    if (got > 0)
    {
      messages.Add({ bytes.data(), static_cast<std::size_t>(got) });
    }
    else if (got == 0 || errno != EINTR)
    {
      messages.Finish();
      return {};
    }
  }
}

// Waits until the process is gone; ends it if it is to stop. Returns how it ended, as waitpid does.
int Await(pid_t process, bool stop)
{
  int status = 0;
  if (stop)
  {
    ::kill(process, SIGTERM);
    const auto last = std::chrono::steady_clock::now() + patience;
    while (::waitpid(process, &status, WNOHANG) == 0)
    {
      if (std::chrono::steady_clock::now() > last)
      {
        ::kill(process, SIGKILL);
        break;
      }
      std::this_thread::sleep_for(5ms);
    }
  }
  while (::waitpid(process, &status, 0) < 0 && errno == EINTR)
  {
  }
  return status;
}

Status EndOf(int status, const Messages& messages)
{
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0)
  {
    return {};
  }
  if (messages.error)
  {
    return *messages.error;
  }
  const std::string how = WIFSIGNALED(status)
                            ? "was ended by signal " + std::to_string(WTERMSIG(status))
                            : "ended with exit code " + std::to_string(WEXITSTATUS(status));
  return Error{ ErrorCode::InvalidInput, programName + ", which was to read it, " + how };
}

}

bool NeedsConversion(const std::filesystem::path& input)
{
  static constexpr std::array<const char*, 7> endings{ ".vtp", ".vtk", ".wrl", ".glb", ".gltf",
    ".pcd", ".xyz" };
  return std::find(endings.begin(), endings.end(), FileEnding(input)) != endings.end();
}

Result<ConvertedInput> ConvertedInput::Make(const std::string& input,
  const std::filesystem::path& folder, const std::vector<std::string>& arguments,
  const Execution& execution)
{
  const Result<std::filesystem::path> program = FindProgram(input);
  KDSTREAM_TRY(program);
  std::string name = (folder / ".kdstream-convert-XXXXXX").string();
  if (!::mkdtemp(name.data()))
  {
    return Error{ ErrorCode::InputOutput, "cannot create a folder in it: " + SystemReason(errno),
      folder.string() };
  }
  ConvertedInput converted{ std::filesystem::path(name), input };
  std::vector<std::string> all = arguments;
  // In one word: a folder may begin with a hyphen.
  all.insert(
    all.end(), { "--progress-lines", "--output=" + converted.File().string(), "--", input });
  const Result<Child> child = Start(*program, all);
  KDSTREAM_TRY(child);
  Messages messages(input);
  const Status heard = Listen(*child, messages, execution);
  ::close(child->messages);
  const int ended = Await(child->process, !heard);
  KDSTREAM_TRY(heard);
  // An interrupt at the terminal reaches both processes.
  KDSTREAM_TRY(execution.Report(messages.step, messages.fraction));
  KDSTREAM_TRY(EndOf(ended, messages));
  converted.WarningTexts = std::move(messages.warnings);
  return converted;
}

ConvertedInput::ConvertedInput(std::filesystem::path folder, std::string input)
  : Folder(std::move(folder))
  , Input(std::move(input))
{
}

ConvertedInput::ConvertedInput(ConvertedInput&& other) noexcept
  : Folder(std::exchange(other.Folder, {}))
  , Input(std::move(other.Input))
  , WarningTexts(std::move(other.WarningTexts))
{
}

Error ConvertedInput::Blame(Error error) const
{
  error.file = error.file == this->File() ? this->Input : error.file;
  return error;
}

ConvertedInput::~ConvertedInput()
{
  if (!this->Folder.empty())
  {
    std::error_code ignored;
    std::filesystem::remove_all(this->Folder, ignored);
  }
}

}
