#include "filters/app/BuildCommand.h"

#include "filters/build/BuildMemory.h"
#include "filters/model/ModelJson.h"
#include "filters/outofcore/files/FreeMemory.h"
#include "filters/outofcore/journal/BuildFolder.h"

#include <sys/resource.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iostream>

namespace kdstream
{
namespace
{

// A --memory below this was meant with a unit.
constexpr std::uint64_t leastMeant = std::uint64_t{ 1 } << 20;

const CLI::Validator onOff = CLI::IsMember({ "on", "off" });

}

void AddBuildOptions(CLI::App& app, BuildCommand& line)
{
  app.add_option("INPUT", line.input, "the mesh")->required();
  app.add_option("-o,--output", line.output, "the store to write (NAME.kds)")->required();
  auto* size = app
                 .add_option("--vertices-per-partition", line.build.tree.verticesPerPartition,
                   "most vertices of a partition (kmeans: on average); a partition is never "
                   "divided: built out "
                   "of core, 65536 vertices take about 64M of --memory")
                 ->check(CLI::Range(1U, 1U << 20))
                 ->capture_default_str();
  app
    .add_option("--partitions", line.partitions,
      "number of partitions instead, at most the vertices: a power of two for kdtree, any for "
      "kmeans, about so many for octree; each must fit --memory, as above")
    ->check(CLI::Range(1U, 1U << 30))
    ->excludes(size);
  app
    .add_option("--partitioner", line.partitioner,
      "kdtree, or one of the baselines octree and kmeans: partitions only, for comparison; kmeans "
      "looks at all vertices again and again, so it is built in memory alone")
    ->check(CLI::IsMember({ "kdtree", "octree", "kmeans" }))
    ->capture_default_str();
  AddSizeOption(app, "--memory", line.build.memory,
    "most memory the build may take (K, M, G; at least 64M for what does not fit); a mesh that "
    "needs "
    "more is built out of core, by files in --temp-dir [75 % of free memory]");
  app
    .add_option("--temp-dir", line.build.temporaryFolder,
      "where files of a build out of core go; they take three to four times "
      "the bytes of a binary .ply of triangles [beside the store]")
    ->type_name("DIR")
    ->check(CLI::ExistingDirectory);
  app
    .add_option("--median", line.median, "how medians are found out of core: the same tree by all")
    ->check(CLI::IsMember({ "auto", "heaps", "torben", "sort", "histogram" }))
    ->capture_default_str();
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
  CheckText(app.add_option("--license,--licence", line.build.license, "shown by the viewers"));
  CheckText(app.add_option("--unit", line.build.unit, "of the coordinates, shown by the viewers"));
  app
    .add_option("--reconstruct", line.reconstruct,
      "make a surface of a point cloud first: greedy (joins the points) or poisson (a closed "
      "surface near them)")
    ->check(CLI::IsMember({ "greedy", "poisson" }));
  app.add_flag("--resume", line.build.resume,
    "go on with a killed build of the same input, options and --temp-dir from its last finished "
    "phase, with the same --memory or more, and say from which; what a build of another input or "
    "with other options has left is thrown away. Ctrl-C and errors remove what was done, a build "
    "in "
    "memory starts anew, and what kdstream-convert reads is converted again first");
  app.add_option("--stats", line.stats, "file for statistics (JSON)")->type_name("FILE");
  app.add_flag("--quiet", line.quiet, "no progress");
}

namespace
{

// Baselines have no levels: what shapes them must not be taken for granted.
Status CheckLevelOptions(const CLI::App& app, const BuildCommand& line)
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

}

Status Interpret(const CLI::App& app, BuildCommand& line)
{
  KDSTREAM_TRY(CheckLevelOptions(app, line));
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
  if (line.build.memory > 0 && line.build.memory < leastMeant)
  {
    return Error{ ErrorCode::InvalidArgument,
      "--memory: " + Mebibytes(line.build.memory) +
        " cannot hold any build; K, M or G may follow the number, as in 64M" };
  }
  if (line.build.memory == 0)
  {
    line.build.memory = FreeMemory() / 4 * 3;
  }
  else
  {
    ShareArenas();
  }
  line.build.median = *MedianMethodOfName(line.median);
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

namespace
{

std::string StatsOf(const BuildCommand& line, const BuildReport& report)
{
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  std::error_code status;
  const std::uintmax_t bytes = std::filesystem::file_size(line.output, status);
  ModelDescription model = report.info;
  model.input = line.input; // with its folder
  JsonWriter json({ 2 });
  json.BeginObject();
  PutStatistics(json, model, status ? 0 : bytes);
  json.Member("merged_by_grid", report.mergedByGrid)
    .Member("passes", report.passes)
    .Member("temp_bytes", report.temporaryBytes)
    .Member("temp_bytes_read", report.bytesRead)
    .Member("temp_bytes_written", report.bytesWritten)
    .Member("resumed_phases", report.resumedPhases)
    .Member("peak_rss_bytes", static_cast<std::uint64_t>(usage.ru_maxrss) * 1024)
    .Key("seconds")
    .BeginObject();
  for (const auto& [step, time] : report.seconds)
  {
    json.Member(step, time);
  }
  json.EndObject().EndObject();
  return json.Text();
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

}

std::vector<StepShare> SharesOfSteps(const BuildCommand& line)
{
  if (line.build.partitioner != Partitioner::KdTree)
  {
    return {};
  }
  // Measured on 28 million triangles; in memory and out of core differ by 5 % at most.
  return { { "read", 0.09 }, { "tree", 0.16 }, { "faces", 0.08 }, { "levels", 0.41 },
    { "encode", 0.26 } };
}

std::string FileAtFault(
  const BuildCommand& line, const std::filesystem::path& store, const Error& error)
{
  const std::filesystem::path build = BuildFolder::PathFor(store, line.build.temporaryFolder);
  const bool spill = error.message.find(build.string()) != std::string::npos ||
                     error.message.find("temporary folder") != std::string::npos;
  return spill                                  ? build.parent_path().string()
         : error.code == ErrorCode::InputOutput ? line.output
                                                : line.input;
}

Status CheckStoreName(const std::filesystem::path& store)
{
  if (store.extension() == ".kds" && !IsModelId(store.stem().string()))
  {
    return Error{ ErrorCode::InvalidArgument,
      "no server serves a store of this name: before .kds it needs " + std::string(modelIdRule) };
  }
  return {};
}

void WarnOfEnding(std::string_view program, const BuildCommand& line)
{
  if (std::filesystem::path(line.output).extension() != ".kds")
  {
    std::cerr << program << ": warning: " << line.output
              << ": kdstream-serve finds stores by the ending .kds\n";
  }
}

void PrintWarnings(std::string_view program, const BuildCommand& line, const BuildReport& report)
{
  if (!report.ignoredAttributes.empty())
  {
    std::string names;
    for (const std::string& name : report.ignoredAttributes)
    {
      names += (names.empty() ? "" : ", ") + name;
    }
    std::cerr << program << ": warning: " << line.input
              << ": not carried by this version: " << names << "\n";
  }
  if (const std::string hidden = HiddenColors(report.info.attributes); !hidden.empty())
  {
    std::cerr << program << ": warning: " << line.input << ": " << hidden << "\n";
  }
  if (report.mergedByGrid * 100 > report.info.vertices)
  {
    std::cerr << program << ": warning: " << line.input << ": " << report.mergedByGrid << " of "
              << report.info.vertices << " vertices fall together with others on a grid of "
              << line.precision << " bits; more bits or --precision lossless keep them apart\n";
  }
}

int WriteStats(std::string_view program, const BuildCommand& line, const BuildReport& report)
{
  if (!line.stats.empty())
  {
    std::ofstream file(line.stats);
    file << StatsOf(line, report) << "\n";
    file.close();
    if (!file)
    {
      return PrintError(program, line.stats, { ErrorCode::InputOutput, "cannot be written" });
    }
  }
  return exitDone;
}

}
