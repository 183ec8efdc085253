// SPDX-License-Identifier: BSD-3-Clause
// Translates mouse, wheel, keys and fingers on the model into steps of a session. The left button
// of the mouse acts as one finger, the right button as two. What they do is decided by the session.
#pragma once

#include "viewer/desktop/window/WindowEvent.h"
#include "viewer/session/InputTouches.h"
#include "viewer/session/SessionFile.h"

#include <map>
#include <vector>

namespace kdstream
{

class WindowInput
{
public:
  // The part of the window that shows the model: its upper left corner, and its pixels.
  void SetView(double left, double top, const Viewport& view);

  // Returns the steps for an event; moves give none until Flush. Keys: arrows turn, + and - zoom,
  // Home and h go home, u and Backspace undo a jump, Return acts as a double tap in the middle.
  std::vector<SessionStep> Handle(const WindowEvent& event);
  // Returns all moves since the last call as one step. Call this before each frame.
  std::vector<SessionStep> Flush();

  bool Touching() const { return !this->Down.empty(); }

private:
  SessionStep Touches(double time) const;
  std::vector<SessionStep> Zoom(double factor, const WindowEvent& event);
  std::vector<SessionStep> Put(std::int64_t pointer, const WindowEvent& event, bool isPair);
  std::vector<SessionStep> Lift(std::int64_t pointer, const WindowEvent& event);
  void Move(std::int64_t pointer, const WindowEvent& event);
  std::vector<SessionStep> Key(const WindowEvent& event) const;
  SessionStep ZoomAt(double factor, double x, double y) const;

  double Left = 0, Top = 0;
  Viewport View;
  std::map<std::int64_t, Pointer> Down; // key 0: the mouse; from 1 on: fingers
  bool Moved = false;
  double MovedAt = 0;
};

}
