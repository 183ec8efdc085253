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
  std::string cache; // folder; empty: that of the user
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

// Applies the link to a view, written after the source's #: its model, colours and light. Errors:
// those of ParseViewLink; InvalidArgument with a session file, or with another model.
Status TakeLink(ViewOptions& options);

// The session's options for these options of the program. Turning is free until it is set
// otherwise.
SessionOptions SessionOptionsOf(const ViewOptions& options);

// Puts the file or the server that caused the error before its message, unless the message begins
// with it.
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

// Why no window can be opened, and what to do.
Error NoWindow(const Error& why);

// Why no picture can be written there; empty if it can.
std::string CheckPicture(const std::string& file);

// Checks the outputs before the work, so that no work is wasted. Outputs that are links are
// replaced by their targets.
Status CheckOutputs(ViewOptions& options);

// Nothing if no file is named.
Status WriteOutput(const std::string& file, const std::string& text);

}
