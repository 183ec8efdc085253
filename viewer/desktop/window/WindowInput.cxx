// SPDX-License-Identifier: BSD-3-Clause
// Mouse, wheel, keys and fingers on the model, as steps of a session.
#include "viewer/desktop/window/WindowInput.h"

#include <cmath>
#include <utility>

namespace kdstream
{
namespace
{

constexpr std::int64_t mouse = 0;
constexpr double wheelZoom = 1.2; // per notch

using Kind = SessionStep::Kind;

SessionStep Go(const char* where)
{
  return { Kind::Go, {}, where };
}

// frameOf: returns the touches of a frame, given the frame's number.
template <class FrameOf>
std::vector<SessionStep> StepsOf(unsigned frames, const FrameOf& frameOf)
{
  std::vector<SessionStep> steps;
  for (unsigned frame = 0; frame < frames; ++frame)
  {
    steps.push_back({ Kind::Touches, frameOf(frame) });
  }
  return steps;
}

}

void WindowInput::SetView(double left, double top, const Viewport& view)
{
  this->Left = left;
  this->Top = top;
  this->View = view;
}

SessionStep WindowInput::Touches(double time) const
{
  SessionStep step{ Kind::Touches, { time, {} } };
  for (const auto& [number, pointer] : this->Down)
  {
    AddTouches(pointer, this->View.pixelRatio, step.frame.touches);
  }
  return step;
}

std::vector<SessionStep> WindowInput::Handle(const WindowEvent& event)
{
  const bool right = event.button != WindowEvent::Button::Left || event.shift;
  switch (event.kind)
  {
    case WindowEvent::Kind::Press:
      return this->Put(mouse, event, right);
    case WindowEvent::Kind::Release:
      return this->Lift(mouse, event);
    case WindowEvent::Kind::Move:
      this->Move(mouse, event);
      return {};
    case WindowEvent::Kind::Wheel:
      return this->Zoom(std::pow(wheelZoom, event.notches), event);
    case WindowEvent::Kind::Pinch:
      return this->Zoom(event.scale, event);
    case WindowEvent::Kind::Key:
      return this->Key(event);
    case WindowEvent::Kind::TouchBegin:
      return this->Put(1 + event.finger, event, false);
    case WindowEvent::Kind::TouchMove:
      this->Move(1 + event.finger, event);
      return {};
    case WindowEvent::Kind::TouchEnd:
      return this->Lift(1 + event.finger, event);
  }
  return {};
}

std::vector<SessionStep> WindowInput::Flush()
{
  if (!std::exchange(this->Moved, false))
  {
    return {};
  }
  return { this->Touches(this->MovedAt) };
}

std::vector<SessionStep> WindowInput::Zoom(double factor, const WindowEvent& event)
{
  auto steps = this->Flush();
  steps.push_back(this->ZoomAt(factor, event.x - this->Left, event.y - this->Top));
  return steps;
}

std::vector<SessionStep> WindowInput::Put(
  std::int64_t pointer, const WindowEvent& event, bool isPair)
{
  auto steps = this->Flush();
  if (this->Down.count(pointer) == 0) // otherwise it is another button of the mouse
  {
    this->Down[pointer] = { 2 * pointer, event.x - this->Left, event.y - this->Top, isPair };
    steps.push_back(this->Touches(event.time));
  }
  return steps;
}

std::vector<SessionStep> WindowInput::Lift(std::int64_t pointer, const WindowEvent& event)
{
  auto steps = this->Flush();
  if (this->Down.erase(pointer) > 0)
  {
    steps.push_back(this->Touches(event.time));
  }
  return steps;
}

void WindowInput::Move(std::int64_t pointer, const WindowEvent& event)
{
  const auto finger = this->Down.find(pointer);
  if (finger == this->Down.end())
  {
    return;
  }
  finger->second.x = event.x - this->Left;
  finger->second.y = event.y - this->Top;
  this->Moved = true;
  this->MovedAt = event.time;
}

std::vector<SessionStep> WindowInput::Key(const WindowEvent& event) const
{
  static const std::map<std::string, std::pair<int, int>, std::less<>> turns{ { "Left", { -1, 0 } },
    { "Right", { 1, 0 } }, { "Up", { 0, -1 } }, { "Down", { 0, 1 } } };
  static const std::map<std::string, double, std::less<>> zooms{ { "plus", keyZoom },
    { "equal", keyZoom }, { "KP_Add", keyZoom }, { "minus", 1 / keyZoom },
    { "KP_Subtract", 1 / keyZoom } };
  static const std::map<std::string, const char*, std::less<>> jumps{ { "Home", "home" },
    { "h", "home" }, { "u", "undo" }, { "BackSpace", "undo" } };
  if (event.control)
  {
    return {};
  }
  if (const auto turn = turns.find(event.key); turn != turns.end())
  {
    const auto& way = turn->second;
    return StepsOf(this->Touching() ? 0 : dragFrames, [&](unsigned frame)
      { return DragByKey(this->View, way.first, way.second, false, event.time, frame); });
  }
  if (const auto zoom = zooms.find(event.key); zoom != zooms.end())
  {
    return { this->ZoomAt(zoom->second, 0.5 * this->View.width, 0.5 * this->View.height) };
  }
  if (const auto jump = jumps.find(event.key); jump != jumps.end())
  {
    return { Go(jump->second) };
  }
  const bool isReturn = event.key == "Return" || event.key == "KP_Enter";
  return StepsOf(isReturn && !this->Touching() ? 2 * tapFrames : 0,
    [&](unsigned frame) { return TapByKey(this->View, event.time, frame); });
}

SessionStep WindowInput::ZoomAt(double factor, double x, double y) const
{
  SessionStep step{ Kind::Zoom, {} };
  step.factor = factor;
  step.x = x;
  step.y = y;
  return step;
}

}
