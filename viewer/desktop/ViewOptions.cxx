// SPDX-License-Identifier: BSD-3-Clause
// The command line of kdstream-view: see ViewOptions.h.
#include "viewer/desktop/ViewOptions.h"

#include "filters/core/SystemReason.h"
#include "filters/files/WriteWhole.h"
#include "filters/model/ModelDescription.h"
#include "viewer/desktop/SettingSteps.h"
#include "viewer/offscreen/OffscreenWindow.h"

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <limits>
#include <map>
#include <set>

namespace kdstream
{
namespace
{

constexpr std::uint64_t leastViewMemory = std::uint64_t{ 16 } << 20;

// Parses a size such as "1280x720". Returns an empty text, or what is wrong.
std::string ParseWindowSize(const std::string& text, int& width, int& height)
{
  char rest = 0;
  const bool parsed = std::sscanf(text.c_str(), "%5dx%5d%c", &width, &height, &rest) == 2;
  const bool inRange =
    width >= 1 && width <= largestWindowSide && height >= 1 && height <= largestWindowSide;
  return parsed && inRange ? std::string()
                           : "'" + text + "' is not a size: give WxH, each 1 to " +
                               std::to_string(largestWindowSide) + " pixels";
}

// For an option whose values have names. CLI11's CheckedTransformer would also list the numeric
// values.
template <class Value>
CLI::Validator NamedValue(const std::map<std::string, Value>& values)
{
  return CLI::Validator(
    [values](std::string& text)
    {
      const std::string wrong = CLI::IsMember(values)(text);
      return wrong.empty() ? CLI::Transformer(values)(text) : wrong;
    },
    "");
}

void AddPictureOptions(CLI::App& app, ViewOptions& line)
{
  const char* const group = "Picture";
  app
    .add_option("--offscreen", line.offscreen,
      "open no window: load the model or play a session file, write the requested files, and exit; "
      "auto: the first backend that works")
    ->check(CLI::IsMember({ "auto", "egl", "osmesa", "x11" }))
    ->group(group);
  app
    .add_option_function<std::string>(
      "--size",
      [&line](const std::string& text)
      {
        const std::string wrong = ParseWindowSize(text, line.width, line.height);
        if (!wrong.empty())
        {
          throw CLI::ValidationError("--size", wrong);
        }
      },
      "size of the picture in pixels")
    ->type_name("WxH")
    ->default_str("1280x720")
    ->group(group);
  const std::map<std::string, bool> lights{ { "relief", true }, { "plain", false } };
  app
    .add_option("--light", line.occlusion,
      "relief: ambient occlusion, which shows fine relief (in a slow window only while the view "
      "rests); plain: only lights")
    ->transform(NamedValue(lights))
    ->type_name("relief|plain")
    ->default_str("relief")
    ->group(group);
  app.add_option("--screenshot", line.screenshot, "write the final picture (NAME.png)")
    ->check(CLI::Validator(CheckPicture, ""))
    ->type_name("FILE")
    ->group(group);
}

// text: "own", …, or the name of an array, also in the form that links have ("by:NAME").
ColorChoice ColorsOf(const std::string& text, ColorChoice colors)
{
  const auto known = ParseColors(text);
  colors.coloring = known ? known->coloring : SurfaceColoring::Attribute;
  colors.attribute = known ? known->attribute : text;
  return colors;
}

void AddColorOptions(CLI::App& app, ViewOptions& line)
{
  const char* const group = "Picture";
  const auto take = [&line](const std::string& text)
  {
    if (!IsAttributeName(text))
    {
      throw CLI::ValidationError("--colour-by", "'" + text + "' cannot be an array's name");
    }
    line.colors = ColorsOf(text, line.colors);
  };
  CLI::Option* const by = app.add_option_function<std::string>("--colour-by,--color-by", take,
    "colours of the surface: own (the model's, if it has any), none, one per partition or "
    "resolution, or the values of the array NAME (kdstream-store info lists arrays)");
  by->type_name("own|none|partition|resolution|NAME")->default_str("own")->group(group);
  std::map<std::string, ColorMap> maps;
  for (const ColorMap map : allColorMaps)
  {
    maps[std::string(NameOf(map))] = map;
  }
  app
    .add_option("--colour-map,--color-map", line.colors.map,
      "colour map for the array's values; diverging: for values on either side of the middle")
    ->transform(NamedValue(maps))
    ->type_name("viridis|cividis|diverging")
    ->default_str("viridis")
    ->needs(by)
    ->group(group);
  app
    .add_option_function<std::string>(
      "--colour-range,--color-range",
      [&line](const std::string& text)
      {
        line.colors.range = ParseRange(text, ',');
        if (!line.colors.range)
        {
          throw CLI::ValidationError("--colour-range",
            "'" + text + "' is not LOW,HIGH: give two numbers, the smaller one first");
        }
      },
      "array values at the ends of the colour map [default: the 2nd and the 98th percentile]")
    ->type_name("LOW,HIGH")
    ->needs(by)
    ->group(group);
  const std::map<std::string, bool> switches{ { "on", true }, { "off", false } };
  app
    .add_option("--legend", line.legend,
      "draw a legend into the picture of --screenshot, where the colours show an array")
    ->transform(NamedValue(switches))
    ->type_name("on|off")
    ->default_str("on")
    ->group(group);
}

void AddDetailOptions(CLI::App& app, ViewOptions& line)
{
  const char* const group = "Detail";
  const std::map<std::string, DetailMode> modes{ { "view", DetailMode::View },
    { "level", DetailMode::Level }, { "full", DetailMode::Full } };
  app
    .add_option("--detail", line.detail,
      "view: what the camera sees, with the detail that the window would show; level: one level "
      "for the whole model, chosen by the zoom; full: the whole original, at any cost")
    ->transform(NamedValue(modes))
    ->type_name("view|level|full")
    ->default_str("view")
    ->group(group);
  app
    .add_option("--triangles", line.triangles,
      "maximum triangles to show, approximately (the preview may have more); not with --detail "
      "full")
    ->check(CLI::Range(std::uint64_t{ 1000 }, std::uint64_t{ 1'000'000'000 }))
    ->type_name("N")
    ->capture_default_str()
    ->group(group);
  app
    .add_option_function<std::string>(
      "--view-memory",
      [&line](const std::string& text)
      {
        const auto size = ParseSize(text);
        if (!size || *size < leastViewMemory)
        {
          throw CLI::ValidationError("--view-memory",
            size ? "'" + text + "' is less than 16M, which the coarsest view may need"
                 : size.GetError().message);
        }
        line.memory = *size;
      },
      "maximum memory for decoded pieces and their geometry, approximately; not with --detail full")
    ->type_name("SIZE")
    ->default_str("1G")
    ->group(group);
}

void AddSessionFiles(CLI::App& app, ViewOptions& line)
{
  const char* const session = "Session";
  app.add_option("--replay", line.replay, "play this session file")
    ->type_name("FILE")
    ->group(session);
  app.add_option("--record", line.record, "record the session to this file")
    ->type_name("FILE")
    ->group(session);
  app
    .add_option("--stats", line.statistics,
      "write JSON at the end: vertices, triangles, bytes and seconds of each blob")
    ->type_name("FILE")
    ->group(session);
  app
    .add_option("--report", line.report,
      "write JSON at the end: bytes, seconds, triangles and memory in total")
    ->type_name("FILE")
    ->group(session);
}

void AddCacheOptions(CLI::App& app, ViewOptions& line)
{
  const char* const group = "Cache";
  app
    .add_option("--cache", line.cache,
      "folder that caches stores of meshes and data from servers [default: kdstream in "
      "XDG_CACHE_HOME or ~/.cache; with --offscreen or --replay, no data from servers]")
    ->type_name("DIR")
    ->group(group);
  AddSizeOption(app, "--cache-size", line.cacheBytes,
    "maximum size for each of the two; the least recently used data is removed first")
    ->default_str("10G")
    ->group(group);
}

}

void AddViewOptions(CLI::App& app, ViewOptions& line)
{
  app
    .add_option("SOURCE", line.source,
      "a server, http://HOST:PORT or https://HOST:PORT; or a store (.kds), a folder of stores, or "
      "a mesh, which is first built into a store")
    ->required();
  app
    .add_option(
      "--token", line.token, "token for a server that requires one [default: $KDSTREAM_TOKEN]")
    ->envname("KDSTREAM_TOKEN")
    ->type_name("TOKEN");
  app
    .add_option("--ca", line.authorities,
      "trust servers whose certificate is signed by one in this PEM file [default: the system's "
      "certificates]")
    ->type_name("FILE");
  const char* const model = "Model";
  app
    .add_option(
      "--model", line.model, "name of the model [default: the only one; a window shows all]")
    ->type_name("ID")
    ->group(model);
  app
    .add_option("--rings", line.rings,
      "radius around a double tap in which the original is streamed, in cells")
    ->check(CLI::Range(1u, 3u))
    ->capture_default_str()
    ->group(model);
  AddDetailOptions(app, line);
  AddPictureOptions(app, line);
  AddColorOptions(app, line);
  AddSessionFiles(app, line);
  AddCacheOptions(app, line);
}

SessionOptions SessionOptionsOf(const ViewOptions& line)
{
  SessionOptions options;
  options.rings = line.rings;
  options.turning = Turning::Free; // until a session file says otherwise
  options.detail = line.detail;
  options.TakeShares(SharesOfBudgets(line.triangles, line.memory));
  options.refinement.smallModel = line.triangles / 8;
  options.clock = []
  {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch())
      .count();
  };
  if (!line.statistics.empty())
  {
    options.mostStatistics = std::numeric_limits<std::size_t>::max(); // all of them, as requested
  }
  return options;
}

Error NoWindow(const Error& why)
{
  return { why.code,
    "no window can be opened: " + why.message + "; use --offscreen auto to draw without a window" };
}

std::string CheckPicture(const std::string& file)
{
  std::string ending = std::filesystem::path(file).extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
    [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return ending == ".png" ? "" : "'" + file + "' must end in .png: pictures are written as PNG";
}

// Splits the address of a model's page (http://HOST/m/ID) into the server and the model to show.
void TakePage(ViewOptions& options)
{
  auto& source = options.source;
  const auto end = std::min(source.find_first_of("?#"), source.size());
  const auto last = end > 0 && source[end - 1] == '/' ? end - 1 : end;
  constexpr std::string_view folder = "/m/";
  const auto begin = source.substr(0, last).rfind(folder);
  const bool isWeb = source.starts_with("http://") || source.starts_with("https://");
  if (!isWeb || begin == std::string::npos)
  {
    return;
  }
  const auto model = source.substr(begin + folder.size(), last - begin - folder.size());
  if (!IsModelId(model))
  {
    return;
  }
  source.erase(begin, end - begin);
  if (options.model.empty())
  {
    options.model = model;
  }
}

Status TakeLink(ViewOptions& options)
{
  TakePage(options);
  const std::size_t hash = options.source.find("#model=");
  std::error_code failure;
  if (hash == std::string::npos || std::filesystem::exists(options.source, failure))
  {
    return {};
  }
  options.link = options.source.substr(hash + 1);
  options.source.resize(hash);
  const auto link = ParseViewLink(options.link);
  KDSTREAM_TRY(link);
  if (!options.replay.empty())
  {
    return Error{ ErrorCode::InvalidArgument,
      "a link to a view cannot be combined with --replay: the session file sets the view" };
  }
  if (!options.model.empty() && options.model != link->model)
  {
    return Error{ ErrorCode::InvalidArgument,
      "the link shows a view of '" + link->model + "', not of --model " + options.model };
  }
  options.model = link->model;
  SceneSettings scene{ options.colors, options.occlusion };
  Perform({ SessionStep::Kind::Colors, {}, link->colors }, scene);
  Perform({ SessionStep::Kind::Light, {}, link->light }, scene);
  options.colors = scene.colors;
  options.occlusion = link->light.empty() ? options.occlusion : scene.occlusion;
  return {};
}

Status CheckOutputs(ViewOptions& line)
{
  const std::pair<std::string*, OutputKind> outputs[] = { { &line.record, OutputKind::Stream },
    { &line.statistics, OutputKind::Stream }, { &line.report, OutputKind::Stream },
    { &line.screenshot, OutputKind::File } };
  std::set<std::string> files;
  for (const auto& [file, kind] : outputs)
  {
    if (file->empty())
    {
      continue;
    }
    const auto output = At(*file, CheckOutput(*file, kind, { line.replay }));
    KDSTREAM_TRY(output);
    std::error_code failure;
    const bool isDevice = std::filesystem::exists(*output, failure) &&
                          !std::filesystem::is_regular_file(*output, failure);
    if (!isDevice && !files.insert(std::filesystem::absolute(*output).lexically_normal()).second)
    {
      return Error{ ErrorCode::InvalidArgument, *file + ": two outputs cannot have the same file" };
    }
    *file = output->string();
  }
  return {};
}

Status WriteOutput(const std::string& file, const std::string& text)
{
  return file.empty() ? Status{} : WriteToOutput(file, text);
}

}
