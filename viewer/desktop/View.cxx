// SPDX-License-Identifier: BSD-3-Clause
// kdstream-view: shows models of a server, or of this machine. See doc/cli.md#kdstream-view.
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
  "Shows the models of a KdStream server, a store, or a mesh.\nIt opens a window (press F1 there "
  "for mouse and keys). With --offscreen it opens no window: it loads one model with the detail "
  "that the window would show, or plays a recorded session (--replay), writes the requested files, "
  "and exits.";

constexpr const char* examples =
  "A session file has one JSON object per line:\n"
  "  {\"select\":\"MODEL\"}          show its preview; again, or a tap: full screen\n"
  "  {\"wait\":\"idle\"}             wait until all requests are answered\n"
  "  {\"screenshot\":\"NAME.png\"}   write the picture\n"
  "  {\"t\":0.25,\"touches\":[{\"id\":1,\"x\":640,\"y\":360}]}\n"
  "                               fingers on the screen at this time (seconds, pixels)\n"
  "  {\"zoom\":1.25,\"x\":640,\"y\":360}\n"
  "                               mouse wheel over this pixel\n"
  "  {\"turning\":\"upright\"}       from now on, turn like a turntable; \"free\": like a "
  "trackball\n"
  "and others (doc/cli.md). One finger turns, two move and zoom, a double tap streams the original "
  "there.\n\n"
  "Examples:\n"
  "  kdstream-view statue.ply\n"
  "  kdstream-view http://localhost:8700\n"
  "  kdstream-view http://localhost:8700 --model dragon --offscreen auto --screenshot dragon.png";

void Warn(const std::string& program, std::string_view sentence)
{
  std::cerr << program << ": warning: " << sentence << "\n";
}

// A view without a window. The progress of builds is reported on stderr.
Result<int> ViewWithoutWindow(const std::string& program, const ViewOptions& options)
{
  const auto replay = At(options.replay, ReadReplay(options.replay));
  KDSTREAM_TRY(replay);
  std::string reported;
  const auto report = [&](std::string_view progress)
  {
    if (progress != reported && !progress.empty())
    {
      std::cerr << program << ": " << progress << "\n";
    }
    reported = progress;
    return !Interrupted();
  };
  const auto source =
    OpenSource(options, report, [&](std::string_view sentence) { Warn(program, sentence); });
  KDSTREAM_TRY(source);
  return ViewHeadless(program, options, *replay, **source);
}

// Steps:
// 1. apply the link
// 2. check the outputs
// 3. show a window, or view without one.
// Returns the exit code.
Result<int> View(const std::string& program, ViewOptions options)
{
  KDSTREAM_TRY(At(options.source, TakeLink(options)));
  KDSTREAM_TRY(CheckOutputs(options));
  // A session file is played without a window, because nobody needs to operate it.
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
catch (...) // out of memory before the work begins
{
  return kdstream::PrintError("kdstream-view", "", kdstream::CaughtError());
}
