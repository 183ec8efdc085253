// SPDX-License-Identifier: BSD-3-Clause
// Decides when to connect to a server, what to send and to fetch, and what to do when the
// connection is lost. No sockets, no clock: the host does what TakeActions returns, and reports
// what happened. Hosts are the desktop's ServerClient and the phone's page. Step "receive" of the
// pipeline picture.
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
  // When the connection is lost while something is outstanding, the line connects again at once. If
  // nothing is outstanding, it connects with the next Send (a patient line also after idleRetry
  // seconds), and reports no trouble, so that not all clients come back at the same time after a
  // server's restart. If connecting fails:
  // - not patient: everything that is outstanding fails, and the next Send connects again;
  // - patient: nothing fails. The line tries again after firstRetry seconds, then after twice this
  //   time, and so on, up to longestRetry, until it succeeds. GETs that cannot reach a server are
  //   repeated in the same way.
  bool patient = false;
  double firstRetry = 0.5; // s
  double longestRetry = 8; // s
  double idleRetry = 2;    // s
  // Each pause is made longer by up to this many times its length, at random (by the lowest bits of
  // the time), so that the clients do not all come back at once after a server's restart.
  double jitter = 0;
  // A busy server (IsBusy) is asked again after the time that it names, or after firstRetry and so
  // on (backoff). A line that is not patient asks at most this number of times for one request,
  // which then fails.
  std::size_t mostTries = 6;
  // s; a server that had no stream is asked for one again each time this has passed, as soon as no
  // GET is outstanding; 0 = never.
  double streamRetry = 0;
  double idleTimeout = 0; // s; the connection is given up if something is outstanding and nothing
                          // arrived for this time; 0 = never (the host's sockets do that)
  // s; the stall timeout. If the oldest outstanding request makes no progress for this time,
  // although other things arrive (StreamConversation::StalledSince), that request fails, and the
  // connection is given up; 0 = never
  double stallTimeout = 0;
};

// All times are seconds of one steady clock, whichever.
class ServerLine
{
public:
  enum class State
  {
    Connecting, // to the stream, for the first time or again
    Streaming,
    Lost,   // until the next request, or, if patient, the next try
    Getting // the server has no stream: blob by blob, over GET
  };
  struct Action
  {
    enum class Kind
    {
      Connect, // to the stream, in place of an earlier connection; answer with Socket…
      Send,    // `text` over the stream
      Close,   // the stream; needs no answer
      Fetch    // `fetch`; answer with Fetched
    };
    Kind kind = Kind::Connect;
    std::string text;
    HttpFetch fetch;
  };

  // Begins to connect.
  explicit ServerLine(ServerLineOptions options);

  void Send(const SessionRequest& request, double now);

  // ---- what the host reports. It must not report anything from a connection that was replaced or
  // closed.
  void SocketOpened(double now);
  void SocketText(std::string_view text, double now);
  void SocketFrame(std::span<const std::uint8_t> message, double now);
  // refused: the server answered that it has no stream; false if it is busy, or if this client may
  // not have a stream. why: the reason, for the user. retryAfter: the seconds after which a busy
  // server wants to be asked again; 0 if it does not say.
  void SocketEnded(bool refused, const std::string& why, double now, double retryAfter = 0);
  void Fetched(const Result<HttpReply>& reply, double now);
  // Call now and then, for retries and timeouts.
  void Tick(double now);
  // When the next Tick will have something to do, if nothing else happens before; infinity if
  // never.
  double NextTick() const;
  // Makes the next Tick try again, without waiting any longer.
  void RetryNow();

  // ---- outputs. The actions since the last call, to be done in this order.
  std::vector<Action> TakeActions();
  // The events for the session since the last call, in order.
  std::vector<ClientEvent> TakeEvents();
  State GetState() const { return this->Current; }
  // Why nothing arrives (the connection was lost, the server does not answer); empty when all is
  // well.
  const std::string& Trouble() const { return this->Why; }

private:
  void Connect();
  void Receive(const Status& status, double now);
  void Disconnect(const std::string& why, double now, double retryAfter = 0);
  void Idle(double now);
  void RetryLater(double now, double atLeast = 0);
  double Jittered(double pause, double now) const;
  bool HasStallTimeout() const
  {
    return this->Current == State::Streaming && this->Options.stallTimeout > 0;
  }
  void ProbeStream();
  void EndProbe(double now);
  void FetchNext();
  void Flush();

  ServerLineOptions Options;
  State Current = State::Connecting;
  bool HasStreamed = false;
  bool MayRetryAtOnce = true; // the current connection has received something
  // The last connection broke the protocol, and no outstanding blob has arrived since. Then other
  // messages do not allow an immediate retry: if every frame were garbled, retries would never end.
  bool Garbled = false;
  std::vector<SessionRequest> Early; // requests made before it is known whether there is a stream
  StreamConversation Stream;
  GetConversation Gets;
  bool Retrying = false; // a retry is due at RetryAt
  bool Resting = false;  // lost, and nothing has been requested since
  double RetryAt = 0, RetryAfter = 0;
  std::size_t Tries = 0; // attempts to fetch one thing from a busy server, or to open its stream
  bool Probing = false;  // finding out whether there is a stream by now
  double ProbeAt = 0;    // the next time for that
  double LastNews = 0;
  std::string Why;
  std::vector<Action> Actions;
};

}
