// SPDX-License-Identifier: BSD-3-Clause
// kdstream-convert: converts a mesh or point cloud of another program's format to a PLY that
// kdstream-build reads. It is a process of its own, because VTK and PCL take unbounded memory and
// may crash on hostile input.
#include "filters/app/ConvertedInput.h"
#include "filters/app/OutputFolders.h"
#include "filters/app/ReadingOptions.h"
#include "filters/app/TextureOptions.h"
#include "filters/build/BuildMemory.h"
#include "filters/convert/ForeignMesh.h"
#include "filters/convert/Reconstruct.h"
#include "filters/core/CaughtError.h"
#include "filters/meshio/FileEnding.h"
#include "filters/meshio/MeshWriter.h"
#include "filters/program/Program.h"
#include "filters/program/TbbExecution.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <csignal>
#include <cstring>
#include <fstream>
#include <iostream>
#include <limits>
#include <new>
#include <string_view>

namespace
{

using namespace kdstream;

constexpr const char* description =
  "Reads a whole mesh or point cloud in another program's format and writes it as .ply (or .vtp, "
  ".stl, .obj, .wrl). kdstream-build calls it where needed; its memory is not part of that "
  "program's limit.";

constexpr const char* footer =
  "Formats:\n"
  "  .ply .stl .obj .off\n"
  "                  the same as in kdstream-build\n"
  "  .vtp .vtk       VTK; for a grid, its surface\n"
  "  .wrl .wrz       VRML 2 and 1, if built with Coin; also compressed by gzip\n"
  "  .glb .gltf      the default scene; textures are baked to vertex colours\n"
  "  .json           a tileset of 3D Tiles (tileset.json): its finest tiles\n"
  "  .pcd            PCL point clouds\n"
  "  .las            laser scans; compressed ones (.laz) if built with LASzip\n"
  "  .xyz .txt .csv .pts .asc .xyzrgb .xyzn\n"
  "                  lines of x y z, then any of intensity, r g b, nx ny nz; --columns names the "
  "columns\n\n"
  "Example:\n"
  "  kdstream-convert statue.glb -o statue.ply";

struct CommandLine
{
  std::string input, output, reconstruct, paint, textures = "on";
  std::uint64_t texturePixels = mostPicturePixels;
  unsigned threads = 0;
  std::string columns;
  bool quiet = false, progressLines = false, strict = false;
};

// The line printed if a library's reader crashes. It is prepared in advance, because a signal
// handler may do very little.
std::array<char, 512> crashLine{};
std::size_t crashLength = 0;

extern "C" void OnCrash(int)
{
  [[maybe_unused]] const auto written = ::write(STDERR_FILENO, crashLine.data(), crashLength);
  ::_exit(exitFailed);
}

// With sanitizers neither is set up: their report is better, and they need address space of their
// own.
#if defined(__SANITIZE_ADDRESS__)
constexpr bool sanitized = true;
#elif defined(__has_feature)
constexpr bool sanitized = __has_feature(address_sanitizer);
#else
constexpr bool sanitized = false;
#endif

void CatchCrashes(const std::string& program, const std::string& file)
{
  std::string line = program + ": error: " + file;
  line.resize(std::min(line.size(), crashLine.size() - 100));
  line += ": the file is damaged: the reader of this format crashed: export it again\n";
  std::memcpy(crashLine.data(), line.data(), line.size());
  crashLength = line.size();
  if (sanitized)
  {
    return;
  }
  // A separate stack, because a file can also make a reader call itself endlessly.
  static std::array<char, 1 << 16> stack;
  stack_t alternative{};
  alternative.ss_sp = stack.data();
  alternative.ss_size = stack.size();
  ::sigaltstack(&alternative, nullptr);
  for (const int signal : { SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT })
  {
    struct sigaction action = {};
    action.sa_handler = OnCrash;
    action.sa_flags = static_cast<int>(SA_ONSTACK | SA_RESETHAND);
    ::sigaction(signal, &action, nullptr);
  }
}

// The limit for memory: a file's claims must not exhaust the machine. If a reader needs more than
// this, or more than is free, that is an error.
constexpr std::uint64_t leastMemory = std::uint64_t{ 1 } << 30;
constexpr std::uint64_t memoryPerByte = 100; // of the file: compressed files and pictures grow

void LimitMemory(std::uint64_t most)
{
  if (!sanitized)
  {
    rlimit limit{};
    ::getrlimit(RLIMIT_DATA, &limit);
    limit.rlim_cur = std::min<rlim_t>(std::min(most, FreeMemory()), limit.rlim_max);
    ::setrlimit(RLIMIT_DATA, &limit);
  }
}

// Whether the file contains a word.
bool Holds(const std::filesystem::path& file, std::string_view word)
{
  std::ifstream input(file, std::ios::binary);
  std::string block(1 << 20, ' ');
  for (std::size_t kept = 0; input.good();)
  {
    input.read(block.data() + kept, static_cast<std::streamsize>(block.size() - kept));
    const std::string_view bytes(block.data(), kept + static_cast<std::size_t>(input.gcount()));
    if (bytes.find(word) != std::string_view::npos)
    {
      return true;
    }
    kept = std::min(word.size() - 1, bytes.size());
    std::copy(bytes.end() - static_cast<std::ptrdiff_t>(kept), bytes.end(), block.begin());
  }
  return false;
}

std::uint64_t MostMemory(const std::filesystem::path& input)
{
  std::error_code status;
  const std::uintmax_t bytes = std::filesystem::file_size(input, status);
  // Files without a limit: a .gltf, a tileset, pictures, and VRML with Inline (also in a compressed
  // file), because they refer to other files, whose bytes are not counted; and .obj, .ply and .off,
  // because our own readers do not trust any claim of the file.
  constexpr std::string_view gzipMark = "\x1f\x8b\x08";
  const std::string ending = FileEnding(input);
  const bool alone =
    !status && ending != ".gltf" && ending != ".json" && ending != ".obj" && ending != ".ply" &&
    ending != ".off" && !(ending == ".wrl" && Holds(input, "Inline")) &&
    !(ending.starts_with(".wr") && Holds(input, gzipMark)) && bytes < (std::uint64_t{ 1 } << 50);
  return alone ? leastMemory + memoryPerByte * bytes : std::numeric_limits<std::uint64_t>::max();
}

// Prints progress for kdstream-build (ConvertedInput.h), which shows it as its own.
class ProgressLines
{
public:
  bool operator()(std::string_view step, double fraction)
  {
    using namespace std::chrono_literals;
    const auto now = std::chrono::steady_clock::now();
    if (step != this->Step || now - this->Last > 100ms)
    {
      this->Step = step;
      this->Last = now;
      std::cerr << convertProgressMark << fraction << " " << step << std::endl;
    }
    return true;
  }

private:
  std::string Step;
  std::chrono::steady_clock::time_point Last;
};

Result<ForeignMesh> Read(const CommandLine& line, const Execution& execution)
{
  try
  {
    LimitMemory(MostMemory(line.input));
    Result<ForeignMesh> read = ReadForeignMesh(line.input,
      { line.textures == "on", line.texturePixels, line.paint }, execution, line.columns);
    if (read && !line.reconstruct.empty())
    {
      LimitMemory(std::numeric_limits<std::uint64_t>::max());
      read = ReconstructMesh(std::move(*read),
        line.reconstruct == "greedy" ? Reconstruct::Greedy : Reconstruct::Poisson, execution);
    }
    return read;
  }
  catch (const std::bad_alloc&)
  {
    return Error{ ErrorCode::LimitExceeded,
      "needs more memory than its size suggests or this machine has: it is damaged or too large" };
  }
  catch (const std::exception& failure) // from a library
  {
    return Error{ ErrorCode::InvalidInput,
      std::string("the reader of this format failed: ") + failure.what() };
  }
}

// Reports these files to kdstream-build, except files with a line break in the name.
void TellNamed(const std::vector<std::filesystem::path>& files)
{
  for (const std::filesystem::path& file : files)
  {
    if (!file.empty() && file.native().find('\n') == std::string::npos)
    {
      std::cerr << convertNamedMark << file.string() << "\n";
    }
  }
}

// kdstream-build receives the counts of repairs as numbers, and reports them itself.
void TellWarnings(const std::string& program, const CommandLine& line, const ForeignMesh& read)
{
  std::vector<std::string> warnings = read.warnings;
  if (line.progressLines)
  {
    std::cerr << read.tolerance.ToLines();
  }
  else
  {
    const std::vector<std::string> reported = read.tolerance.Warnings();
    warnings.insert(warnings.end(), reported.begin(), reported.end());
  }
  for (const std::string& warning : warnings)
  {
    std::cerr << program << ": warning: " << line.input << ": " << warning << "\n";
  }
}

int Convert(const CLI::App& app, const CommandLine& line)
{
  const std::string& program = app.get_name();
  if (const Status textures = CheckTexturePixels(app, line.textures); !textures)
  {
    return PrintError(program, "", textures.GetError());
  }
  if (const Status columns = CheckColumns(line.columns, line.input); !columns)
  {
    return PrintError(program, "", columns.GetError());
  }
  const Result<std::filesystem::path> output = CheckOutputAndFolders(line.output, line.input);
  if (!output)
  {
    return PrintError(program, line.output, output.GetError(), line.output);
  }
  CatchCrashes(program, line.input);
  if (!line.progressLines) // otherwise kdstream-build reports an interrupt
  {
    EndAtInterrupts(program, line.output);
  }
  const auto begin = std::chrono::steady_clock::now();
  Result<ForeignMesh> read = Error{};
  {
    ProgressReporter progress(program, line.quiet || line.progressLines);
    Execution execution = MakeTbbExecution(line.threads);
    execution.progress = std::ref(progress);
    if (line.progressLines)
    {
      execution.progress = ProgressLines{};
    }
    read = Read(line, execution);
  }
  if (const Status strict = read ? read->tolerance.Check(line.strict) : read.GetError(); !strict)
  {
    return PrintError(program, line.input, strict.GetError());
  }
  if (line.progressLines && read->baked)
  {
    std::cerr << convertTexturesMark << read->baked->pictures << " " << read->baked->texels << " "
              << read->baked->texelsPerVertex << " " << read->baked->loss << "\n";
  }
  if (line.progressLines)
  {
    TellNamed(read->named);
  }
  TellWarnings(program, line, *read);
  if (!line.progressLines && !read->baked && FindOption(app, "--texture-pixels")->count() > 0)
  {
    std::cerr << program << ": warning: " << line.input
              << ": --texture-pixels has no effect: no textures were read\n";
  }
  // From here on there are files to remove after an interrupt.
  CatchInterrupts();
  Result<OutputFolders> folders = OutputFolders::Make(line.output);
  const Status written =
    folders ? WriteMesh(*output, read->mesh, UntilInterrupted()) : Status{ folders.GetError() };
  if (!written)
  {
    return PrintError(program, line.output, written.GetError(), line.output);
  }
  folders->Keep();
  for (const std::string& loss : LossesOfFormat(*output, read->mesh))
  {
    std::cerr << program << ": warning: " << line.output << ": " << loss << "\n";
  }
  if (!line.quiet && !line.progressLines)
  {
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
    PrintWritten(program, line.output, read->tolerance.Summary(), seconds.count());
  }
  return exitDone;
}

}

int main(int argc, char** argv)
try
{
  CommandLine line;
  CLI::App app(description, "kdstream-convert");
  app.footer(footer);
  app.add_option("INPUT", line.input, "the mesh or point cloud")->required();
  app.add_option("-o,--output", line.output, "the file to write: .ply, .vtp, .stl, .obj or .wrl")
    ->required()
    ->type_name("FILE");
  app
    .add_option("--reconstruct", line.reconstruct,
      "reconstruct a surface from a point cloud: greedy connects its points; poisson makes a "
      "closed surface near them")
    ->check(CLI::IsMember({ "greedy", "poisson" }));
  AddTextureOptions(app, { "on", "off" }, "bake textures to vertex colours, or leave them out",
    line.textures, line.texturePixels);
  AddColumnsOption(app, line.columns);
  AddStrictOption(app, line.strict);
  app.add_flag("--quiet", line.quiet, "print no progress and no summary");
  app.add_flag("--progress-lines", line.progressLines)->group(""); // only for kdstream-build
  app.add_option("--paint", line.paint)->group("");                // the same
  app.add_option("--threads", line.threads)->group("");            // the same
  return RunProgram(app, argc, argv, [&]() { return Convert(app, line); });
}
catch (...) // memory ran out before the work began
{
  return kdstream::PrintError("kdstream-convert", "", kdstream::CaughtError());
}
