// SPDX-License-Identifier: BSD-3-Clause
// When to connect, to send, to fetch and to give up: see ServerLine.h.
#include "viewer/client/ServerLine.h"

#include "filters/core/BitCast.h"
#include "filters/core/MixBits.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <utility>

namespace kdstream
{

ServerLine::ServerLine(ServerLineOptions options)
  : Options(std::move(options))
{
  this->Connect();
}

void ServerLine::Connect()
{
  this->Retrying = this->Resting = false;
  this->Current = State::Connecting;
  this->Actions.push_back({ Action::Kind::Connect, {}, {} });
}

void ServerLine::Send(const SessionRequest& request, double now)
{
  if (this->Current == State::Getting)
  {
    this->Gets.Send(request, now);
    this->FetchNext();
    return;
  }
  if (!this->HasStreamed)
  {
    this->Early.push_back(request);
  }
  if (!this->Stream.IsWaiting())
  {
    this->LastNews = now; // counts silence only from a request on
  }
  this->Stream.Send(request, now);
  const bool waitsForUs = this->Resting || (!this->Options.patient && !this->Retrying);
  if (this->Current == State::Lost && waitsForUs && this->Stream.IsWaiting())
  {
    this->Connect();
  }
  this->Flush();
}

void ServerLine::SocketOpened(double now)
{
  this->Current = State::Streaming;
  this->HasStreamed = true;
  this->Tries = 0;
  this->Probing = false;
  this->Early.clear();
  this->Why.clear();
  this->LastNews = now;
  this->Stream.Restart(now);
  this->Flush();
}

void ServerLine::SocketText(std::string_view text, double now)
{
  if (this->Current == State::Streaming) // else: from a connection that was given up
  {
    this->Receive(this->Stream.ReceiveText(text, now), now);
  }
}

void ServerLine::SocketFrame(std::span<const std::uint8_t> message, double now)
{
  if (this->Current == State::Streaming)
  {
    this->Receive(this->Stream.ReceiveFrame(message, now), now);
  }
}

void ServerLine::Receive(const Status& status, double now)
{
  if (!status)
  {
    this->Garbled = true;
    this->Disconnect(status.GetError().message, now);
    return;
  }
  this->LastNews = now;
  if (!this->Garbled || this->Stream.HasEvents())
  {
    this->Garbled = false;
    this->MayRetryAtOnce = true;
    this->RetryAfter = 0;
  }
  if (this->Stream.IsInBackoff() && !this->Retrying)
  {
    this->RetryLater(now, this->Options.firstRetry);
  }
  this->Flush();
}

void ServerLine::SocketEnded(bool refused, const std::string& why, double now, double retryAfter)
{
  if (this->Current != State::Connecting && this->Current != State::Streaming)
  {
    return;
  }
  const bool isIdle = this->Current == State::Streaming && !this->Stream.IsWaiting();
  if (isIdle && this->MayRetryAtOnce && retryAfter == 0)
  {
    this->Idle(now);
    return;
  }
  if (!this->Probing && (!refused || this->HasStreamed))
  {
    this->Disconnect(why, now, retryAfter);
    return;
  }
  this->EndProbe(now);
}

// The server has no stream (yet): goes on with GETs.
void ServerLine::EndProbe(double now)
{
  this->Probing = false;
  this->ProbeAt = now + this->Jittered(this->Options.streamRetry, now);
  this->Current = State::Getting;
  this->Stream = {};
  this->Why.clear();
  for (const SessionRequest& request : std::exchange(this->Early, {}))
  {
    this->Gets.Send(request, now);
  }
  this->FetchNext();
}

// Tries to open a stream again, to continue with the open model.
void ServerLine::ProbeStream()
{
  this->Probing = true;
  this->Stream = {};
  this->Stream.Adopt(this->Gets.OpenModel(), this->Gets.OpenDigest());
  this->Connect();
}

void ServerLine::Disconnect(const std::string& why, double now, double retryAfter)
{
  this->Why = "the connection to " + this->Options.authority + " was lost: " + why;
  const bool asksForPatience = retryAfter > 0;
  if (std::exchange(this->MayRetryAtOnce, false) && !asksForPatience)
  {
    this->Connect();
    return;
  }
  this->Current = State::Lost;
  this->Actions.push_back({ Action::Kind::Close, {}, {} });
  if (this->Options.patient || (asksForPatience && this->Tries++ < this->Options.mostTries))
  {
    this->RetryLater(now, retryAfter);
  }
  else
  {
    this->Stream.FailAll(this->Why);
  }
  this->Flush();
}

// The connection is lost, and nothing is outstanding.
void ServerLine::Idle(double now)
{
  this->MayRetryAtOnce = false;
  this->Current = State::Lost;
  this->Resting = true;
  this->Actions.push_back({ Action::Kind::Close, {}, {} });
  if (this->Options.patient)
  {
    this->RetryAt = now + this->Jittered(this->Options.idleRetry, now);
    this->Retrying = true;
  }
}

void ServerLine::RetryLater(double now, double atLeast)
{
  this->RetryAfter =
    std::clamp(2 * this->RetryAfter, this->Options.firstRetry, this->Options.longestRetry);
  this->RetryAt = now + this->Jittered(std::max(this->RetryAfter, atLeast), now);
  this->Retrying = true;
}

// The pause, longer by chance. The lowest bits of the time serve as a random number, because they
// differ from client to client.
double ServerLine::Jittered(double pause, double now) const
{
  const std::uint64_t bits = MixBits(BitCast<std::uint64_t>(now) + 0x9E3779B97F4A7C15U);
  const double chance = static_cast<double>(bits >> 11) / 9007199254740992.0; // 2^53
  return pause * (1 + this->Options.jitter * chance);
}

double ServerLine::NextTick() const
{
  constexpr double never = std::numeric_limits<double>::infinity();
  const bool probes = this->Current == State::Getting && this->Options.streamRetry > 0;
  const double stalls =
    this->HasStallTimeout() ? this->Stream.StalledSince() + this->Options.stallTimeout : never;
  return std::min(
    { this->Retrying ? this->RetryAt : never, probes ? this->ProbeAt : never, stalls });
}

void ServerLine::Tick(double now)
{
  if (this->Retrying && now >= this->RetryAt)
  {
    this->Retrying = false;
    if (this->Current == State::Getting)
    {
      this->FetchNext();
    }
    else if (this->Current == State::Streaming)
    {
      this->LastNews = now;
      this->Stream.AskAgain(
        this->Options.patient ? std::numeric_limits<std::size_t>::max() : this->Options.mostTries,
        now);
      this->Flush();
    }
    else if (this->Current == State::Lost)
    {
      this->Connect();
    }
  }
  if (this->Current == State::Getting && this->Options.streamRetry > 0 && now >= this->ProbeAt)
  {
    // If something is in flight, tries again a second later.
    this->Gets.IsIdle() ? this->ProbeStream() : void(this->ProbeAt = now + 1);
  }
  const bool timedOut = this->Current == State::Streaming && this->Options.idleTimeout > 0 &&
                        this->Stream.IsWaiting() &&
                        now - this->LastNews > this->Options.idleTimeout;
  if (timedOut)
  {
    this->Disconnect("nothing arrived for too long", now);
  }
  else if (this->HasStallTimeout() &&
           now >= this->Stream.StalledSince() + this->Options.stallTimeout)
  {
    this->Stream.FailStalled("the server sends other data instead");
    this->Disconnect("the oldest request was not answered", now);
  }
}

void ServerLine::RetryNow()
{
  this->RetryAt = -std::numeric_limits<double>::infinity();
  this->RetryAfter = 0;
}

void ServerLine::FetchNext()
{
  if (this->Retrying)
  {
    return;
  }
  if (auto fetch = this->Gets.Next())
  {
    this->Actions.push_back({ Action::Kind::Fetch, {}, std::move(*fetch) });
  }
}

void ServerLine::Fetched(const Result<HttpReply>& reply, double now)
{
  constexpr unsigned noToken = 401; // a token may come later
  const bool busy =
    reply && (IsBusy(reply->status) || (this->Options.patient && reply->status == noToken));
  if (this->Options.patient ? !reply || busy : busy && this->Tries++ < this->Options.mostTries)
  {
    this->Why = reply ? DescribeRefusal(*reply) : reply.GetError().message;
    this->Gets.PutBack();
    this->RetryLater(now, reply ? reply->retryAfter : 0);
    return;
  }
  this->Tries = 0;
  this->Why.clear();
  this->RetryAfter = 0;
  this->Gets.Receive(reply, now);
  this->FetchNext();
}

void ServerLine::Flush()
{
  for (std::string& message : this->Stream.TakeMessages())
  {
    // Without a connection messages are dropped; Restart sends them again.
    if (this->Current == State::Streaming)
    {
      this->Actions.push_back({ Action::Kind::Send, std::move(message), {} });
    }
  }
}

std::vector<ServerLine::Action> ServerLine::TakeActions()
{
  return std::exchange(this->Actions, {});
}

std::vector<ClientEvent> ServerLine::TakeEvents()
{
  std::vector<ClientEvent> events = this->Stream.TakeEvents();
  if (events.empty())
  {
    return this->Gets.TakeEvents();
  }
  for (ClientEvent& event : this->Gets.TakeEvents())
  {
    events.push_back(std::move(event));
  }
  return events;
}

}
