// SPDX-License-Identifier: BSD-3-Clause
// kdstream-view: looks at the models of a server, or of this machine. The contract is
// doc/cli.md#kdstream-view.
#include "filters/core/CaughtError.h"
#include "viewer/desktop/HeadlessView.h"
#include "viewer/desktop/OpenSource.h"
#include "viewer/desktop/ViewOptions.h"
#include "viewer/desktop/window/WindowView.h"

#include <iostream>
#include <optional>

namespace
{

using namespace kdstream;

constexpr const char* description =
  "Looks at the models of a KdStream server, at a store, or at a mesh.\n"
  "It opens a window (F1 there tells what mouse and keys do). With --offscreen it opens none: it "
  "shows one model as fine as the window shows it, or plays a recorded session (--replay), writes "
  "what is asked for, and ends.";

constexpr const char* examples =
  "A session file has one JSON object a line:\n"
  "  {\"select\":\"MODEL\"}          show its preview; again, or a tap: full screen\n"
  "  {\"wait\":\"idle\"}             until everything that was asked for has come\n"
  "  {\"screenshot\":\"NAME.png\"}   write what is shown\n"
  "  {\"t\":0.25,\"touches\":[{\"id\":1,\"x\":640,\"y\":360}]}\n"
  "                               the fingers on the screen at that time (seconds, pixels)\n"
  "  {\"zoom\":1.25,\"x\":640,\"y\":360}\n"
  "                               a wheel, over that pixel\n"
  "  {\"turning\":\"upright\"}       from here on, as on a turntable; \"free\": as a ball\n"
  "and some more (doc/cli.md). One finger turns, two move and zoom, a double tap streams the "
  "original under it.\n\n"
  "Examples:\n"
  "  kdstream-view statue.ply\n"
  "  kdstream-view http://localhost:8700\n"
  "  kdstream-view http://localhost:8700 --model dragon --offscreen auto --screenshot dragon.png";

void Warn(const std::string& program, std::string_view sentence)
{
  std::cerr << program << ": warning: " << sentence << "\n";
}

// A look without a window: how far a build is, is told on stderr.
Result<int> ViewWithoutWindow(const std::string& program, const ViewOptions& options)
{
  const auto replay = At(options.replay, ReadReplay(options.replay));
  KDSTREAM_TRY(replay);
  std::string told;
  const auto report = [&](std::string_view progress)
  {
    if (progress != told && !progress.empty())
    {
      std::cerr << program << ": " << progress << "\n";
    }
    told = progress;
    return !Interrupted();
  };
  const auto source =
    OpenSource(options, report, [&](std::string_view sentence) { Warn(program, sentence); });
  KDSTREAM_TRY(source);
  return ViewHeadless(program, options, *replay, **source);
}

// Steps: what a link says; check where the outputs go; a window, or a look without one. Returns the
// exit code.
Result<int> View(const std::string& program, ViewOptions options)
{
  KDSTREAM_TRY(At(options.source, TakeLink(options)));
  KDSTREAM_TRY(CheckOutputs(options));
  // A session file is played and ends: nobody has to do anything in a window.
  if (options.OpensWindow())
  {
    return ViewInWindow(program, options);
  }
  return ViewWithoutWindow(program, options);
}

}

int main(int argc, char** argv)
try
{
  ViewOptions options;
  CLI::App app(description, "kdstream-view");
  app.footer(examples);
  AddViewOptions(app, options);
  return RunProgram(app, argc, argv,
    [&]()
    {
      CatchInterrupts();
      const Result<int> exitCode = View(app.get_name(), options);
      return exitCode ? *exitCode : PrintError(app.get_name(), "", exitCode.GetError());
    });
}
catch (...) // memory runs out before the work begins
{
  return kdstream::PrintError("kdstream-view", "", kdstream::CaughtError());
}
