// SPDX-License-Identifier: BSD-3-Clause
// kdstream-build: a mesh file in, a store out. Step "build" of the pipeline picture.
// doc/cli.md#kdstream-build describes it.
#include "filters/app/BuildCommand.h"
#include "filters/app/ConvertForBuild.h"
#include "filters/app/OutputFolders.h"
#include "filters/build/Builder.h"
#include "filters/core/CaughtError.h"
#include "filters/core/TakeResult.h"
#include "filters/outofcore/files/LockedFolder.h"
#include "filters/program/Program.h"
#include "filters/program/TbbExecution.h"

#include <chrono>
#include <filesystem>
#include <iostream>

namespace
{

using namespace kdstream;

constexpr const char* description =
  "Splits a mesh into uniform k-d partitions, makes a hierarchy of simplified meshes, and writes "
  "both to a store that kdstream-serve can stream.";

constexpr const char* footer =
  "INPUT is a .ply, .stl, .obj or .off file, which is read in chunks and may be larger than "
  "memory; or a .vtp, .vtk, .wrl, .wrz, .glb, .gltf, .json (3D Tiles), .pcd, .las, .laz, .xyz, "
  ".txt, .csv, .pts, "
  ".asc, "
  ".xyzrgb or .xyzn file, which kdstream-convert reads as a whole, in addition to --memory (see "
  "kdstream-convert --help). Files with textures "
  "are also read as a whole, unless --textures is off. A file without faces is a point cloud.\n\n"
  "Example:\n"
  "  kdstream-build dragon.ply -o dragon.kds --title \"Stanford dragon\" --unit mm";

// Looks for a stray vertex, but only in point clouds: without its stray vertices a surface would
// have holes.
void FindStray(BuildCommand& line, const std::filesystem::path& file,
  const Result<BuildReport>& report, const Execution& execution)
{
  if (report && report->info.primitive == PrimitiveType::Points && LosesBits(*report))
  {
    line.stray = FindStrayPoint(file, execution);
  }
}

// Builds from the input itself, or from the mesh that kdstream-convert makes of it.
Result<BuildReport> BuildFrom(BuildCommand& line, const std::filesystem::path& store,
  const Execution& execution, std::vector<std::string>& warnings)
{
  const std::filesystem::path folder = store.has_parent_path() ? store.parent_path() : ".";
  RemoveDeadFolders(folder); // the folders of conversions, even if --temp-dir is another one
  if (!line.build.temporaryFolder.empty())
  {
    RemoveDeadFolders(line.build.temporaryFolder);
  }
  if (!line.converts)
  {
    Result<BuildReport> report =
      BuildStore(std::filesystem::path(line.input), store, line.build, execution);
    FindStray(line, line.input, report, execution);
    return report;
  }
  const auto begin = std::chrono::steady_clock::now();
  const Result<ConvertedInput> converted = ConvertForBuild(line, folder, execution);
  KDSTREAM_TRY(converted);
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
  warnings = converted->Warnings();
  std::shared_ptr<const TiledTextures> textures;
  if (std::error_code none; std::filesystem::exists(converted->TextureFolderPath() / "paint", none))
  {
    KDSTREAM_TRY(Take(KeepTextures(line, converted->TextureFolderPath()), textures));
  }
  Result<BuildReport> report = BuildStore(converted->File(), store, line.build, execution);
  if (!report)
  {
    return converted->Blame(report.GetError());
  }
  FindStray(line, converted->File(), report, execution);
  if (textures)
  {
    line.tiled = textures->Counts();
    const std::vector<std::string> reported = textures->Warnings();
    warnings.insert(warnings.end(), reported.begin(), reported.end());
  }
  Tolerance tolerance = converted->GetTolerance();
  tolerance.Add(report->tolerance);
  report->tolerance = std::move(tolerance);
  report->seconds.emplace_back("convert", seconds.count());
  for (auto& [step, time] : report->seconds)
  {
    time += step == "total" ? seconds.count() : 0;
  }
  return report;
}

int Build(const CLI::App& app, BuildCommand& line)
{
  const std::string& program = app.get_name();
  const Status status = Interpret(app, line);
  if (!status)
  {
    return PrintError(program, "", status.GetError());
  }
  if (Status served = CheckStoreName(line.output); !served)
  {
    return PrintError(program, line.output, served.GetError());
  }
  Result<OutputFolders> folders = OutputFolders::Make(line.output);
  if (!folders)
  {
    return PrintError(program, line.output, folders.GetError());
  }
  const Result<std::filesystem::path> store =
    CheckOutput(line.output, OutputKind::File, { line.input });
  if (!store)
  {
    return PrintError(program, line.output, store.GetError());
  }
  if (!line.stats.empty())
  {
    Result<std::filesystem::path> stats =
      CheckOutput(line.stats, OutputKind::Stream, { line.input });
    if (stats && !CheckOutput(line.stats, OutputKind::Stream, { line.output }))
    {
      stats = Error{ ErrorCode::InvalidArgument, "--stats and --output name the same file" };
    }
    if (!stats)
    {
      return PrintError(program, line.stats, stats.GetError());
    }
  }
  WarnOfEnding(program, line);
  CatchInterrupts();
  const auto begin = std::chrono::steady_clock::now();
  std::vector<std::string> warnings = ChooseReader(line);
  if (const std::string memory = MemoryOfConversion(line); !memory.empty() && !line.quiet)
  {
    std::cerr << program << ": note: " << line.input << ": " << memory << "\n";
  }
  Result<BuildReport> report = Error{};
  {
    ProgressReporter progress(program, line.quiet, SharesOfSteps(line));
    TellAmounts(line, progress);
    Execution execution = MakeTbbExecution(line.threads);
    execution.progress = std::ref(progress);
    if (!line.quiet)
    {
      line.build.tellEarlierBuild = [&](const std::string& found)
      { std::cerr << program << ": " << found << "\n"; };
    }
    report = BuildFrom(line, *store, execution, warnings);
  }
  ReleaseInterrupts();
  PrintWarnings(program, line, warnings);
  if (!report)
  {
    return PrintError(program, line.input, report.GetError(), line.output);
  }
  folders->Keep();
  return FinishBuild(program, line, *report, begin);
}

}

int main(int argc, char** argv)
try
{
  BuildCommand line;
  CLI::App app(description, "kdstream-build");
  app.footer(footer);
  AddBuildOptions(app, line);
  return RunProgram(app, argc, argv, [&]() { return Build(app, line); });
}
catch (...) // memory ran out before the work began
{
  return kdstream::PrintError("kdstream-build", "", kdstream::CaughtError());
}
