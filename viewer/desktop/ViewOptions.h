// SPDX-License-Identifier: BSD-3-Clause
// The command line of kdstream-view. The contract is doc/cli.md#kdstream-view.
#pragma once

#include "filters/core/Result.h"
#include "filters/program/Program.h"
#include "viewer/rendering/SurfaceScene.h"
#include "viewer/session/ViewerSession.h"
#include "viewer/session/appearance/Coloring.h"

#include <cstdint>
#include <string>

namespace kdstream
{

struct ViewOptions
{
  std::string source;      // a server's URL, or a file or folder
  std::string link;        // a link to a view of the model (ViewLink.h); may be empty
  std::string token;       // of the server
  std::string authorities; // a PEM file; empty: the system's certificates
  std::string model, offscreen, record, replay, screenshot, statistics, report;
  std::string cache; // folder; empty: the user's cache folder
  std::uint64_t cacheBytes = std::uint64_t{ 10 } << 30;
  unsigned rings = 1;
  DetailMode detail = DetailMode::View;
  std::uint64_t triangles = RefinementOptions().triangles;
  std::uint64_t memory = std::uint64_t{ 1 } << 30;
  ColorChoice colors;
  bool occlusion = true;
  bool legend = true; // in the screenshot
  int width = 1280, height = 720;

  bool OpensWindow() const { return this->offscreen.empty() && this->replay.empty(); }
};

void AddViewOptions(CLI::App& app, ViewOptions& options);

// Applies a link to a view, which follows the # in the source: its model, colours and light.
// Errors: those of ParseViewLink; InvalidArgument if a session file or another model is named, too.
Status TakeLink(ViewOptions& options);

// The session's options for these options of the program. Turning is free until a step sets it
// otherwise.
SessionOptions SessionOptionsOf(const ViewOptions& options);

// Prepends the name of the file or server that caused the error to the error's message, unless the
// message begins with it.
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

// Explains why no window can be opened, and what to do.
Error NoWindow(const Error& why);

// Why no picture can be written to this file; empty if it can.
std::string CheckPicture(const std::string& file);

// Checks the outputs before any work is done, so that none is wasted. Outputs that are symbolic
// links are replaced by their targets.
Status CheckOutputs(ViewOptions& options);

// Does nothing if no file is named.
Status WriteOutput(const std::string& file, const std::string& text);

}
