// SPDX-License-Identifier: BSD-3-Clause
// A session with its line to a server, driven by recorded inputs, that records everything it does.
//
// A trace is lines of JSON: those of ViewerSession (the state after every input, SessionTrace.cxx),
// one for each action that the line asks for, one for each frame, and at the end the statistics of
// every blob. A frame's line has digests, over all bits, of what would be drawn.
#pragma once

#include "viewer/client/ServerLine.h"
#include "viewer/client/Testing/Replay/Recording.h"
#include "viewer/session/ViewerSession.h"

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace kdstream::testing
{

class TracedSession
{
public:
  // `trace` is called with one line at a time, without its end.
  explicit TracedSession(std::function<void(std::string_view)> trace);
  TracedSession(const TracedSession&) = delete;
  TracedSession& operator=(const TracedSession&) = delete;

  // The input, and all that follows from it. Gives what the line wants done.
  std::vector<ServerLine::Action> Apply(const RecordedInput& input);
  // The statistics.
  void Finish();

  const ViewerSession& Session() const { return this->Viewer; }
  const ServerLine& Line() const { return this->Server; }

private:
  void Dispatch(const RecordedInput& input);
  void Draw();
  void TraceAction(const ServerLine::Action& action);

  std::function<void(std::string_view)> Trace;
  ViewerSession Viewer;
  ServerLine Server;
  std::uint64_t DrawnVersion = 0;
};

}
