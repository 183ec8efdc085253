// SPDX-License-Identifier: BSD-3-Clause
// A session's line to a server: when to connect, what to send and to fetch, what to do when the
// connection is lost. No sockets, no clock: the host does what TakeActions says and tells what
// happened. The desktop's ServerClient and the page of the phone are such hosts. Step
// "receive" of the README's picture.
#pragma once

#include "filters/core/Result.h"
#include "viewer/client/ClientEvent.h"
#include "viewer/client/GetConversation.h"
#include "viewer/client/HttpFetch.h"
#include "viewer/client/StreamConversation.h"

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace kdstream
{

struct ServerLineOptions
{
  // The server, for messages: "host:port".
  std::string authority;
  // When the connection is lost, the line connects again at once. If that fails too:
  // - not patient: everything that is outstanding fails, and the next Send connects anew;
  // - patient: nothing fails. The line tries again after firstRetry seconds, then after twice as
  //   long, up to longestRetry, until it succeeds. The same for GETs that find no server.
  bool patient = false;
  double firstRetry = 0.5;   // s
  double longestRetry = 8;   // s
  double longestSilence = 0; // s; if something is owed and nothing has come for so long, the
                             // connection is given up; 0 = never (the host's sockets do that)
};

// All times are seconds of any one steady clock.
class ServerLine
{
public:
  enum class State
  {
    Connecting, // to the stream, for the first time or again
    Streaming,
    Lost,   // not patient: until the next request; patient: until the next try
    Getting // the server has no stream: blob by blob, over GET
  };
  struct Action
  {
    enum class Kind
    {
      Connect, // to the stream, in place of any connection before; answer with Socket…
      Send,    // `text` over the stream
      Close,   // the stream; without an answer
      Fetch    // `fetch`; answer with Fetched
    };
    Kind kind = Kind::Connect;
    std::string text;
    HttpFetch fetch;
  };

  // Begins to connect.
  explicit ServerLine(ServerLineOptions options);

  void Send(const SessionRequest& request, double now);

  // ---- what the host reports. It may report nothing of a connection that was replaced or closed.
  void SocketOpened(double now);
  void SocketText(std::string_view text, double now);
  void SocketFrame(std::span<const std::uint8_t> message, double now);
  // refused: the server answered that it has no stream. why: a reason for the person to read.
  void SocketEnded(bool refused, const std::string& why, double now);
  void Fetched(const Result<HttpReply>& reply, double now);
  // Call now and then: retries, silences.
  void Tick(double now);
  // Makes the next Tick try again, without waiting any longer.
  void Hurry();

  // ---- what comes out
  // What to do since the last call, in order.
  std::vector<Action> TakeActions();
  // What has come for the session since the last call, in order.
  std::vector<ClientEvent> TakeEvents();
  State GetState() const { return this->Current; }
  // Why nothing comes (the connection was lost, the server does not answer); empty when all is
  // well.
  const std::string& Trouble() const { return this->Why; }

private:
  void Connect();
  void Receive(const Status& status, double now);
  void Lose(const std::string& why, double now);
  void RetryLater(double now);
  void FetchNext();
  void Flush();

  ServerLineOptions Options;
  State Current = State::Connecting;
  bool HasStreamed = false;
  bool MayRetryAtOnce = true; // the connection brought something since it was made
  // The last connection broke the protocol, and nothing that is owed has come since. Then other
  // messages do not allow a retry at once: if every frame is garbled, that would never end.
  bool Garbled = false;
  std::vector<SessionRequest> Early; // before it is known whether there is a stream
  StreamConversation Stream;
  GetConversation Gets;
  bool Retrying = false; // at RetryAt
  double RetryAt = 0, RetryAfter = 0;
  double LastNews = 0;
  std::string Why;
  std::vector<Action> Actions;
};

}
