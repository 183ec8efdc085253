// SPDX-License-Identifier: BSD-3-Clause
// A session's connection to a server, on native sockets: sends requests and receives blobs, on a
// thread of its own. Step "receive" of the pipeline picture. This header hides Boost.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/Result.h"
#include "viewer/client/ModelSource.h"

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace kdstream
{

// Communicates with one server, through the server's stream, or by GETs if it has none (a static
// file server).
//
// When the connection is lost, the client connects again at once, and repeats requests for what has
// not arrived. If nothing is outstanding, it connects with the next Send. If connecting fails,
// every outstanding request fails with a message, and the next Send connects again.
class ServerClient final : public ModelSource
{
public:
  // Connects, and gets the list of models. Blocks until it arrives, at most about 50 s, or
  // `timeout` if that is less. A busy server (429, 503) is asked five times, with pauses of up to
  // 16 s. token: for servers that require one (kdstream-serve token); otherwise empty. authorities:
  // a PEM file of certificate authorities to trust; empty: those of the system. Reports the step
  // "waiting" every 20 ms. Errors: those of ParseServerUrl and MakeTlsContext; InvalidArgument for
  // a malformed token; InputOutput if the server cannot be reached; InvalidInput if its certificate
  // is not trusted, or if it is not a KdStream server; Cancelled.
  static Result<std::unique_ptr<ServerClient>> Connect(const std::string& url,
    const std::string& token = {}, const std::string& authorities = {},
    const Execution& execution = {}, std::optional<std::chrono::seconds> timeout = {});
  // Ends the connection and the thread.
  ~ServerClient() override;

  const std::vector<ModelSummary>& Models() const override { return this->ModelList; }
  void Send(const SessionRequest& request) override;
  void AskForNotes(const std::string& model) override;
  std::vector<ClientEvent> Take() override;
  bool Wait(std::chrono::milliseconds atMost) override;

private:
  class Line;
  explicit ServerClient(std::unique_ptr<Line> line);
  static void LetGo(std::unique_ptr<Line> line);

  std::unique_ptr<Line> Kept;
  std::vector<ModelSummary> ModelList;
};

}
