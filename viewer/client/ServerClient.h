// SPDX-License-Identifier: BSD-3-Clause
// A session's line to a server on native sockets: requests out, blobs in, on a thread of its own.
// Step "receive" of the pipeline picture. Boost stays in the source.
#pragma once

#include "filters/core/Execution.h"
#include "filters/core/Result.h"
#include "viewer/client/ModelSource.h"

#include <chrono>
#include <memory>
#include <string>
#include <vector>

namespace kdstream
{

// Talks to one server, through its stream, or by GETs if it has none (a static file server).
//
// When the connection is lost, the client connects again at once, and asks again for what has not
// arrived; with the next Send, where all had. If that fails too, every outstanding request fails
// with a sentence that says so, and the next Send connects anew.
class ServerClient final : public ModelSource
{
public:
  // Gets the list of models. Blocks until it is there, at most about 50 s; a busy server (429, 503)
  // is asked five times, with pauses of up to 16 s.
  // token: what the server lets this client have (kdstream-serve token); empty where it asks for
  // none. authorities: a PEM file of those whose word is taken for the server's certificate; empty:
  // those that the system trusts. Reports the step "waiting" every 20 ms. Errors: those of
  // ParseServerUrl and MakeTlsContext; InvalidArgument for what is no token; InputOutput where the
  // server cannot be reached; InvalidInput where its certificate is not trusted, or something else
  // than a KdStream server answers; Cancelled.
  static Result<std::unique_ptr<ServerClient>> Connect(const std::string& url,
    const std::string& token = {}, const std::string& authorities = {},
    const Execution& execution = {});
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
