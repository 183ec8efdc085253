// SPDX-License-Identifier: BSD-3-Clause
// kdstream-build-mpi: kdstream-build on the ranks of an MPI job. Step "build" of the pipeline
// picture. doc/cli.md#kdstream-build-mpi describes it.
#include "filters/Parallel/DistributedBuilder.h"
#include "filters/Parallel/MpiGroup.h"
#include "filters/Parallel/MpiJob.h"
#include "filters/Parallel/RankAgreement.h"
#include "filters/app/BuildCommand.h"
#include "filters/app/ConvertForBuild.h"
#include "filters/app/OutputFolders.h"
#include "filters/core/CaughtError.h"
#include "filters/core/TakeResult.h"
#include "filters/program/Program.h"
#include "filters/program/TbbExecution.h"
#include "kdstream/Version.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdlib>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace
{

using namespace kdstream;

constexpr const char* description =
  "Builds a store on the ranks of an MPI job, with the same content as kdstream-build.";

constexpr const char* footer =
  "INPUT is a .ply, .stl, .obj or .off mesh or point cloud that all ranks can read. --memory, "
  "--threads and --temp-dir apply to each rank, which keeps in temporary files what it does not "
  "work on. The first rank reads a file with textures, as a whole, into a folder beside the store, "
  "which all ranks must see, unless --textures is off. Use kdstream-build for other formats, "
  "octree "
  "and k-means partitions, surface reconstruction and resuming a killed build.\n\n"
  "Example:\n"
  "  mpirun -np 4 kdstream-build-mpi dragon.ply -o dragon.kds";

// Ranks on one host share the machine's threads and memory.
void ShareMachine(std::size_t ranksHere, bool memoryGiven, BuildCommand& line)
{
  if (line.threads == 0)
  {
    line.threads = std::max(1U, static_cast<unsigned>(std::thread::hardware_concurrency() /
                                                      static_cast<unsigned>(ranksHere)));
  }
  if (!memoryGiven)
  {
    line.build.memory /= ranksHere;
  }
}

// The number of ranks of the job on this host, as Open MPI, MPICH and Slurm report it.
std::size_t RanksHere(std::size_t ranks)
{
  for (const char* const name : { "OMPI_COMM_WORLD_LOCAL_SIZE", "MPI_LOCALNRANKS" })
  {
    const char* const value = std::getenv(name);
    const long count = value != nullptr ? std::strtol(value, nullptr, 10) : 0;
    if (count > 0)
    {
      return static_cast<std::size_t>(count);
    }
  }
  return ranks;
}

// Options that only kdstream-build has. They are hidden in the help but accepted, so that the error
// can name kdstream-build.
void HideOptionsOfOneProcess(CLI::App& app)
{
  for (const char* const name : { "--columns", "--partitioner", "--reconstruct", "--resume" })
  {
    FindOption(app, name)->group("");
  }
  FindOption(app, "--vertices-per-partition")->description("maximum vertices per partition");
  FindOption(app, "--partitions")->description("number of partitions instead: a power of two");
}

// Errors: InvalidArgument.
Status CheckOptions(const BuildCommand& line)
{
  const auto refuse = [](const std::string& what) {
    return Error{ ErrorCode::InvalidArgument, what + ": use kdstream-build" };
  };
  if (!line.build.partitioner->HasLevels())
  {
    return refuse("--partitioner " + line.partitioner + " does not work on several ranks");
  }
  if (!line.reconstruct.empty())
  {
    return refuse("--reconstruct does not work on several ranks");
  }
  return line.build.resume ? Status(refuse("--resume does not work on several ranks")) : Status{};
}

Status CheckInput(const BuildCommand& line)
{
  if (NeedsConversion(line.input))
  {
    return Error{ ErrorCode::Unsupported, "cannot be read on several ranks: convert it to .ply "
                                          "with kdstream-convert, or use kdstream-build" };
  }
  return {};
}

Status PrepareOutputs(
  const BuildCommand& line, OutputFolders& folders, std::filesystem::path& store)
{
  KDSTREAM_TRY(CheckStoreName(line.output));
  Result<OutputFolders> made = OutputFolders::Make(line.output);
  KDSTREAM_TRY(made);
  folders = std::move(*made);
  const auto checked = CheckOutput(line.output, OutputKind::File, { line.input });
  KDSTREAM_TRY(checked);
  store = *checked;
  if (!line.stats.empty())
  {
    auto stats = CheckOutput(line.stats, OutputKind::Stream, { line.input, line.output });
    if (!stats)
    {
      Error error = stats.GetError();
      error.file = line.stats;
      return error;
    }
  }
  return {};
}

// Only rank 0 checks whether the outputs can be written; all ranks end if they cannot.
Status PrepareOutputs(
  MpiGroup& group, const BuildCommand& line, OutputFolders& folders, std::filesystem::path& store)
{
  store = line.output;
  const Status status = group.IsFirst() ? PrepareOutputs(line, folders, store) : Status{};
  return status ? group.Finish() : Status(group.Fail(status.GetError()));
}

// The part that each rank does on its own: finds out whether there is work to do, and whether the
// options are valid.
Result<bool> ReadCommandLine(CLI::App& app, int argc, char** argv, BuildCommand& line)
{
  const Result<bool> wanted = ParseCommandLine(app, argc, argv);
  KDSTREAM_TRY(wanted);
  if (*wanted)
  {
    KDSTREAM_TRY(Interpret(app, line));
    KDSTREAM_TRY(CheckOptions(line));
    KDSTREAM_TRY(OfFile(line.input, CheckInput(line)));
  }
  return *wanted;
}

// All ranks then continue or end together, with the same result.
Result<bool> ReadCommandLine(
  MpiGroup& group, CLI::App& app, int argc, char** argv, BuildCommand& line)
{
  KDSTREAM_TRY(AgreeOnProgram(group));
  const Result<bool> wanted = ReadCommandLine(app, argc, argv, line);
  if (!wanted)
  {
    return group.Fail(wanted.GetError());
  }
  KDSTREAM_TRY(AgreeOnOptions(group, line.build,
    { { "the version of the program", KDSTREAM_VERSION },
      { "--help or --version", *wanted ? "" : "given" }, { "--output", line.output },
      { "--textures", line.textures }, { "--texture-quality", line.textureQuality },
      { "--texture-pixels", std::to_string(line.texturePixels) },
      { "--strict", line.build.strict ? "given" : "" } }));
  return *wanted;
}

// The files that rank 0 has made of a textured mesh; nothing if the mesh is read directly.
struct SharedConversion
{
  std::optional<ConvertedInput> own; // only on rank 0; its files are removed with it
  std::filesystem::path mesh, textures;
};

// Rank 0 converts the input, and sends the paths of the files to the others.
Result<SharedConversion> Convert(MpiGroup& group, BuildCommand& line,
  const std::filesystem::path& store, const Execution& execution,
  std::vector<std::string>& warnings)
{
  SharedConversion shared;
  Status status;
  warnings = group.IsFirst() ? ChooseReader(line) : std::vector<std::string>{};
  if (line.converts)
  {
    const std::filesystem::path folder = std::filesystem::absolute(store).parent_path();
    Result<ConvertedInput> made = ConvertForBuild(line, folder, execution);
    if (made)
    {
      shared.own.emplace(std::move(*made));
      const std::vector<std::string>& reported = shared.own->Warnings();
      warnings.insert(warnings.end(), reported.begin(), reported.end());
    }
    status = made ? Status{} : Status(made.GetError());
  }
  KDSTREAM_TRY(status ? group.Finish() : Status(group.Fail(status.GetError())));
  std::string reported; // the path of the mesh, then that of the pictures if there are any, on a
                        // line each
  if (shared.own)
  {
    std::error_code none;
    reported = shared.own->File().string() + "\n";
    reported += std::filesystem::exists(shared.own->TextureFolderPath() / "paint", none)
                  ? shared.own->TextureFolderPath().string()
                  : "";
  }
  RankLists<char> out(group.Count());
  out.assign(group.Count(), std::vector<char>(reported.begin(), reported.end()));
  const Result<RankLists<char>> in = group.Exchange(out);
  KDSTREAM_TRY(in);
  const std::string of0((*in)[0].begin(), (*in)[0].end());
  const std::size_t end = std::min(of0.find('\n'), of0.size());
  shared.mesh = of0.substr(0, end);
  shared.textures = of0.substr(std::min(end + 1, of0.size()));
  return shared;
}

// Builds from the input itself, or from the mesh that rank 0 has converted.
Result<BuildReport> BuildFrom(MpiGroup& group, BuildCommand& line,
  const std::filesystem::path& store, const Execution& execution,
  std::vector<std::string>& warnings)
{
  const Result<SharedConversion> shared = Convert(group, line, store, execution, warnings);
  KDSTREAM_TRY(shared);
  if (shared->mesh.empty())
  {
    return BuildStoreCollectively(group, line.input, store, line.build, execution);
  }
  std::shared_ptr<const TiledTextures> textures;
  const Status kept =
    shared->textures.empty() ? Status{} : Take(KeepTextures(line, shared->textures), textures);
  KDSTREAM_TRY(kept ? group.Finish() : Status(group.Fail(kept.GetError())));
  Result<BuildReport> report =
    BuildStoreCollectively(group, shared->mesh, store, line.build, execution);
  if (!report)
  {
    return shared->own ? shared->own->Blame(report.GetError()) : report.GetError();
  }
  if (textures)
  {
    const TileCounts own = textures->Counts();
    std::array<std::uint64_t, 5> sums{ own.tiles, own.halved, own.texels, own.triangles,
      own.repeating };
    KDSTREAM_TRY(group.Sum(sums));
    line.tiled = TileCounts{ sums[0], sums[1], sums[2], sums[3], sums[4] };
    const std::vector<std::string> reported = textures->Warnings();
    warnings.insert(warnings.end(), reported.begin(), reported.end());
  }
  if (shared->own)
  {
    Tolerance tolerance = shared->own->GetTolerance();
    tolerance.Add(report->tolerance);
    report->tolerance = std::move(tolerance);
  }
  return report;
}

int Build(MpiGroup& group, CLI::App& app, int argc, char** argv)
{
  BuildCommand line;
  AddBuildOptions(app, line);
  HideOptionsOfOneProcess(app);
  const std::string& program = app.get_name();
  const Result<bool> wanted = ReadCommandLine(group, app, argc, argv, line);
  if (!wanted)
  {
    return PrintError(program, "", wanted.GetError());
  }
  if (!*wanted)
  {
    return exitDone;
  }
  ShareMachine(RanksHere(group.Count()), FindOption(app, "--memory")->count() > 0, line);
  OutputFolders folders;
  std::filesystem::path store;
  if (Status status = PrepareOutputs(group, line, folders, store); !status)
  {
    return PrintError(program, line.output, status.GetError());
  }
  if (group.IsFirst())
  {
    WarnOfEnding(program, line);
  }
  CatchInterrupts();
  const auto begin = std::chrono::steady_clock::now();
  std::vector<std::string> warnings;
  Result<BuildReport> report = Error{};
  {
    ProgressReporter progress(program, line.quiet || !group.IsFirst(), SharesOfSteps(line));
    TellAmounts(line, progress);
    Execution execution = MakeTbbExecution(line.threads);
    execution.progress = std::ref(progress);
    report = BuildFrom(group, line, store, execution, warnings);
  }
  ReleaseInterrupts();
  PrintWarnings(program, line, warnings);
  if (!report)
  {
    return PrintError(program, line.input, report.GetError(), line.output);
  }
  if (!group.IsFirst())
  {
    return exitDone;
  }
  folders.Keep();
  return FinishBuild(program, line, *report, begin);
}

// Ends the job while other ranks are waiting for this one. Only MPI can inform them: if a rank ends
// without MPI_Finalize, MPI ends the job.
[[noreturn]] void EndJob(const MpiGroup& group, const std::string& program, const Error& error)
{
  std::cerr.clear(); // any rank may print this error
  std::_Exit(PrintError(program, "", group.NameRank(error)));
}

}

int main(int argc, char** argv)
{
  MpiJob job(argc, argv);
  MpiGroup group(job.Messages());
  if (!group.IsFirst()) // only the first rank prints
  {
    std::cout.setstate(std::ios::failbit);
    std::cerr.setstate(std::ios::failbit);
  }
  CLI::App app(description, "kdstream-build-mpi");
  app.footer(footer);
  try
  {
    return Build(group, app, argc, argv);
  }
  catch (const BrokenGroup& broken)
  {
    EndJob(group, app.get_name(), broken.error);
  }
  catch (...)
  {
    EndJob(group, app.get_name(), CaughtError());
  }
}
