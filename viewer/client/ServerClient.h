// SPDX-License-Identifier: BSD-3-Clause
// A session's line to a server on native sockets: requests out, blobs in, on a thread of its own.
// Step "receive" of the README's picture. Boost stays in the source.
#pragma once

#include "filters/core/Result.h"
#include "filters/model/ModelDescription.h"
#include "viewer/client/ClientEvent.h"

#include <chrono>
#include <memory>
#include <string>
#include <vector>

namespace kdstream
{

// Talks to one server, through its stream, or by GETs if it has none (a static file server).
//
// When the connection is lost, the client connects again at once, and asks again for what has not
// arrived. If that fails too, every outstanding request fails with a sentence that says so, and the
// next Send connects anew. So every request is answered: by all its blobs, or by failures.
//
// Threads: Send, Take and Wait may be called from any threads.
class ServerClient
{
public:
  // Gets the list of models. Blocks until it is there, at most about 40 s.
  // Errors: those of ParseServerUrl; InputOutput where the server cannot be reached; InvalidInput
  // where something else than a KdStream server answers.
  static Result<std::unique_ptr<ServerClient>> Connect(const std::string& url);
  // Ends the connection and the thread.
  ~ServerClient();

  const std::vector<ModelSummary>& Models() const { return this->ModelList; }

  void Send(const SessionRequest& request);
  // What has come since the last call, in order.
  std::vector<ClientEvent> Take();
  // Waits until there is something to take; false if nothing has come in that time.
  bool Wait(std::chrono::milliseconds atMost);

private:
  class Line;
  explicit ServerClient(std::unique_ptr<Line> line);

  std::unique_ptr<Line> Kept;
  std::vector<ModelSummary> ModelList;
};

}
