// SPDX-License-Identifier: BSD-3-Clause
// kdstream-generate: makes up models of any size.
#include "Data/Generate/ClosedGrid.h"
#include "Data/Generate/Relief.h"
#include "Data/Generate/Statue.h"
#include "Data/Generate/Vase.h"
#include "filters/core/CaughtError.h"
#include "filters/meshio/FileEnding.h"
#include "filters/program/Program.h"
#include "filters/program/TbbExecution.h"

#include <chrono>

namespace
{

using namespace kdstream;

struct CommandLine
{
  std::string kind, file;
  std::uint64_t vertices = 300000;
  std::size_t pictureSide = 2048;
  std::string charts = "few";
  generate::ReliefOptions relief;
  unsigned threads = 0;
  bool quiet = false;
};

// Checks the options of kinds that are not reliefs.
Status CheckPlain(const CommandLine& line)
{
  if (line.relief.shuffledTriangles || line.relief.shuffledPoints)
  {
    return Error{ ErrorCode::InvalidArgument,
      "a " + line.kind + " is not shuffled: only a relief is" };
  }
  if (line.relief.detail > 0)
  {
    return Error{ ErrorCode::InvalidArgument,
      "a " + line.kind + " has no --detail: only a relief has" };
  }
  return {};
}

Status MakeStatueFile(
  const CommandLine& line, const std::filesystem::path& file, const Execution& execution)
{
  KDSTREAM_TRY(CheckPlain(line));
  const auto charts = line.charts == "small"  ? generate::StatueCharts::Small
                      : line.charts == "udim" ? generate::StatueCharts::Udim
                                              : generate::StatueCharts::Few;
  return generate::WriteStatue(
    { line.vertices, line.pictureSide, line.relief.seed, charts }, file, execution);
}

Status MakeVaseFile(const CommandLine& line, const std::filesystem::path& file)
{
  KDSTREAM_TRY(CheckPlain(line));
  const auto grid = generate::ClosedGrid::Of(line.vertices, generate::vaseColumnsPerRing);
  return grid ? generate::WritePly(*grid, generate::MakeVase(line.relief.seed), file)
              : Status{ grid.GetError() };
}

Status MakeReliefFile(
  const CommandLine& line, const std::filesystem::path& file, const Execution& execution)
{
  const auto grid = generate::CubeGrid::Of(line.vertices);
  return grid ? generate::WriteRelief(*grid, line.relief, file, execution)
              : Status{ grid.GetError() };
}

int Generate(const CLI::App& app, const CommandLine& line)
{
  const std::string& program = app.get_name();
  for (const std::string option : { "--picture-side", "--charts" })
  {
    if (line.kind != "statue" && app.count(option) > 0)
    {
      return PrintError(program, line.file,
        { ErrorCode::InvalidArgument,
          "a " + line.kind + " has no " + option + ": only a statue has" });
    }
  }
  const std::string ending = line.kind == "statue" ? ".obj" : ".ply";
  if (FileEnding(line.file) != ending)
  {
    return PrintError(program, line.file,
      { ErrorCode::InvalidArgument, (line.kind == "statue" ? "a statue is written as " : "only ") +
                                      ending + (line.kind == "statue" ? "" : " files are written") +
                                      ": give it a name that ends so" });
  }
  const Result<std::filesystem::path> file = CheckOutput(line.file, OutputKind::File, {});
  if (!file)
  {
    return PrintError(program, line.file, file.GetError());
  }
  CatchInterrupts();
  const auto begin = std::chrono::steady_clock::now();
  Status written;
  {
    ProgressReporter progress(program, line.quiet);
    progress.SetAmount("vertices", { double(line.vertices), "vertices" });
    progress.SetAmount("triangles", { 2 * double(line.vertices), "triangles" });
    Execution execution = MakeTbbExecution(line.threads);
    execution.progress = std::ref(progress);
    written = line.kind == "statue" ? MakeStatueFile(line, *file, execution)
              : line.kind == "vase" ? MakeVaseFile(line, *file)
                                    : MakeReliefFile(line, *file, execution);
  }
  ReleaseInterrupts();
  if (!written)
  {
    return PrintError(program, line.file, written.GetError());
  }
  if (!line.quiet)
  {
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
    PrintWritten(program, line.file, "", seconds.count());
  }
  return exitDone;
}

}

int main(int argc, char** argv)
try
{
  CommandLine line;
  CLI::App app("Makes up a closed model and writes it as a binary .ply file, as a stream: it may "
               "be larger than "
               "memory.",
    "kdstream-generate");
  app.footer(
    "Kinds:\n"
    "  vase    a hollow vase with fine relief, painted\n"
    "  statue  a bust that four photographs paint: .obj, .mtl, .jpg and .png files\n"
    "  relief  a ball with relief from half its size down to a few edges, and grain; up to "
    "2^32 vertices\n\n"
    "Example:\n"
    "  kdstream-generate relief relief.ply --vertices 14030000 --shuffled");
  app.add_option("KIND", line.kind, "what to make: vase, statue or relief")
    ->required()
    ->check(CLI::IsMember({ "vase", "statue", "relief" }));
  app.add_option("FILE", line.file, "the file to write: NAME.ply; of a statue NAME.obj")
    ->required();
  const char* const model = "Model";
  app.add_option("--vertices", line.vertices, "about how many vertices it has")
    ->capture_default_str()
    ->group(model);
  app
    .add_option("--picture-side", line.pictureSide,
      "statue: texels of a side of its photographs; they lie beside it")
    ->check(CLI::Range(std::size_t{ 64 }, std::size_t{ 1 } << 14))
    ->capture_default_str()
    ->group(model);
  app
    .add_option("--charts", line.charts,
      "statue: four charts a photograph, 576 small ones, or few with a coordinate range for each "
      "photograph")
    ->check(CLI::IsMember({ "few", "small", "udim" }))
    ->capture_default_str()
    ->group(model);
  app.add_option("--seed", line.relief.seed, "another number makes another grain, and order")
    ->capture_default_str()
    ->group(model);
  app
    .add_option("--detail", line.relief.detail,
      "relief: as fine as one of so many vertices, without grain: the same shape for any "
      "--vertices")
    ->check(CLI::Range(std::uint64_t{ 8 }, std::uint64_t{ 1 } << 32))
    ->type_name("N")
    ->group(model);
  app
    .add_flag("--shuffled", line.relief.shuffledTriangles,
      "relief: triangles in an order that looks random, instead of side by side")
    ->group(model);
  app
    .add_flag("--shuffled-vertices", line.relief.shuffledPoints,
      "relief: vertices in an order that looks random")
    ->group(model);
  app
    .add_option(
      "--threads", line.threads, "threads for the relief; the file does not depend on them")
    ->check(CLI::Range(1U, 1024U))
    ->default_str("all");
  app.add_flag("--quiet", line.quiet, "print no progress and no summary");
  return RunProgram(app, argc, argv, [&]() { return Generate(app, line); });
}
catch (...) // memory runs out before the work begins
{
  return kdstream::PrintError("kdstream-generate", "", kdstream::CaughtError());
}
