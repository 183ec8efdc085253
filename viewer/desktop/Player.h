// SPDX-License-Identifier: BSD-3-Clause
// Plays a session without a user: gives steps to the session, requests to the source, and frames to
// a window. Step "replay" of the pipeline picture.
#pragma once

#include "viewer/client/ModelSource.h"
#include "viewer/desktop/SessionWindow.h"
#include "viewer/session/SessionFile.h"
#include "viewer/session/ViewerSession.h"

#include <chrono>
#include <functional>
#include <string>
#include <vector>

namespace kdstream
{

struct PlayerOptions
{
  // A wait fails if the server has sent nothing for idleTimeout, or if it lasts longer than
  // longestWait.
  std::chrono::seconds idleTimeout{ 120 };
  std::chrono::seconds longestWait{ 1800 };
  // Called with each step before it is done.
  std::function<void(const SessionStep&)> record;
  // Called with a sentence for each part that could not be loaded; the session goes on.
  std::function<void(const std::string&)> complain;
  // Called after each frame.
  std::function<void()> drawn;
  // Whether to give up a wait.
  std::function<bool()> interrupted;
};

// Processes the server's answers only during waits, and uses the times in the steps instead of a
// clock. So the same steps give the same gestures, picks and levels, however fast the server is. A
// step that needs a model waits until the chosen model has arrived.
class Player
{
public:
  // References are kept.
  Player(ModelSource& source, ViewerSession& session, SessionWindow& window, PlayerOptions options);

  // Errors: those of the step, naming the model, the picture, or the outstanding requests; NotFound
  // for a picture that would show nothing (it is not written).
  Status Play(const SessionStep& step);

private:
  bool IsOpening() const; // a model is chosen, and has not arrived
  void Set(const SessionStep& step);
  Status WaitForIdle();
  Status Frame();
  void SendRequests();
  void DeliverEvents();
  void Complain();

  ModelSource& Source;
  ViewerSession& Session;
  SessionWindow& Window;
  PlayerOptions Options;
  std::string LastComplaint;
  std::string Unit; // of the model that was opened last
};

}
