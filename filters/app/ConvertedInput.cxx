// SPDX-License-Identifier: BSD-3-Clause
// Steps:
// 1. Make a folder for the PLY.
// 2. Start kdstream-convert, with its stderr as a pipe.
// 3. Read the pipe until it ends: progress, warnings, the error.
// 4. Find out how the process ended.
#include "filters/app/ConvertedInput.h"

#include "filters/files/Folders.h"
#include "filters/meshio/FileEnding.h"
#include "filters/meshio/MeshReader.h"
#include "filters/program/ChildProgram.h"

#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <optional>
#include <sstream>

namespace kdstream
{
namespace
{

constexpr std::size_t longestLine = 8192; // includes a path
const std::string programName = "kdstream-convert";

bool IsThere(const std::filesystem::path& program)
{
  return ::access(program.c_str(), X_OK) == 0;
}

// needs: libraries besides VTK.
std::string HowToGet(const std::filesystem::path& program, const std::string& needs = "")
{
  return programName + ", which is not at " + program.string() +
         ": build it (cmake --build build/release --target kdstream-convert; it needs VTK" + needs +
         ")";
}

// Without the program the input cannot be read; or, for a cloud that the build can read, no surface
// can be made.
Result<std::filesystem::path> FindProgram(const std::filesystem::path& input)
{
  const std::filesystem::path program = ChildProgram::Beside(programName);
  if (!IsThere(program))
  {
    return Error{ ErrorCode::Unsupported,
      NeedsConversion(input)
        ? "reading this format needs " + HowToGet(program) + ", or convert the file to .ply"
        : "--reconstruct needs " + HowToGet(program, " and PCL") };
  }
  return program;
}

// Receives lines from the process.
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
  std::vector<std::filesystem::path> named;
  std::optional<BakeReport> baked;
  Tolerance tolerance;
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
    else if (this->Line.rfind(convertNamedMark, 0) == 0)
    {
      this->named.emplace_back(this->Line.substr(convertNamedMark.size()));
    }
    else if (this->Line.rfind(convertTexturesMark, 0) == 0)
    {
      BakeReport reported;
      std::istringstream(this->Line.substr(convertTexturesMark.size())) >> reported.pictures >>
        reported.texels >> reported.texelsPerVertex >> reported.loss;
      this->baked = reported;
    }
    else
    {
      this->tolerance.Add(Tolerance::FromLines(this->Line));
    }
  }

  // reported: such as "0.25 surface".
  void UnderstandProgress(const std::string& reported)
  {
    char* rest = nullptr;
    this->fraction = std::strtod(reported.c_str(), &rest);
    const std::string name = *rest == ' ' ? rest + 1 : "";
    this->step = name.empty() || name == "read" ? "convert" : name;
  }

  std::string Input, Line;
};

// Reads messages from the process until it closes the pipe. Errors: Cancelled.
Status Listen(ChildProgram& child, Messages& messages, const Execution& execution)
{
  std::string text;
  for (bool more = true; more;)
  {
    KDSTREAM_TRY(execution.Report(messages.step, messages.fraction));
    more = child.Read(text);
    messages.Add(text);
    text.clear();
  }
  messages.Finish();
  return {};
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
  return Error{ ErrorCode::InvalidInput, programName + ", which reads this file, " + how };
}

Result<Mesh> ReadWhole(const std::filesystem::path& file, const Execution& execution)
{
  const Result<std::unique_ptr<MeshReader>> reader = MeshReader::Open(file, execution);
  KDSTREAM_TRY(reader);
  Mesh mesh;
  KDSTREAM_TRY((*reader)->ReadRest(mesh, execution));
  return mesh;
}

}

std::optional<std::string> WhyNoPictures(std::string_view what)
{
  const std::filesystem::path program = ChildProgram::Beside(programName);
  return IsThere(program) ? std::nullopt
                          : std::optional("its " + std::string(what) +
                                          " are left out: reading them needs " + HowToGet(program));
}

bool NeedsConversion(const std::filesystem::path& input)
{
  return IsConvertedFormat(FileEnding(input));
}

Result<ConvertedInput> ConvertedInput::Make(const std::string& input,
  const std::filesystem::path& folder, const std::vector<std::string>& arguments, bool keepTextures,
  const Execution& execution)
{
  const Result<std::filesystem::path> program = FindProgram(input);
  KDSTREAM_TRY(program);
  RemoveDeadFolders(folder);
  Result<LockedFolder> made = MakeLockedFolder(folder);
  KDSTREAM_TRY(made);
  ConvertedInput converted{ std::move(*made), input };
  std::vector<std::string> all = arguments;
  if (keepTextures)
  {
    all.push_back("--paint=" + converted.TextureFolderPath().string());
  }
  // As a single argument, because a folder may begin with a hyphen.
  all.insert(
    all.end(), { "--progress-lines", "--output=" + converted.File().string(), "--", input });
  Result<ChildProgram> child = ChildProgram::Start(*program, all);
  KDSTREAM_TRY(child);
  Messages messages(input);
  KDSTREAM_TRY(Listen(*child, messages, execution));
  const int ended = child->Wait();
  // Ctrl-C in the terminal interrupts both processes.
  KDSTREAM_TRY(execution.Report(messages.step, messages.fraction));
  KDSTREAM_TRY(EndOf(ended, messages));
  converted.WarningTexts = std::move(messages.warnings);
  converted.NamedFiles = std::move(messages.named);
  converted.BakedTextures = messages.baked;
  converted.Forgiven = std::move(messages.tolerance);
  return converted;
}

ConvertedInput::ConvertedInput(LockedFolder folder, std::string input)
  : Folder(std::move(folder))
  , Input(std::move(input))
{
}

ConvertedInput::ConvertedInput(ConvertedInput&& other) noexcept
  : Folder(std::exchange(other.Folder, {}))
  , Input(std::move(other.Input))
  , WarningTexts(std::move(other.WarningTexts))
  , NamedFiles(std::move(other.NamedFiles))
  , BakedTextures(std::move(other.BakedTextures))
  , Forgiven(std::move(other.Forgiven))
{
}

Error ConvertedInput::Blame(Error error) const
{
  error.file = error.file == this->File() ? this->Input : error.file;
  return error;
}

ConvertedInput::~ConvertedInput()
{
  if (!this->Folder.path.empty())
  {
    RemoveTree(this->Folder.path);
  }
}

Result<Mesh> ReadAnyMesh(const std::string& file, const Execution& execution)
{
  if (!NeedsConversion(file))
  {
    return ReadWhole(file, execution);
  }
  const Result<ConvertedInput> converted =
    ConvertedInput::Make(file, std::filesystem::temp_directory_path(), {}, false, execution);
  KDSTREAM_TRY(converted);
  Result<Mesh> mesh = ReadWhole(converted->File(), execution);
  return mesh ? std::move(mesh) : Result<Mesh>(converted->Blame(mesh.GetError()));
}

}
