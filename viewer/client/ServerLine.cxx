// SPDX-License-Identifier: BSD-3-Clause
// When to connect, to send, to fetch and to give up: see ServerLine.h.
#include "viewer/client/ServerLine.h"

#include <algorithm>
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
  this->Retrying = false;
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
    this->LastNews = now; // silence begins when there is something to say
  }
  this->Stream.Send(request, now);
  if (this->Current == State::Lost && !this->Options.patient && this->Stream.IsWaiting())
  {
    this->Connect();
  }
  this->Flush();
}

void ServerLine::SocketOpened(double now)
{
  this->Current = State::Streaming;
  this->HasStreamed = true;
  this->Early.clear();
  this->Why.clear();
  this->LastNews = now;
  this->Stream.Restart(now);
  this->Flush();
}

void ServerLine::SocketText(std::string_view text, double now)
{
  if (this->Current == State::Streaming) // else: the rest of a connection that was given up
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
    this->Lose(status.GetError().message, now);
    return;
  }
  this->LastNews = now;
  if (!this->Garbled || this->Stream.HasEvents())
  {
    this->Garbled = false;
    this->MayRetryAtOnce = true;
    this->RetryAfter = 0;
  }
  this->Flush();
}

void ServerLine::SocketEnded(bool refused, const std::string& why, double now)
{
  if (this->Current != State::Connecting && this->Current != State::Streaming)
  {
    return;
  }
  if (!refused || this->HasStreamed)
  {
    this->Lose(why, now);
    return;
  }
  this->Current = State::Getting;
  this->Why.clear();
  for (const SessionRequest& request : std::exchange(this->Early, {}))
  {
    this->Gets.Send(request, now);
  }
  this->FetchNext();
}

void ServerLine::Lose(const std::string& why, double now)
{
  this->Why = "the connection to " + this->Options.authority + " was lost: " + why;
  if (std::exchange(this->MayRetryAtOnce, false))
  {
    this->Connect();
    return;
  }
  this->Current = State::Lost;
  this->Actions.push_back({ Action::Kind::Close, {}, {} });
  if (this->Options.patient)
  {
    this->RetryLater(now);
  }
  else
  {
    this->Stream.FailAll(this->Why);
  }
  this->Flush();
}

void ServerLine::RetryLater(double now)
{
  this->RetryAfter =
    std::clamp(2 * this->RetryAfter, this->Options.firstRetry, this->Options.longestRetry);
  this->RetryAt = now + this->RetryAfter;
  this->Retrying = true;
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
    else
    {
      this->Connect();
    }
  }
  const bool silent = this->Current == State::Streaming && this->Options.longestSilence > 0 &&
                      this->Stream.IsWaiting() &&
                      now - this->LastNews > this->Options.longestSilence;
  if (silent)
  {
    this->Lose("it brought nothing for too long", now);
  }
}

void ServerLine::Hurry()
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
  if (!reply && this->Options.patient)
  {
    this->Why = reply.GetError().message;
    this->Gets.PutBack();
    this->RetryLater(now);
    return;
  }
  this->Why.clear();
  this->RetryAfter = 0;
  this->Gets.Receive(reply, now);
  this->FetchNext();
}

void ServerLine::Flush()
{
  for (std::string& message : this->Stream.TakeMessages())
  {
    // What is said while there is no connection is said again by Restart.
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
  for (ClientEvent& event : this->Gets.TakeEvents())
  {
    events.push_back(std::move(event));
  }
  return events;
}

}
