// kdstream-build: a mesh file in, a store out. The contract is CLI.md.
#include "filters/app/ConvertedInput.h"
#include "filters/app/Program.h"
#include "filters/app/StoreJson.h"
#include "filters/app/TbbExecution.h"
#include "filters/store/Builder.h"

#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <iostream>
#include <thread>

namespace
{

using namespace kdstream;
using Json = nlohmann::json;

constexpr const char* description =
  "Cuts a mesh into uniform k-d partitions and a hierarchy of "
  "simplified meshes, and writes them to a store\n"
  "that kdstream-serve streams from.\n\n"
  "INPUT is a .ply (ascii, little or big endian), .stl (ascii, binary) or .obj file, which are "
  "read "
  "in chunks (polygons\n"
  "become fans, right for convex ones, and strips triangles), or a .vtp, .vtk, .wrl, .glb, .gltf, "
  ".pcd or .xyz\n"
  "file. Those are read whole by kdstream-convert, a process of its own with memory "
  "of its own; its --help tells what is read of them.\n"
  "A file without faces is a point cloud.\n\n"
  "Example: kdstream-build dragon.ply -o dragon.kds --title "
  "\"Stanford dragon\" --stats dragon.json";

struct CommandLine
{
  std::string input, output, stats, reconstruct;
  BuildOptions build;
  std::uint32_t partitions = 0;
  std::string partitioner = "kdtree", maker = "collapse", representative = "quadric", sheets = "on",
              weld = "on";
  std::string precision = "20";
  unsigned threads = 0;
  bool quiet = false;
};

const CLI::Validator onOff = CLI::IsMember({ "on", "off" });

void AddOptions(CLI::App& app, CommandLine& line)
{
  app.add_option("INPUT", line.input, "the mesh")->required();
  app.add_option("-o,--output", line.output, "the store to write (NAME.kds)")->required();
  auto* size = app
                 .add_option("--vertices-per-partition", line.build.tree.verticesPerPartition,
                   "most vertices of a partition (kmeans: on average)")
                 ->check(CLI::Range(1U, 1U << 20))
                 ->capture_default_str();
  app
    .add_option("--partitions", line.partitions,
      "number of partitions instead, at most the vertices: a power of two for kdtree, any for "
      "kmeans, about so many for octree")
    ->check(CLI::Range(1U, 1U << 30))
    ->excludes(size);
  app
    .add_option("--partitioner", line.partitioner,
      "kdtree, or one of the baselines octree and kmeans: partitions only, for comparison")
    ->check(CLI::IsMember({ "kdtree", "octree", "kmeans" }))
    ->capture_default_str();
  AddSizeOption(app, "--memory", line.build.memory,
    "most memory the build may take (K, M, G); a mesh that needs more is refused [75 % of free "
    "memory]");
  app.add_option("--threads", line.threads, "threads [all of the machine's]")
    ->check(CLI::Range(1U, 1024U));
  app.add_option("--levels", line.maker, "how coarser levels are made: collapse or cluster")
    ->check(CLI::IsMember({ "collapse", "cluster" }))
    ->capture_default_str();
  app.add_option("--representative", line.representative, "of a cluster: quadric or mean")
    ->check(CLI::IsMember({ "quadric", "mean" }))
    ->capture_default_str();
  app
    .add_option(
      "--sheets", line.sheets, "a representative per sheet of the surface (on) or per cell (off)")
    ->check(onOff)
    ->capture_default_str();
  app
    .add_option("--cell-vertices", line.build.tree.cellVertices,
      "most vertices of a cell at the finest level")
    ->check(CLI::Range(1U, 1024U))
    ->capture_default_str();
  app
    .add_option("--weld", line.weld,
      "join vertices with bit-equal coordinates and equal attributes: on or off; corners of .stl "
      "are always joined")
    ->check(onOff)
    ->capture_default_str();
  app
    .add_option("--precision", line.precision,
      "bits per axis of the model's grid (8-24), or lossless: the exact coordinates")
    ->capture_default_str();
  CheckText(app.add_option("--title", line.build.title, "shown by the viewers"));
  CheckText(app.add_option("--credit", line.build.credit, "shown by the viewers"));
  CheckText(app.add_option("--license", line.build.license, "shown by the viewers"));
  CheckText(app.add_option("--unit", line.build.unit, "of the coordinates, shown by the viewers"));
  app
    .add_option("--reconstruct", line.reconstruct,
      "make a surface of a point cloud first: greedy (joins the points) or poisson (a closed "
      "surface near them)")
    ->check(CLI::IsMember({ "greedy", "poisson" }));
  app.add_option("--stats", line.stats, "file for statistics (JSON)")->type_name("FILE");
  app.add_flag("--quiet", line.quiet, "no progress");
}

// Baselines have no levels: what shapes them must not be taken for granted.
Status CheckLevelOptions(const CLI::App& app, const CommandLine& line)
{
  for (const char* name : { "--levels", "--representative", "--sheets", "--cell-vertices" })
  {
    if (line.partitioner != "kdtree" && app.count(name) > 0)
    {
      return Error{ ErrorCode::InvalidArgument,
        std::string(name) + ": a store by --partitioner " + line.partitioner + " has no levels" };
    }
  }
  return {};
}

Status Interpret(CommandLine& line)
{
  if (line.partitions > 0)
  {
    line.build.tree.partitions = line.partitions;
  }
  line.build.partitioner = line.partitioner == "octree"   ? Partitioner::Octree
                           : line.partitioner == "kmeans" ? Partitioner::KMeans
                                                          : Partitioner::KdTree;
  line.build.levels.maker = line.maker == "collapse" ? LevelMaker::Collapse : LevelMaker::Cluster;
  line.build.weld = line.weld == "on";
  line.build.levels.sheets = line.sheets == "on";
  line.build.levels.representative =
    line.representative == "mean" ? Representative::Mean : Representative::Quadric;
  if (line.build.memory == 0)
  {
    line.build.memory = FreeMemory() / 4 * 3;
  }
  if (line.precision == "lossless")
  {
    line.build.bits = 0;
    return {};
  }
  const bool digits = !line.precision.empty() && line.precision.size() <= 2 &&
                      std::all_of(line.precision.begin(), line.precision.end(),
                        [](char c) { return c >= '0' && c <= '9'; });
  const int bits = digits ? std::stoi(line.precision) : 0;
  if (bits < 8 || bits > 24)
  {
    return Error{ ErrorCode::InvalidArgument,
      "--precision: \"" + line.precision + "\" is neither 8 to 24 bits nor lossless" };
  }
  line.build.bits = static_cast<std::uint8_t>(bits);
  return {};
}

Json StatsOf(const CommandLine& line, const BuildReport& report)
{
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  std::error_code status;
  const std::uintmax_t bytes = std::filesystem::file_size(line.output, status);
  Json stats = StoreToJson(report.info, status ? 0 : bytes);
  stats["input"] = line.input;
  stats["merged_by_grid"] = report.mergedByGrid;
  stats["passes"] = 1; // over the input: everything else is done in memory
  stats["temp_bytes"] = 0;
  stats["peak_rss_bytes"] = static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;
  for (const auto& [step, time] : report.seconds)
  {
    stats["seconds"][step] = time;
  }
  return stats;
}

// Builds from the input itself, or from what kdstream-convert makes of it.
Result<BuildReport> BuildFrom(CommandLine& line, const std::filesystem::path& store,
  const Execution& execution, std::vector<std::string>& warnings)
{
  if (line.reconstruct.empty() && !NeedsConversion(line.input))
  {
    return BuildStore(std::filesystem::path(line.input), store, line.build, execution);
  }
  std::vector<std::string> arguments;
  if (!line.reconstruct.empty())
  {
    arguments = { "--reconstruct", line.reconstruct };
  }
  const auto begin = std::chrono::steady_clock::now();
  const std::filesystem::path folder = store.has_parent_path() ? store.parent_path() : ".";
  const Result<ConvertedInput> converted =
    ConvertedInput::Make(line.input, folder, arguments, execution);
  if (!converted)
  {
    return converted.GetError();
  }
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
  warnings = converted->Warnings();
  line.build.inputName = std::filesystem::path(line.input).filename().string();
  Result<BuildReport> report = BuildStore(converted->File(), store, line.build, execution);
  if (report)
  {
    report->seconds.emplace_back("convert", seconds.count());
    for (auto& [step, time] : report->seconds)
    {
      time += step == "total" ? seconds.count() : 0;
    }
  }
  return report;
}

// Of a model without colours that viewers show, why those that it has are none; empty if there are
// no such.
std::string HiddenColors(const std::vector<AttributeInfo>& attributes)
{
  if (std::any_of(attributes.begin(), attributes.end(),
        [](const AttributeInfo& attribute) { return RoleOf(attribute) == AttributeRole::Colors; }))
  {
    return {};
  }
  for (const AttributeInfo& attribute : attributes)
  {
    const bool named = attribute.name == "red" || attribute.name == "r" ||
                       attribute.name == "diffuse_red" || attribute.name == "RGB" ||
                       attribute.name == "RGBA";
    if (named && attribute.association == AttributeAssociation::Cell)
    {
      return "colours of triangles are kept, but viewers show those of vertices alone";
    }
    if (named && attribute.type != AttributeType::UInt8)
    {
      return "colours of type " + std::string(NameOf(attribute.type)) +
             " are kept, but viewers show those of type uint8 alone";
    }
  }
  return {};
}

int Build(const CLI::App& app, CommandLine& line)
{
  const std::string& program = app.get_name();
  Status status = CheckLevelOptions(app, line);
  if (status)
  {
    status = Interpret(line);
  }
  if (!status)
  {
    return PrintError(program, "", status.GetError());
  }
  const Result<std::filesystem::path> store =
    CheckOutput(line.output, OutputKind::File, { line.input });
  if (!store)
  {
    return PrintError(program, line.output, store.GetError());
  }
  if (!line.stats.empty())
  {
    const auto stats = CheckOutput(line.stats, OutputKind::Stream, { line.input, line.output });
    if (!stats)
    {
      return PrintError(program, line.stats, stats.GetError());
    }
  }
  CatchInterrupts();
  std::vector<std::string> warnings;
  Result<BuildReport> report = Error{};
  {
    ProgressReporter progress(program, line.quiet);
    Execution execution = MakeTbbExecution(line.threads);
    execution.progress = std::ref(progress);
    report = BuildFrom(line, *store, execution, warnings);
  }
  ReleaseInterrupts();
  for (const std::string& warning : warnings)
  {
    std::cerr << program << ": warning: " << line.input << ": " << warning << "\n";
  }
  if (!report)
  {
    const bool output = report.GetError().code == ErrorCode::InputOutput;
    return PrintError(program, output ? line.output : line.input, report.GetError());
  }
  if (!report->ignoredAttributes.empty())
  {
    std::string names;
    for (const std::string& name : report->ignoredAttributes)
    {
      names += (names.empty() ? "" : ", ") + name;
    }
    std::cerr << program << ": warning: " << line.input
              << ": not carried by this version: " << names << "\n";
  }
  if (const std::string hidden = HiddenColors(report->info.attributes); !hidden.empty())
  {
    std::cerr << program << ": warning: " << line.input << ": " << hidden << "\n";
  }
  if (report->mergedByGrid * 100 > report->info.vertices)
  {
    std::cerr << program << ": warning: " << line.input << ": " << report->mergedByGrid << " of "
              << report->info.vertices << " vertices fall together with others on a grid of "
              << line.precision << " bits; more bits or --precision lossless keep them apart\n";
  }
  if (!line.stats.empty())
  {
    std::ofstream file(line.stats);
    file << StatsOf(line, *report).dump(2) << "\n";
    file.close();
    if (!file)
    {
      return PrintError(program, line.stats, { ErrorCode::InputOutput, "cannot be written" });
    }
  }
  return exitDone;
}

}

int main(int argc, char** argv)
{
  CommandLine line;
  CLI::App app(description, "kdstream-build");
  app.set_version_flag("--version", KDSTREAM_VERSION);
  AddOptions(app, line);
  return RunProgram(app, argc, argv, [&]() { return Build(app, line); });
}
