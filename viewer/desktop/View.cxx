// SPDX-License-Identifier: BSD-3-Clause
// kdstream-view: looks at the models of a server. The contract is doc/cli.md#kdstream-view.
#include "filters/core/SystemReason.h"
#include "filters/program/Program.h"
#include "viewer/desktop/Player.h"
#include "viewer/desktop/ViewReport.h"

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <limits>
#include <map>
#include <memory>
#include <set>

namespace
{

using namespace kdstream;

constexpr const char* description =
  "Looks at a model of a KdStream server without a screen: this version opens no window yet.\n"
  "It shows the model as fine as the window shows it, or plays a recorded session "
  "(--replay), writes what is asked for, and ends.";

constexpr const char* examples =
  "A session file has one JSON object a line:\n"
  "  {\"select\":\"MODEL\"}          show its preview; again, or a tap: full screen\n"
  "  {\"wait\":\"idle\"}             until everything that was asked for has come\n"
  "  {\"screenshot\":\"NAME.png\"}   write what is shown\n"
  "  {\"t\":0.25,\"touches\":[{\"id\":1,\"x\":640,\"y\":360}]}\n"
  "                               the fingers on the screen at that time (seconds, pixels)\n"
  "One finger turns, two move and zoom, a double tap streams the original under it.\n\n"
  "Example:\n"
  "  kdstream-view http://localhost:8700 --model dragon --offscreen auto --screenshot dragon.png";

constexpr std::uint64_t leastViewMemory = std::uint64_t{ 16 } << 20;

struct CommandLine
{
  std::string url, model, offscreen, size = "1280x720", record, replay, screenshot, statistics,
                                     report;
  unsigned rings = 1;
  DetailMode detail = DetailMode::View;
  std::uint64_t triangles = RefinementOptions().triangles;
  std::uint64_t memory = std::uint64_t{ 1 } << 30;
  SurfaceColoring coloring = SurfaceColoring::Own;
  int width = 0, height = 0;
};

// "1280x720"; an empty text, or why not.
std::string ParseWindowSize(const std::string& text, int& width, int& height)
{
  char rest = 0;
  const bool parsed = std::sscanf(text.c_str(), "%5dx%5d%c", &width, &height, &rest) == 2;
  const bool inRange =
    width >= 1 && width <= largestWindowSide && height >= 1 && height <= largestWindowSide;
  return parsed && inRange ? std::string()
                           : "'" + text + "' is not a size: WxH, each 1 to " +
                               std::to_string(largestWindowSide) + " pixels";
}

// Why no picture can be written there; empty if it can.
std::string CheckPicture(const std::string& file)
{
  std::string ending = std::filesystem::path(file).extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
    [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return ending == ".png" ? ""
                          : "'" + file + "' does not end in .png, and pictures are written as PNG";
}

void AddPictureOptions(CLI::App& app, CommandLine& line)
{
  const char* const group = "Picture";
  app
    .add_option("--offscreen", line.offscreen,
      "how to draw, since this version opens no window yet; auto: the first that works")
    ->required()
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
      "its size in pixels")
    ->type_name("WxH")
    ->default_str("1280x720")
    ->group(group);
  const std::map<std::string, SurfaceColoring> colorings{ { "own", SurfaceColoring::Own },
    { "none", SurfaceColoring::Stone }, { "partition", SurfaceColoring::Partition },
    { "resolution", SurfaceColoring::Resolution } };
  app
    .add_option("--colour-by", line.coloring,
      "colours of the surface: own (the model's, where it has some), none, or one for each "
      "partition or resolution")
    ->transform(CLI::CheckedTransformer(colorings).description(""))
    ->type_name("own|none|partition|resolution")
    ->default_str("own")
    ->group(group);
  app.add_option("--screenshot", line.screenshot, "write what is shown at the end (NAME.png)")
    ->check(CLI::Validator(CheckPicture, ""))
    ->type_name("FILE")
    ->group(group);
}

void AddDetailOptions(CLI::App& app, CommandLine& line)
{
  const char* const group = "Detail";
  const std::map<std::string, DetailMode> modes{ { "view", DetailMode::View },
    { "level", DetailMode::Level }, { "full", DetailMode::Full } };
  app
    .add_option("--detail", line.detail,
      "view: what is seen, as fine as the window shows it; level: one level for the whole model, "
      "by "
      "the zoom; full: all of it as the original")
    ->transform(CLI::CheckedTransformer(modes).description(""))
    ->type_name("view|level|full")
    ->default_str("view")
    ->group(group);
  app.add_option("--triangles", line.triangles, "show about so many triangles at most")
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
            size ? "'" + text + "' is less than 16M, which the coarsest picture may take"
                 : size.GetError().message);
        }
        line.memory = *size;
      },
      "decoded pieces and what is drawn of them take about so much at most")
    ->type_name("SIZE")
    ->default_str("1G")
    ->group(group);
}

void AddOptions(CLI::App& app, CommandLine& line)
{
  app.add_option("URL", line.url, "the server: http://HOST:PORT")->required();
  const char* const model = "Model";
  app.add_option("--model", line.model, "its name [default: the server's only one]")
    ->type_name("ID")
    ->group(model);
  app
    .add_option(
      "--rings", line.rings, "how far around a double tap the original is streamed, in cells")
    ->check(CLI::Range(1u, 3u))
    ->capture_default_str()
    ->group(model);
  AddDetailOptions(app, line);
  AddPictureOptions(app, line);
  const char* const session = "Session";
  app.add_option("--replay", line.replay, "play this session file")
    ->type_name("FILE")
    ->group(session);
  app.add_option("--record", line.record, "write a session file of what is done")
    ->type_name("FILE")
    ->group(session);
  app
    .add_option("--stats", line.statistics,
      "write JSON at the end: vertices, triangles, bytes and seconds of every blob")
    ->type_name("FILE")
    ->group(session);
  app
    .add_option("--report", line.report,
      "write JSON at the end: bytes, seconds, triangles and memory of all of it")
    ->type_name("FILE")
    ->group(session);
}

// The result, with the file or the server that is at fault before an error's message,
// unless that begins with it.
template <class T>
Result<T> At(const std::string& place, Result<T> result)
{
  const std::string message = result ? "" : result.GetError().message;
  const bool named = message.starts_with(place + ": ") || message.starts_with("'" + place + "'");
  if (!result && !named)
  {
    return Error{ result.GetError().code, place + ": " + message };
  }
  return result;
}

// Whether the picture of a step, if it is one, can be written beside `replay`, which names it.
Status CheckStep(const SessionStep& step, const std::string& replay)
{
  if (step.kind != SessionStep::Kind::Screenshot)
  {
    return {};
  }
  if (const std::string wrong = CheckPicture(step.name); !wrong.empty())
  {
    return Error{ ErrorCode::InvalidInput, wrong };
  }
  const auto place = At(step.name, CheckOutput(step.name, OutputKind::File, { replay }));
  return place ? Status{} : place.GetError();
}

// The steps of a session file; none if no file is named.
Result<std::vector<SessionStep>> ReadReplay(const std::string& file)
{
  if (file.empty())
  {
    return std::vector<SessionStep>();
  }
  std::ifstream input(file, std::ios::binary);
  if (!input)
  {
    return Error{ ErrorCode::NotFound, "cannot be read: " + SystemReason(errno) };
  }
  const std::string text{ std::istreambuf_iterator<char>(input), {} };
  auto steps =
    ParseSession(text, [&file](const SessionStep& step) { return CheckStep(step, file); });
  if (steps && steps->empty())
  {
    return Error{ ErrorCode::InvalidInput,
      std::string(text.empty() ? "is empty" : "has no steps") +
        ": a session file has a JSON object a line (--help tells which)" };
  }
  return steps;
}

// Nothing if no file is named.
Status WriteOutput(const std::string& file, const std::string& text)
{
  if (file.empty())
  {
    return {};
  }
  std::ofstream output(file, std::ios::binary | std::ios::trunc);
  output << text;
  output.close();
  if (!output)
  {
    return SystemError("cannot be written", errno);
  }
  return {};
}

// The model to begin with: the one that is named, or the only one; empty if the replay selects one
// itself.
Result<std::string> FirstModel(const CommandLine& line, const std::vector<SessionStep>& steps,
  const std::vector<ModelSummary>& models)
{
  if (!line.model.empty())
  {
    return line.model;
  }
  for (const SessionStep& step : steps)
  {
    if (step.kind == SessionStep::Kind::Select)
    {
      return std::string();
    }
    if (step.kind == SessionStep::Kind::Touches)
    {
      break;
    }
  }
  if (models.size() == 1)
  {
    return models[0].id;
  }
  if (models.empty())
  {
    return Error{ ErrorCode::NotFound, "the server has no models" };
  }
  std::string names;
  for (const ModelSummary& model : models)
  {
    names += (names.empty() ? "" : ", ") + model.id;
  }
  return Error{ ErrorCode::InvalidArgument,
    "the server has several models; choose one by --model: " + names };
}

// What is played: the session file, or one model in full screen.
std::vector<SessionStep> Script(
  const std::string& first, const std::vector<SessionStep>& replay, const CommandLine& line)
{
  using Kind = SessionStep::Kind;
  std::vector<SessionStep> steps;
  if (!first.empty())
  {
    steps.push_back({ Kind::Select, {}, first });
    steps.push_back({ Kind::WaitForIdle, {}, {} });
  }
  if (line.replay.empty())
  {
    steps.push_back({ Kind::Select, {}, first }); // again: full screen
    steps.push_back({ Kind::WaitForIdle, {}, {} });
  }
  steps.insert(steps.end(), replay.begin(), replay.end());
  if (!line.screenshot.empty())
  {
    steps.push_back({ Kind::Screenshot, {}, line.screenshot });
  }
  return steps;
}

// Before the work, so that nothing is done in vain. Outputs that are links become what they link
// to.
Status CheckOutputs(CommandLine& line)
{
  const std::pair<std::string*, OutputKind> outputs[] = { { &line.record, OutputKind::Stream },
    { &line.statistics, OutputKind::Stream }, { &line.report, OutputKind::Stream },
    { &line.screenshot, OutputKind::File } };
  for (const auto& [file, kind] : outputs)
  {
    if (file->empty())
    {
      continue;
    }
    const auto output = At(*file, CheckOutput(*file, kind, { line.replay }));
    KDSTREAM_TRY(output);
    *file = output->string();
  }
  return {};
}

SessionOptions OptionsOf(const CommandLine& line)
{
  SessionOptions options;
  options.rings = line.rings;
  options.turning = Turning::Free; // until a session file says otherwise
  options.detail = line.detail;
  options.refinement.triangles = options.policy.triangleBudget = line.triangles;
  options.refinement.bytes = line.memory;
  options.cacheBytes = line.memory / 2; // the other half is what is drawn
  options.clock = []
  {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch())
      .count();
  };
  if (!line.statistics.empty())
  {
    options.mostStatistics = std::numeric_limits<std::size_t>::max(); // all, as it was asked for
  }
  return options;
}

// Of a look that leaves nothing behind, which would be silent, that it has worked.
void TellIfNothingIsWritten(const std::string& program, const CommandLine& line,
  const std::vector<SessionStep>& steps, const ViewerSession& session)
{
  const bool pictures = std::any_of(steps.begin(), steps.end(),
    [](const SessionStep& step) { return step.kind == SessionStep::Kind::Screenshot; });
  if (!pictures && line.record.empty() && line.statistics.empty() && line.report.empty())
  {
    std::cerr << program << ": showed " << session.Statistics().size() << " pieces of " << line.url
              << ", and wrote nothing: --screenshot FILE writes a picture\n";
  }
}

// A file where the address of a server is expected: there is no such ability yet.
Status CheckAddress(const std::string& url)
{
  std::error_code status;
  if (!std::filesystem::exists(url, status))
  {
    return {};
  }
  const bool folder = std::filesystem::is_directory(url, status);
  return Error{ ErrorCode::InvalidArgument,
    url + ": is a " + (folder ? "folder" : "file") +
      ", and this version looks at servers alone (http://HOST:PORT): kdstream-serve serves " +
      (folder ? "it" : "the folder that it is in") };
}

// What is told of pictures that show nothing, or less than they should.
class ToldPictures
{
public:
  ToldPictures(std::string program, const ViewerSession& session)
    : Program(std::move(program))
    , Session(session)
  {
  }

  // A part of the model that is looked at could not be loaded.
  void AddFailure() { this->Incomplete.insert(this->Session.GetStatus().model); }

  // Of a step that was played: the exit code. Errors: those of the step, but a picture of nothing.
  Result<int> Tell(const SessionStep& step, const Status& played) const
  {
    const bool picture = step.kind == SessionStep::Kind::Screenshot;
    if (picture && !played && played.GetError().code == ErrorCode::NotFound)
    {
      return PrintError(this->Program, step.name, played.GetError()); // the others go on
    }
    KDSTREAM_TRY(played);
    if (picture && this->Incomplete.count(this->Session.GetStatus().model) > 0)
    {
      std::cerr << this->Program << ": warning: " << step.name
                << ": is incomplete: a part of the model could not be loaded\n";
    }
    return exitDone;
  }

private:
  std::string Program;
  const ViewerSession& Session;
  std::set<std::string> Incomplete; // models
};

// Steps: check where the outputs go, read what is to be played, connect, open the window, play,
// write the outputs. Returns the exit code: a part of the model that could not be loaded makes it a
// failure, but the session goes on without that part.
Result<int> View(const std::string& program, CommandLine line)
{
  KDSTREAM_TRY(CheckAddress(line.url));
  KDSTREAM_TRY(CheckOutputs(line));
  const auto replay = At(line.replay, ReadReplay(line.replay));
  KDSTREAM_TRY(replay);
  const auto client = At(line.url, ServerClient::Connect(line.url));
  KDSTREAM_TRY(client);
  const auto first = At(line.url, FirstModel(line, *replay, (*client)->Models()));
  KDSTREAM_TRY(first);
  SceneStyle style;
  style.coloring = line.coloring;
  const auto window = SessionWindow::MakeOffscreen(
    *ParseWindowBackend(line.offscreen), line.width, line.height, style);
  KDSTREAM_TRY(window);

  ViewerSession session(OptionsOf(line));
  session.SetModels((*client)->Models());
  session.Resize({ line.width, line.height, 1 });
  int exitCode = exitDone;
  ToldPictures pictures(program, session);
  std::string record;
  PlayerOptions options;
  options.record = [&record](const SessionStep& step) { record += FormatSessionStep(step) + "\n"; };
  options.complain = [&](const std::string& sentence)
  {
    exitCode = PrintError(program, line.url, { ErrorCode::NotFound, sentence });
    pictures.AddFailure();
  };
  options.interrupted = Interrupted;
  ViewReport report;
  options.drawn = [&] { report.AddFrame(session.GetStatus()); };
  Player player(**client, session, **window, options);
  const std::vector<SessionStep> steps = Script(*first, *replay, line);
  for (const SessionStep& step : steps)
  {
    const bool picture = step.kind == SessionStep::Kind::Screenshot;
    const auto told = At(picture ? step.name : line.url, pictures.Tell(step, player.Play(step)));
    KDSTREAM_TRY(told);
    exitCode = std::max(exitCode, *told);
  }

  KDSTREAM_TRY(At(line.record, WriteOutput(line.record, record)));
  KDSTREAM_TRY(
    At(line.statistics, WriteOutput(line.statistics, StatisticsJson(session.Statistics()))));
  KDSTREAM_TRY(At(line.report, WriteOutput(line.report, report.Json(session.GetTraffic()))));
  TellIfNothingIsWritten(program, line, steps, session);
  return exitCode;
}

}

int main(int argc, char** argv)
{
  CommandLine line;
  ParseWindowSize(line.size, line.width, line.height);
  CLI::App app(description, "kdstream-view");
  app.footer(examples);
  AddOptions(app, line);
  return RunProgram(app, argc, argv,
    [&]()
    {
      CatchInterrupts();
      const Result<int> exitCode = View(app.get_name(), line);
      return exitCode ? *exitCode : PrintError(app.get_name(), "", exitCode.GetError());
    });
}
