// kdstream-generate: models of any size, made up.
#include "Data/Generate/ClosedGrid.h"
#include "Data/Generate/Relief.h"
#include "Data/Generate/Vase.h"
#include "filters/program/Program.h"
#include "filters/program/TbbExecution.h"

namespace
{

using namespace kdstream;

struct CommandLine
{
  std::string kind, file;
  std::uint64_t vertices = 300000;
  generate::ReliefOptions relief;
  unsigned threads = 0;
  bool quiet = false;
};

Status MakeVaseFile(const CommandLine& line, const std::filesystem::path& file)
{
  if (line.relief.shuffledTriangles || line.relief.shuffledPoints)
  {
    return Error{ ErrorCode::InvalidArgument, "a vase is not shuffled: only a relief is" };
  }
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

int Generate(const std::string& program, const CommandLine& line)
{
  const Result<std::filesystem::path> file = CheckOutput(line.file, OutputKind::File, {});
  if (!file)
  {
    return PrintError(program, line.file, file.GetError());
  }
  CatchInterrupts();
  Status written;
  {
    ProgressReporter progress(program, line.quiet);
    Execution execution = MakeTbbExecution(line.threads);
    execution.progress = std::ref(progress);
    written =
      line.kind == "vase" ? MakeVaseFile(line, *file) : MakeReliefFile(line, *file, execution);
  }
  ReleaseInterrupts();
  return written ? exitDone : PrintError(program, line.file, written.GetError());
}

}

int main(int argc, char** argv)
{
  CommandLine line;
  CLI::App app(
    "Makes up a closed model and writes it as a binary PLY file, as a stream: it may be larger "
    "than memory.\n\n"
    "  vase    a hollow vase with fine relief, painted\n"
    "  relief  a ball with relief from half its size down to a few edges, and grain; up to 2^32 "
    "vertices\n\n"
    "Example: kdstream-generate relief relief.ply --vertices 14030000 --shuffled",
    "kdstream-generate");
  app.set_version_flag("--version", KDSTREAM_VERSION);
  app.add_option("KIND", line.kind, "what to make")
    ->required()
    ->check(CLI::IsMember({ "vase", "relief" }));
  app.add_option("FILE", line.file, "PLY file to write")->required();
  app.add_option("--vertices", line.vertices, "about how many it has")->capture_default_str();
  app.add_option("--seed", line.relief.seed, "another one makes another grain, and order")
    ->capture_default_str();
  app.add_flag("--shuffled", line.relief.shuffledTriangles,
    "relief: triangles in an order that looks random, instead of side by side");
  app.add_flag("--shuffled-vertices", line.relief.shuffledPoints,
    "relief: vertices in an order that looks random");
  app
    .add_option("--threads", line.threads,
      "threads for the relief; the file does not depend on them [all of the machine's]")
    ->check(CLI::Range(1U, 1024U));
  app.add_flag("--quiet", line.quiet, "no progress");
  return RunProgram(app, argc, argv, [&]() { return Generate(app.get_name(), line); });
}
