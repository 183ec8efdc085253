// SPDX-License-Identifier: BSD-3-Clause
// kdstream-build-mpi: kdstream-build on the ranks of an MPI job. Step "build" of the pipeline
// picture. The contract is doc/cli.md#kdstream-build-mpi.
#include "filters/Parallel/MpiJob.h"
#include "filters/Parallel/MpiTeam.h"
#include "filters/Parallel/RankAgreement.h"
#include "filters/Parallel/TeamBuilder.h"
#include "filters/app/BuildCommand.h"
#include "filters/app/ConvertedInput.h"
#include "filters/app/OutputFolders.h"
#include "filters/core/CaughtError.h"
#include "filters/program/Program.h"
#include "filters/program/TbbExecution.h"
#include "kdstream/Version.h"

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <iostream>
#include <thread>

namespace
{

using namespace kdstream;

constexpr const char* description =
  "Builds a store on the ranks of an MPI job: the same content as kdstream-build makes.";

constexpr const char* footer =
  "INPUT is a .ply, .stl, .obj or .off mesh or cloud that all ranks can read. --memory, --threads "
  "and "
  "--temp-dir count for each rank, which holds in files what is not worked on. Other formats, the "
  "baselines, surfaces of point clouds and going on with a killed build are for kdstream-build "
  "alone.\n\n"
  "Example:\n"
  "  mpirun -np 4 kdstream-build-mpi dragon.ply -o dragon.kds";

// Ranks share the machine's threads, and its memory: as many as are told to be on one host.
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

// How many ranks of the job are on this host, as Open MPI, MPICH and Slurm tell.
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

// What only one process does. Not in this program's help, but understood, to say where it is done.
void HideOptionsOfOneProcess(CLI::App& app)
{
  for (const char* const name : { "--columns", "--partitioner", "--reconstruct", "--resume",
         "--textures", "--texture-pixels", "--texture-quality" })
  {
    FindOption(app, name)->group("");
  }
  FindOption(app, "--vertices-per-partition")->description("most vertices of a partition");
  FindOption(app, "--partitions")->description("how many partitions instead: a power of two");
}

// Errors: InvalidArgument.
Status CheckOptions(const BuildCommand& line)
{
  const auto refuse = [](const std::string& what) {
    return Error{ ErrorCode::InvalidArgument, what + ": kdstream-build does that" };
  };
  if (!line.build.partitioner->HasLevels())
  {
    return refuse("--partitioner " + line.partitioner + " is for one process");
  }
  if (!line.reconstruct.empty())
  {
    return refuse("--reconstruct is for one process");
  }
  return line.build.resume ? Status(refuse("--resume is for one process")) : Status{};
}

Status CheckInput(const BuildCommand& line)
{
  if (NeedsConversion(line.input))
  {
    return Error{ ErrorCode::Unsupported,
      "has to be converted first: kdstream-build does that, or kdstream-convert to a .ply" };
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

// Of the outputs only rank 0 looks whether they can be written, but all end if they cannot.
Status PrepareOutputs(
  MpiTeam& team, const BuildCommand& line, OutputFolders& folders, std::filesystem::path& store)
{
  store = line.output;
  const Status status = team.IsFirst() ? PrepareOutputs(line, folders, store) : Status{};
  return status ? team.Finish() : Status(team.Fail(status.GetError()));
}

// What a rank finds out alone: whether there is work to do, and whether it can do it.
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

// All ranks go on, or end, together. The same result on all.
Result<bool> ReadCommandLine(
  MpiTeam& team, CLI::App& app, int argc, char** argv, BuildCommand& line)
{
  KDSTREAM_TRY(AgreeOnProgram(team));
  const Result<bool> wanted = ReadCommandLine(app, argc, argv, line);
  if (!wanted)
  {
    return team.Fail(wanted.GetError());
  }
  KDSTREAM_TRY(AgreeOnOptions(team, line.build,
    { { "the version of the program", KDSTREAM_VERSION },
      { "--help or --version", *wanted ? "" : "given" }, { "--output", line.output },
      { "--strict", line.build.strict ? "given" : "" } }));
  return *wanted;
}

int Build(MpiTeam& team, CLI::App& app, int argc, char** argv)
{
  BuildCommand line;
  AddBuildOptions(app, line);
  HideOptionsOfOneProcess(app);
  const std::string& program = app.get_name();
  const Result<bool> wanted = ReadCommandLine(team, app, argc, argv, line);
  if (!wanted)
  {
    return PrintError(program, "", wanted.GetError());
  }
  if (!*wanted)
  {
    return exitDone;
  }
  ShareMachine(RanksHere(team.Count()), FindOption(app, "--memory")->count() > 0, line);
  OutputFolders folders;
  std::filesystem::path store;
  if (Status status = PrepareOutputs(team, line, folders, store); !status)
  {
    return PrintError(program, line.output, status.GetError());
  }
  if (team.IsFirst())
  {
    WarnOfEnding(program, line);
  }
  CatchInterrupts();
  const auto begin = std::chrono::steady_clock::now();
  Result<BuildReport> report = Error{};
  {
    ProgressReporter progress(program, line.quiet || !team.IsFirst(), SharesOfSteps(line));
    TellAmounts(line, progress);
    Execution execution = MakeTbbExecution(line.threads);
    execution.progress = std::ref(progress);
    report = BuildStoreTogether(team, line.input, store, line.build, execution);
  }
  ReleaseInterrupts();
  if (!report)
  {
    return PrintError(program, line.input, report.GetError(), line.output);
  }
  if (!team.IsFirst())
  {
    return exitDone;
  }
  folders.Keep();
  PrintWarnings(program, line, *report);
  if (!line.quiet)
  {
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
    PrintWritten(program, line.output, LastWords(*report), seconds.count());
  }
  return WriteStats(program, line, *report);
}

// The other ranks wait for this one. Only MPI can tell them, and does when a rank ends without a
// farewell to it: the job ends.
[[noreturn]] void EndJob(const MpiTeam& team, const std::string& program, const Error& error)
{
  std::cerr.clear(); // this rank speaks, whichever it is
  std::_Exit(PrintError(program, "", team.NameRank(error)));
}

}

int main(int argc, char** argv)
{
  MpiJob job(argc, argv);
  MpiTeam team(job.Messages());
  if (!team.IsFirst()) // one rank speaks for all
  {
    std::cout.setstate(std::ios::failbit);
    std::cerr.setstate(std::ios::failbit);
  }
  CLI::App app(description, "kdstream-build-mpi");
  app.footer(footer);
  try
  {
    return Build(team, app, argc, argv);
  }
  catch (const BrokenTeam& broken)
  {
    EndJob(team, app.get_name(), broken.error);
  }
  catch (...)
  {
    EndJob(team, app.get_name(), CaughtError());
  }
}
