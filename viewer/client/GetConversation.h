// SPDX-License-Identifier: BSD-3-Clause
// Fetches a session's requests by plain GETs, one blob after the other, from servers without a
// stream. No sockets, no clock.
#pragma once

#include "filters/core/Result.h"
#include "viewer/client/ClientEvent.h"
#include "viewer/client/HttpFetch.h"

#include <deque>
#include <optional>
#include <string>
#include <vector>

namespace kdstream
{

// Gives the same answers as a StreamConversation, also from a static file server.
class GetConversation
{
public:
  void Send(const SessionRequest& request, double now);
  // What to get now; nothing while an answer is awaited, or when all is done.
  std::optional<HttpFetch> Next();
  // The answer to the last Next. Errors of the connection are the errors of the request.
  void Receive(const Result<HttpReply>& reply, double now);
  // Call instead of Receive: Next will return the same request again.
  void PutBack();
  // Whether all is done.
  bool IsIdle() const { return !this->Current && this->Waiting.empty(); }
  // The open model; empty if none is open.
  const std::string& OpenModel() const { return this->Model; }
  const std::string& OpenDigest() const { return this->Digest; }
  std::vector<ClientEvent> TakeEvents();

private:
  struct Item
  {
    std::uint32_t request = 0;
    std::string model; // for an Open; otherwise empty
    protocol::BlobId blob;
    double asked = 0;
  };

  std::deque<Item> Waiting;
  std::optional<Item> Current;
  bool Cancelled = false; // whether Current is
  double LastBlob = 0;
  std::string Model, Digest; // of the open model
  std::vector<ClientEvent> Events;
};

// "the server says 404 Not Found: no such blob": the text of a refusal, from the status and the
// error in the body.
std::string DescribeRefusal(const HttpReply& reply);

}
