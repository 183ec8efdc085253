// SPDX-License-Identifier: BSD-3-Clause
// A session with its connection to a server, which is driven by recorded inputs, and traces
// everything that it does.
//
// A trace consists of lines of JSON: those of ViewerSession (the state after every input,
// SessionTrace.cxx), one for each action of the ServerLine, one for each frame, and at the end the
// statistics of every blob. A frame's line has digests, over all bits, of what would be drawn.
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
  // `trace` is called with one line at a time, without the line's end.
  explicit TracedSession(std::function<void(std::string_view)> trace);
  TracedSession(const TracedSession&) = delete;
  TracedSession& operator=(const TracedSession&) = delete;

  // Applies the input, with everything that follows from it. Returns the actions of the ServerLine.
  std::vector<ServerLine::Action> Apply(const RecordedInput& input);
  // Traces the statistics.
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
