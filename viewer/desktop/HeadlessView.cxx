// SPDX-License-Identifier: BSD-3-Clause
// A view without a screen: see HeadlessView.h.
#include "viewer/desktop/HeadlessView.h"

#include "filters/core/SystemReason.h"
#include "filters/files/WriteWhole.h"
#include "viewer/desktop/CheckColors.h"
#include "viewer/desktop/Player.h"
#include "viewer/desktop/ViewReport.h"

#include <algorithm>
#include <cerrno>
#include <fstream>
#include <iostream>
#include <iterator>
#include <set>

namespace kdstream
{
namespace
{

// If the step takes a picture: checks that it can be written, and that it would not overwrite
// `replay`, the session file.
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

// The first model: the one that the options name, or the only one; empty if the replay selects one.
Result<std::string> FirstModel(const ViewOptions& line, const std::vector<SessionStep>& steps,
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
    if (NeedsModel(step))
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
    return Error{ ErrorCode::NotFound, "there are no models" };
  }
  std::string names;
  for (const ModelSummary& model : models)
  {
    names += (names.empty() ? "" : ", ") + model.id;
  }
  return Error{ ErrorCode::InvalidArgument,
    "there are several models; choose one with --model: " + names };
}

// The steps to play: those of the session file, or those that show one model in full screen.
std::vector<SessionStep> Script(
  const std::string& first, const std::vector<SessionStep>& replay, const ViewOptions& line)
{
  using Kind = SessionStep::Kind;
  std::vector<SessionStep> steps;
  if (!line.link.empty())
  {
    steps = { { Kind::Link, {}, line.link }, { Kind::WaitForIdle, {}, {} } };
  }
  else if (line.replay.empty()) // as in a window; recordings say it themselves
  {
    steps.push_back({ Kind::Turning, {}, "upright" });
  }
  if (line.link.empty() && !first.empty())
  {
    steps.push_back({ Kind::Select, {}, first });
    steps.push_back({ Kind::WaitForIdle, {}, {} });
  }
  if (line.replay.empty() && line.link.empty())
  {
    steps.push_back({ Kind::Select, {}, first }); // the second selection: full screen
    steps.push_back({ Kind::WaitForIdle, {}, {} });
  }
  steps.insert(steps.end(), replay.begin(), replay.end());
  if (!line.screenshot.empty())
  {
    steps.push_back({ Kind::Screenshot, {}, line.screenshot });
  }
  return steps;
}

// A view without outputs would print nothing: this reports that it worked.
void TellIfNothingIsWritten(const std::string& program, const ViewOptions& line,
  const std::vector<SessionStep>& steps, const ViewerSession& session)
{
  const bool pictures = std::any_of(steps.begin(), steps.end(),
    [](const SessionStep& step) { return step.kind == SessionStep::Kind::Screenshot; });
  if (!pictures && line.record.empty() && line.statistics.empty() && line.report.empty())
  {
    std::cerr << program << ": showed " << session.Statistics().size() << " pieces of "
              << line.source << ", but wrote no file: use --screenshot FILE to write a picture\n";
  }
}

// Reports parts that cannot be fetched, and pictures that show nothing or are incomplete.
class ReportedFailures
{
public:
  ReportedFailures(std::string program, std::string source, const ViewerSession& session)
    : Program(std::move(program))
    , Source(std::move(source))
    , Session(session)
  {
  }

  // Call this for each part of the viewed model that could not be loaded. Returns the exit code.
  // Only the first few parts are reported.
  int Add(const std::string& sentence)
  {
    this->Incomplete.insert(this->Session.GetStatus().model);
    if (++this->Parts <= reportedParts)
    {
      this->Code = PrintError(this->Program, this->Source, { ErrorCode::NotFound, sentence });
    }
    return this->Code;
  }
  void TellOfTheRest() const
  {
    if (this->Parts > reportedParts)
    {
      std::cerr << this->Program << ": warning: " << this->Source << ": "
                << this->Parts - reportedParts << " more errors of this kind\n";
    }
  }

  // Returns the exit code after a played step. Errors: those of the step, except an empty picture.
  Result<int> Tell(const SessionStep& step, const Status& played) const
  {
    const bool picture = step.kind == SessionStep::Kind::Screenshot;
    if (picture && !played && played.GetError().code == ErrorCode::NotFound)
    {
      return PrintError(this->Program, step.name, played.GetError()); // the other steps go on
    }
    KDSTREAM_TRY(played);
    if (picture && this->Incomplete.count(this->Session.GetStatus().model) > 0)
    {
      std::cerr << this->Program << ": warning: " << step.name
                << ": the picture is incomplete: a part of the model could not be loaded\n";
    }
    return exitDone;
  }

private:
  static constexpr std::size_t reportedParts = 2;
  std::string Program, Source;
  const ViewerSession& Session;
  std::set<std::string> Incomplete; // models
  std::size_t Parts = 0;            // that could not be loaded
  int Code = exitDone;
};

}

Result<std::vector<SessionStep>> ReadReplay(const std::string& file)
{
  if (file.empty())
  {
    return std::vector<SessionStep>();
  }
  std::error_code failure;
  if (!NamesDescriptor(file) && std::filesystem::is_fifo(file, failure)) // could block for ever
  {
    return Error{ ErrorCode::InvalidInput, "is a named pipe, not a file" };
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
        ": a session file has one JSON object per line (see --help)" };
  }
  return steps;
}

Result<int> ViewHeadless(const std::string& program, const ViewOptions& line,
  const std::vector<SessionStep>& replay, ModelSource& source)
{
  const auto first = At(line.source, FirstModel(line, replay, source.Models()));
  KDSTREAM_TRY(first);
  SceneSettings settings{ line.colors, line.occlusion };
  const auto window = line.offscreen.empty()
                        ? SessionWindow::MakeOnScreen(line.width, line.height, settings)
                        : SessionWindow::MakeOffscreen(
                            *ParseWindowBackend(line.offscreen), line.width, line.height, settings);
  if (!window)
  {
    return line.offscreen.empty() ? NoWindow(window.GetError()) : window.GetError();
  }

  ViewerSession session(SessionOptionsOf(line));
  session.SetModels(source.Models());
  session.Resize({ line.width, line.height, 1 });
  int exitCode = exitDone;
  ReportedFailures failures(program, line.source, session);
  std::string record;
  PlayerOptions options;
  options.record = [&record](const SessionStep& step) { record += FormatSessionStep(step) + "\n"; };
  options.complain = [&](const std::string& sentence) { exitCode = failures.Add(sentence); };
  options.interrupted = Interrupted;
  ViewReport report;
  options.drawn = [&] { report.AddFrame(session.GetStatus(), session.Scene()); };
  Player player(source, session, **window, options);
  const std::vector<SessionStep> steps = Script(*first, replay, line);
  for (const SessionStep& step : steps)
  {
    const bool picture = step.kind == SessionStep::Kind::Screenshot;
    if (&step == &steps.back() && !line.screenshot.empty())
    {
      SceneSettings last = (*window)->Settings(); // pictures of a session file show only the model
      last.legend = line.legend;
      last.distances = true;
      (*window)->SetSettings(last);
    }
    const auto reported =
      At(picture ? step.name : line.source, failures.Tell(step, player.Play(step)));
    KDSTREAM_TRY(reported);
    Perform(step, settings);
    if (const ViewerScene scene = session.Scene(); !scene.box.Empty())
    {
      KDSTREAM_TRY(At(line.source, CheckColors(settings.colors, scene.scalars)));
    }
    exitCode = std::max(exitCode, *reported);
  }
  failures.TellOfTheRest();

  KDSTREAM_TRY(At(line.record, WriteOutput(line.record, record)));
  KDSTREAM_TRY(
    At(line.statistics, WriteOutput(line.statistics, StatisticsJson(session.Statistics()))));
  KDSTREAM_TRY(At(line.report,
    WriteOutput(line.report, report.Json(session.GetTraffic(), LinkTo(session, settings)))));
  TellIfNothingIsWritten(program, line, steps, session);
  return exitCode;
}

}
