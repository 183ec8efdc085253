// SPDX-License-Identifier: BSD-3-Clause
// Plays a session without a user. Step "replay" of the pipeline picture.
#include "viewer/desktop/Player.h"
#include "viewer/session/SessionParts.h"

#include <utility>

namespace kdstream
{
namespace
{
using Clock = std::chrono::steady_clock;
}

Player::Player(
  ModelSource& source, ViewerSession& session, SessionWindow& window, PlayerOptions options)
  : Source(source)
  , Session(session)
  , Window(window)
  , Options(std::move(options))
{
}

Status Player::Play(const SessionStep& step)
{
  if (this->Options.record)
  {
    this->Options.record(step);
  }
  if (NeedsModel(step) && this->IsOpening())
  {
    KDSTREAM_TRY(this->WaitForIdle());
  }
  switch (step.kind)
  {
    case SessionStep::Kind::WaitForIdle:
      return this->WaitForIdle();
    case SessionStep::Kind::Screenshot:
      KDSTREAM_TRY(this->Frame());
      if (this->Session.GetStatus().vertices == 0)
      {
        return Error{ ErrorCode::NotFound, "is not written: no part of the model could be shown" };
      }
      return this->Window.SavePicture(step.name);
    case SessionStep::Kind::Window:
      this->Window.Resize(step.window);
      [[fallthrough]];
    default:
      this->Set(step);
      KDSTREAM_TRY(Perform(step, this->Session));
      this->SendRequests();
      return {};
  }
}

bool Player::IsOpening() const
{
  return this->Session.GetStatus().mode != ViewerMode::NoModel && this->Session.Scene().box.Empty();
}

void Player::Set(const SessionStep& step)
{
  SceneSettings settings = this->Window.Settings();
  Perform(step, settings);
  this->Window.SetSettings(settings);
}

Status Player::WaitForIdle()
{
  const auto begin = Clock::now();
  auto lastNews = begin;
  for (;;)
  {
    this->DeliverEvents();
    this->SendRequests();
    KDSTREAM_TRY(this->Frame());
    this->SendRequests(); // requests that the frame needs
    if (this->Session.IsIdle())
    {
      return {};
    }
    const auto now = Clock::now();
    if (this->Source.Wait(std::chrono::milliseconds(100)))
    {
      lastNews = Clock::now();
    }
    else if (now - lastNews > this->Options.idleTimeout || now - begin > this->Options.longestWait)
    {
      return Error{ ErrorCode::InputOutput,
        "gave up waiting for the server; outstanding: " +
          this->Session.Parts().fetcher.Wishes().Book().Describe() };
    }
    if (this->Options.interrupted && this->Options.interrupted())
    {
      return Error{ ErrorCode::Cancelled, "interrupted" };
    }
  }
}

void Player::DeliverEvents()
{
  for (const ClientEvent& event : this->Source.Take())
  {
    if (event.kind == ClientEvent::Kind::Opened)
    {
      this->Unit = event.model.unit;
    }
    Deliver(event, this->Session);
    this->Complain();
  }
}

void Player::SendRequests()
{
  for (const SessionRequest& request : this->Session.TakeRequests())
  {
    this->Source.Send(request);
  }
}

Status Player::Frame()
{
  const auto begin = Clock::now();
  this->Session.BeginFrame();
  this->Complain();
  Status status = this->Window.Show(this->Session, this->Unit);
  this->Session.EndFrame(std::chrono::duration<double>(Clock::now() - begin).count());
  if (this->Options.drawn)
  {
    this->Options.drawn();
  }
  return status;
}

// Reports each new sentence once, even if the session has no error in between.
void Player::Complain()
{
  const std::string error = this->Session.GetStatus().error;
  if (error.empty() || error == this->LastComplaint)
  {
    return;
  }
  this->LastComplaint = error;
  if (this->Options.complain)
  {
    this->Options.complain(error);
  }
}

}
