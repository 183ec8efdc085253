// SPDX-License-Identifier: BSD-3-Clause
#include "filters/app/BuildCommand.h"

#include "filters/app/ConvertedInput.h"
#include "filters/app/DirectionText.h"
#include "filters/app/ReadingOptions.h"
#include "filters/app/TextureOptions.h"
#include "filters/baselines/stores/Baselines.h"
#include "filters/build/BuildMemory.h"
#include "filters/files/WriteWhole.h"
#include "filters/meshio/ObjReader.h"
#include "filters/model/ModelJson.h"
#include "filters/outofcore/files/ReturnFreeMemory.h"
#include "filters/texture/FindTextures.h"

#include <sys/resource.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <limits>
#include <sstream>

namespace kdstream
{
namespace
{

// CLI::App::count would end the process if memory ran out.
bool IsGiven(const CLI::App& app, const std::string& name)
{
  const auto options = app.get_options();
  return std::any_of(options.begin(), options.end(),
    [&](const CLI::Option* option) { return option->check_name(name) && option->count() > 0; });
}

// If --memory is below this, a unit was probably forgotten.
constexpr std::uint64_t leastMeant = std::uint64_t{ 1 } << 20;

const CLI::Validator onOff = CLI::IsMember({ "on", "off" });

}

namespace
{

void AddPartitionOptions(CLI::App& app, BuildCommand& line)
{
  const char* const group = "Partitions";
  auto* size = app
                 .add_option("--vertices-per-partition", line.build.tree.verticesPerPartition,
                   "maximum vertices per partition (kmeans: average)")
                 ->check(CLI::Range(1U, 1U << 20))
                 ->capture_default_str()
                 ->group(group);
  app
    .add_option("--partitions", line.partitions,
      "number of partitions instead: a power of two for kdtree, any number for kmeans, approximate "
      "for octree")
    ->check(CLI::Range(1U, 1U << 30))
    ->type_name("K")
    ->excludes(size)
    ->group(group);
  app
    .add_option("--partitioner", line.partitioner,
      "how partitions are made; octree and kmeans make no levels and serve for comparison; kmeans "
      "works only in memory")
    ->check(CLI::IsMember({ "kdtree", "octree", "kmeans" }))
    ->capture_default_str()
    ->group(group);
}

void AddLevelOptions(CLI::App& app, BuildCommand& line)
{
  const char* const group = "Levels";
  app
    .add_option("--levels", line.maker,
      "how coarser levels are made: by edge collapse, or by vertex clustering, which is faster but "
      "less accurate")
    ->check(CLI::IsMember({ "collapse", "cluster" }))
    ->capture_default_str()
    ->group(group);
  app
    .add_option("--representative", line.representative,
      "position of a cluster's vertex: where the quadric error is smallest, or the mean of its "
      "vertices")
    ->check(CLI::IsMember({ "quadric", "mean" }))
    ->capture_default_str()
    ->group(group);
  app
    .add_option("--sheets", line.sheets,
      "on: one vertex for each connected component in a cell; off: one for each cell")
    ->check(onOff)
    ->capture_default_str()
    ->group(group);
  app
    .add_option("--cell-vertices", line.build.tree.cellVertices,
      "maximum original vertices per cell of the finest level")
    ->check(CLI::Range(1U, 1024U))
    ->capture_default_str()
    ->group(group);
}

void AddMemoryOptions(CLI::App& app, BuildCommand& line)
{
  const char* const group = "Memory and speed";
  AddSizeOption(app, "--memory", line.build.memory,
    "memory limit, at least 64M for a build out of core; a mesh that may need more is built "
    "with temporary files")
    ->default_str("75 % of free memory")
    ->group(group);
  app
    .add_option("--temp-dir", line.build.temporaryFolder,
      "folder for temporary files; they need three to four times the size of a binary .ply")
    ->type_name("DIR")
    ->default_str("the store's folder")
    ->group(group);
  app
    .add_option(
      "--threads", line.threads, "number of threads; the store is the same for any number")
    ->check(CLI::Range(1U, 1024U))
    ->default_str("all")
    ->group(group);
  app
    .add_option("--median", line.median,
      "how medians are found in temporary files; the tree is the same for all methods")
    ->check(CLI::IsMember({ "auto", "heaps", "torben", "sort", "histogram" }))
    ->capture_default_str()
    ->group(group);
  app
    .add_flag("--resume", line.build.resume,
      "continue a killed build of the same input and options after its last finished phase")
    ->group(group);
}

void AddTextOptions(CLI::App& app, BuildCommand& line)
{
  const char* const group = "Description (shown by viewers)";
  CheckText(app.add_option("--title", line.build.title, "title of the model"))->group(group);
  CheckText(app.add_option("--description", line.build.description, "a few lines about the model"))
    ->group(group);
  CheckText(app.add_option("--credit", line.build.credit, "who made or scanned it"))->group(group);
  const std::string license = "terms of use";
  CheckText(app.add_option("--license", line.build.license, license))->group(group);
  CheckText(app.add_option("--licence", line.build.license, license))->group(""); // also accepted
  CheckText(app.add_option("--unit", line.build.unit, "unit of the coordinates, such as mm"))
    ->group(group);
}

void AddHomeViewOptions(CLI::App& app, BuildCommand& line)
{
  const char* const group = "Initial view";
  AddDirectionOption(app, "--up", line.build.up, "upward direction")
    ->default_str("guessed")
    ->group(group);
  AddDirectionOption(app, "--view", line.build.view, "direction from the model's centre to the eye")
    ->default_str("guessed")
    ->group(group);
}

}

void AddBuildOptions(CLI::App& app, BuildCommand& line)
{
  app.add_option("INPUT", line.input, "the mesh or point cloud")->required();
  app
    .add_option("--reconstruct", line.reconstruct,
      "reconstruct a surface from a point cloud: greedy connects its points; poisson makes a "
      "closed surface near them")
    ->check(CLI::IsMember({ "greedy", "poisson" }))
    ->group("Input");
  AddTextureOptions(app, { "on", "off", "colors", "tiles" },
    "on, tiles: keep textures for the original, one tile per partition, and bake them to vertex "
    "colours for the levels; colors: only vertex colours; off: ignore textures. The whole mesh is "
    "in memory while textures are read",
    line.textures, line.texturePixels);
  app
    .add_option("--texture-quality", line.textureQuality,
      "WebP quality of the original's texture tiles, 1 to 100 (those of levels: 4 less); lossless "
      "keeps the original's texels and texture coordinates exactly")
    ->type_name("1-100|lossless")
    ->capture_default_str()
    ->group("Output");
  app
    .add_option("--weld", line.weld,
      "merge vertices whose position and attributes are identical; always done for .stl")
    ->check(onOff)
    ->capture_default_str()
    ->group("Input");
  AddStrictOption(app, line.build.strict)->group("Input");
  AddColumnsOption(app, line.columns)->group("Input");
  app.add_option("-o,--output", line.output, "the store to write")
    ->required()
    ->type_name("STORE.kds")
    ->group("Output");
  app
    .add_option("--precision", line.precision,
      "bits per axis of the model's box, 8 to 24, or lossless for the exact coordinates")
    ->type_name("BITS|lossless")
    ->capture_default_str()
    ->group("Output");
  app.add_option("--stats", line.stats, "write statistics to this file (JSON)")
    ->type_name("FILE")
    ->group("Output");
  app.add_flag("--quiet", line.quiet, "print no progress and no summary")->group("Output");
  AddPartitionOptions(app, line);
  AddLevelOptions(app, line);
  AddMemoryOptions(app, line);
  AddTextOptions(app, line);
  AddHomeViewOptions(app, line);
}

namespace
{

// Baselines have no levels. An option about levels is refused, so that nobody believes that it had
// an effect.
Status CheckLevelOptions(const CLI::App& app, const BuildCommand& line)
{
  for (const char* name : { "--levels", "--representative", "--sheets", "--cell-vertices" })
  {
    if (line.partitioner != "kdtree" && IsGiven(app, name))
    {
      return Error{ ErrorCode::InvalidArgument,
        std::string(name) + ": a store by --partitioner " + line.partitioner + " has no levels" };
    }
  }
  return {};
}

// A whole number of at most three digits.
std::optional<unsigned> SmallNumber(const std::string& text)
{
  const bool digits =
    !text.empty() && text.size() <= 3 &&
    std::all_of(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; });
  return digits ? std::optional(static_cast<unsigned>(std::stoi(text))) : std::nullopt;
}

Status InterpretQuality(BuildCommand& line)
{
  const unsigned quality =
    line.textureQuality == "lossless" ? 0 : SmallNumber(line.textureQuality).value_or(101);
  if (quality > 100 || (quality == 0 && line.textureQuality != "lossless"))
  {
    return Error{ ErrorCode::InvalidArgument,
      "--texture-quality: \"" + line.textureQuality +
        "\" is neither a number from 1 to 100 nor lossless" };
  }
  line.tiles.quality = quality;
  return {};
}

// Refuses options that would have no effect.
Status CheckTextureOptions(const CLI::App& app, BuildCommand& line)
{
  line.qualityGiven = IsGiven(app, "--texture-quality");
  line.pixelsGiven = IsGiven(app, "--texture-pixels");
  if (line.qualityGiven && !line.WantsTiles())
  {
    return Error{ ErrorCode::InvalidArgument,
      "--texture-quality needs --textures on or tiles: the original has no textures with " +
        line.textures };
  }
  return CheckTexturePixels(app, line.textures);
}

// Checks --temp-dir, which may be empty.
Status CheckFolder(const std::filesystem::path& folder)
{
  std::error_code status;
  if (folder.empty() || std::filesystem::is_directory(folder, status))
  {
    return {};
  }
  return Error{ ErrorCode::NotFound,
    std::filesystem::exists(folder, status) ? "is a file, not a folder" : "there is no such folder",
    folder.string() };
}

}

Status Interpret(const CLI::App& app, BuildCommand& line)
{
  KDSTREAM_TRY(CheckLevelOptions(app, line));
  KDSTREAM_TRY(CheckTextureOptions(app, line));
  KDSTREAM_TRY(CheckColumns(line.columns, line.input));
  if (line.partitions > 0)
  {
    line.build.tree.partitions = line.partitions;
  }
  if (line.partitioner == "kdtree" && line.partitions > 0 && !std::has_single_bit(line.partitions))
  {
    return Error{ ErrorCode::InvalidArgument,
      "--partitions: " + std::to_string(line.partitions) + " is not a power of two" };
  }
  line.build.partitioner = PartitionMethodOfName(line.partitioner);
  line.build.levels.maker = line.maker == "collapse" ? LevelMaker::Collapse : LevelMaker::Cluster;
  line.build.weld = line.weld == "on";
  line.build.levels.byComponents = line.sheets == "on";
  line.build.levels.representative =
    line.representative == "mean" ? Representative::Mean : Representative::Quadric;
  if (line.build.memory > 0 && line.build.memory < leastMeant)
  {
    return Error{ ErrorCode::InvalidArgument,
      "--memory: " + Mebibytes(line.build.memory) +
        " is too small for any build; did you forget the unit, as in 64M?" };
  }
  if (line.build.memory == 0)
  {
    line.build.memory = FreeMemory() / 4 * 3;
  }
  else
  {
    ShareArenas();
  }
  KDSTREAM_TRY(CheckFolder(line.build.temporaryFolder));
  KDSTREAM_TRY(InterpretQuality(line));
  line.build.median = MedianMethodOfName(line.median);
  if (line.precision == "lossless")
  {
    line.build.bits = 0;
    return {};
  }
  const unsigned bits = SmallNumber(line.precision).value_or(0);
  if (bits < 8 || bits > 24)
  {
    return Error{ ErrorCode::InvalidArgument,
      "--precision: \"" + line.precision +
        "\" is neither a number of bits from 8 to 24 nor lossless" };
  }
  line.build.bits = static_cast<std::uint8_t>(bits);
  return {};
}

namespace
{

// The peak memory in bytes of this process, or of its children that have ended.
std::uint64_t PeakMemory(int who)
{
  rusage usage{};
  getrusage(who, &usage);
  return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;
}

std::string StatsOf(const BuildCommand& line, const BuildReport& report)
{
  const std::uint64_t own = PeakMemory(RUSAGE_SELF);
  const std::uint64_t converted = line.converts ? PeakMemory(RUSAGE_CHILDREN) : 0;
  std::error_code status;
  const std::uintmax_t bytes = std::filesystem::file_size(line.output, status);
  ModelDescription model = report.info;
  model.input = line.input; // with its folder
  JsonWriter json({ 2 });
  json.BeginObject();
  PutStatistics(json, model, status ? 0 : bytes);
  json.Key("forgiven").BeginObject();
  for (std::size_t k = 0; k < lapseKinds; ++k)
  {
    const auto kind = static_cast<Lapse>(k);
    json.Member(Tolerance::KeyOf(kind), report.tolerance.Of(kind));
  }
  json.EndObject();
  json.Member("merged_by_grid", report.mergedByGrid)
    .Member("passes", report.passes)
    .Member("temp_bytes", report.temporaryBytes)
    .Member("temp_bytes_read", report.bytesRead)
    .Member("temp_bytes_written", report.bytesWritten)
    .Member("resumed_phases", report.resumedPhases)
    .Member("peak_rss_bytes", std::max(own, converted));
  if (line.converts)
  {
    json.Member("convert_peak_rss_bytes", converted);
  }
  json.Key("seconds").BeginObject();
  for (const auto& [step, time] : report.seconds)
  {
    json.Member(step, time);
  }
  json.EndObject();
  if (line.baked)
  {
    json.Key("textures")
      .BeginObject()
      .Member("pictures", line.baked->pictures)
      .Member("texels", line.baked->texels)
      .Member("texels_per_vertex", line.baked->texelsPerVertex)
      .Member("loss", line.baked->loss);
    if (line.tiled)
    {
      json.Member("halved_tiles", line.tiled->halved)
        .Member("repeating_triangles", line.tiled->repeating);
    }
    json.EndObject();
  }
  json.EndObject();
  return json.Text();
}

// If a model has no colours that viewers show: why the colours that it has are not shown. Empty if
// it has none.
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
    const bool looksSo = attribute.type == AttributeType::UInt8 &&
                         (attribute.components == 3 || attribute.components == 4);
    if ((named || looksSo) && attribute.association == AttributeAssociation::Cell)
    {
      return "triangle colours are kept, but viewers show only vertex colours";
    }
    if (named && attribute.type != AttributeType::UInt8)
    {
      return "colours of type " + std::string(NameOf(attribute.type)) +
             " are kept, but viewers show only colours of type uint8";
    }
  }
  return {};
}

}

std::vector<StepShare> SharesOfSteps(const BuildCommand& line)
{
  if (!line.build.partitioner->HasLevels())
  {
    return {};
  }
  // Measured on 28 million triangles. The shares in memory and out of core differ by at most 5 %.
  return { { "read", 0.09 }, { "tree", 0.15 }, { "faces", 0.07 }, { "levels", 0.42 },
    { "encode", 0.25 }, { "write", 0.02 } };
}

void TellAmounts(BuildCommand& line, ProgressReporter& progress)
{
  std::error_code failed;
  const std::uintmax_t bytes = std::filesystem::file_size(line.input, failed);
  if (!failed && !line.converts)
  {
    progress.SetAmount("read", { double(bytes), "B" });
  }
  line.build.tellSize = [&progress](std::uint64_t vertices, std::uint64_t triangles)
  {
    progress.SetAmount("", triangles > 0 ? StepAmount{ double(triangles), "triangles" }
                                         : StepAmount{ double(vertices), "vertices" });
  };
}

std::vector<std::string> ChooseReader(BuildCommand& line)
{
  line.converts = !line.reconstruct.empty() || NeedsConversion(line.input);
  if (line.converts || line.textures == "off")
  {
    return {};
  }
  // If the input cannot be read, the build reports the error.
  Result<FoundTextures> found = FindTextures(line.input);
  if (const auto why = found && found->any
                         ? WhyNoPictures(found->colors ? "colours of materials" : "pictures")
                         : std::nullopt)
  {
    return { *why };
  }
  line.converts = found && found->any;
  line.plainMaterials = found && found->isPlain;
  return found ? std::move(found->warnings) : std::vector<std::string>{};
}

std::string MemoryOfConversion(const BuildCommand& line)
{
  if (!line.converts || !line.reconstruct.empty() || NeedsConversion(line.input))
  {
    return {};
  }
  // Measured on statues of 250,000 and one million vertices: 2.8 and 1.7 times the size of the
  // .obj.
  constexpr double memoryPerByte = 2;
  std::error_code failed;
  const double bytes = memoryPerByte * double(std::filesystem::file_size(line.input, failed));
  return failed || bytes <= double(line.build.memory)
           ? std::string()
           : "kdstream-convert reads the whole file, which takes about " + BytesText(bytes) +
               " in addition to --memory";
}

Status CheckStoreName(const std::filesystem::path& store)
{
  const std::string name = store.filename().string(), ending = ".kds";
  if (name.empty())
  {
    return Error{ ErrorCode::InvalidArgument, "--output: the store needs a name before .kds" };
  }
  if (name.ends_with(ending) && !IsModelId(name.substr(0, name.size() - ending.size())))
  {
    return Error{ ErrorCode::InvalidArgument,
      "a server cannot serve a store of this name: before .kds it must have " +
        std::string(modelIdRule) };
  }
  return {};
}

void WarnOfEnding(std::string_view program, const BuildCommand& line)
{
  if (std::filesystem::path(line.output).extension() != ".kds")
  {
    std::cerr << program << ": warning: " << line.output
              << ": kdstream-serve only serves files that end in .kds\n";
  }
}

namespace
{

// The distance between neighbouring floats at the distance of the box's farthest corner from 0.
double StepOfFloats(const Box& box)
{
  float farthest = 0;
  for (std::size_t k = 0; k < 3; ++k)
  {
    farthest = std::max({ farthest, float(std::abs(box.lo[k])), float(std::abs(box.hi[k])) });
  }
  return double(std::nextafter(farthest, std::numeric_limits<float>::infinity()) - farthest);
}

// The distance between vertices if they were spread over the two longest sides of the box. This is
// about the maximum for a surface that fills the box.
double SpacingOfVertices(const Box& box, std::uint64_t vertices)
{
  std::array<double, 3> sides;
  for (std::size_t k = 0; k < 3; ++k)
  {
    sides[k] = box.hi[k] - box.lo[k];
  }
  std::sort(sides.begin(), sides.end());
  return std::sqrt(sides[2] / double(vertices) * sides[1]);
}

// Floats far from 0 are far apart, so that a surface gets steps: half a metre for map coordinates
// in metres, whose northing is in the millions. Returns a warning; empty if floats are fine enough.
std::string CoarseFloats(const BuildReport& report, const std::string& unit)
{
  constexpr double mostOfSpacing = 0.125; // larger steps are visible
  const Box& box = report.info.box;
  const double step = StepOfFloats(box);
  const double spacing = SpacingOfVertices(box, report.info.vertices); // 0: only points or lines
  if (report.scalarType != ScalarType::Float32 || spacing == 0 || step <= mostOfSpacing * spacing)
  {
    return {};
  }
  std::ostringstream text;
  text << "the coordinates are so far from 0 that floats only hold multiples of " << step
       << (unit.empty() ? "" : " " + unit)
       << ": if they were rounded, the surface shows steps; subtract an offset before writing "
          "floats, or write doubles";
  return text.str();
}

std::string StrayText(const StrayPoint& stray)
{
  std::ostringstream text;
  text.precision(10);
  text << "point " << stray.number << " at (" << stray.place[0] << ", " << stray.place[1] << ", "
       << stray.place[2] << ") is so far from all others that the grid is "
       << std::llround(std::min(stray.shrinks, 1e15))
       << " times as coarse with it; remove it from the input if it does not belong there, else "
          "use more bits or --precision lossless";
  return text.str();
}

// Why an option for textures has no effect.
std::string NoPictures(const BuildCommand& line)
{
  return line.baked ? "the original has no textures" : "no textures were read";
}

void PrintWarningsOf(const BuildReport& report, std::string_view program, const BuildCommand& line)
{
  for (const auto& [option, vain] :
    { std::pair{ "--texture-quality", line.qualityGiven && !line.tiled },
      { "--texture-pixels", line.pixelsGiven && !line.baked } })
  {
    if (vain)
    {
      std::cerr << program << ": warning: " << line.input << ": " << option
                << " has no effect: " << NoPictures(line) << "\n";
    }
  }
  PrintWarnings(program, line, report.tolerance.Warnings());
  std::string names;
  for (const std::string& name : report.ignoredAttributes)
  {
    const bool unwanted =
      (line.textures == "off" || line.plainMaterials) && name == objMaterialsName;
    names += unwanted ? "" : (names.empty() ? "" : ", ") + name;
  }
  if (!names.empty())
  {
    std::cerr << program << ": warning: " << line.input
              << ": not supported by this version and left out: " << names << "\n";
  }
  if (const std::string hidden = HiddenColors(report.info.attributes); !hidden.empty())
  {
    std::cerr << program << ": warning: " << line.input << ": " << hidden << "\n";
  }
  if (const std::string coarse = CoarseFloats(report, line.build.unit); !coarse.empty())
  {
    std::cerr << program << ": warning: " << line.input << ": " << coarse << "\n";
  }
  if (report.info.unused)
  {
    std::cerr << program << ": warning: " << line.input << ": " << UnusedText(report.info)
              << ": kept in the original, not shown\n";
  }
  if (LosesBits(report))
  {
    std::cerr << program << ": warning: " << line.input << ": " << report.mergedByGrid << " of "
              << report.info.vertices << " vertices coincide with others on a grid of "
              << line.precision << " bits"
              << (line.stray ? ": " + StrayText(*line.stray)
                             : "; use more bits or --precision lossless to keep them apart")
              << "\n";
  }
}

std::string LastWords(const BuildOptions& options, const BuildReport& report)
{
  const std::optional<HomeView>& homeView = report.info.homeView;
  std::string words = report.tolerance.Summary();
  if (homeView && homeView->guessed)
  {
    const std::string up = "up is " + DirectionText(homeView->up);
    const std::string front = "front is " + DirectionText(homeView->view);
    words += (words.empty() ? "guessed that " : ", guessed that ") +
             (options.up      ? front + " (--view changes it)"
               : options.view ? up + " (--up changes it)"
                              : up + " and " + front + " (--up and --view change it)");
  }
  return words;
}

int WriteStats(std::string_view program, const BuildCommand& line, const BuildReport& report)
{
  if (!line.stats.empty())
  {
    const auto place = CheckOutput(line.stats, OutputKind::Stream, {});
    const Status written =
      place ? WriteToOutput(*place, StatsOf(line, report) + "\n") : Status(place.GetError());
    if (!written)
    {
      return PrintError(program, line.stats, written.GetError());
    }
  }
  return exitDone;
}

}

bool LosesBits(const BuildReport& report)
{
  return report.mergedByGrid * 100 > report.info.vertices;
}

void PrintWarnings(
  std::string_view program, const BuildCommand& line, const std::vector<std::string>& warnings)
{
  for (const std::string& warning : warnings)
  {
    std::cerr << program << ": warning: " << line.input << ": " << warning << "\n";
  }
}

int FinishBuild(std::string_view program, const BuildCommand& line, const BuildReport& report,
  std::chrono::steady_clock::time_point begin)
{
  PrintWarningsOf(report, program, line);
  if (!line.quiet)
  {
    if (line.baked && line.tiled)
    {
      std::cerr << program << ": note: " << line.input << ": " << line.baked->TellLevels() << "\n";
    }
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
    PrintWritten(program, line.output, LastWords(line.build, report), seconds.count());
  }
  return WriteStats(program, line, report);
}

}
