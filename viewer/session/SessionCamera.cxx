// SPDX-License-Identifier: BSD-3-Clause
// What fingers, wheel and keys do to the camera of a session, and what keeps a person from getting
// lost: step "look" of the pipeline picture.
//
// Every motion goes through Move, which stops the eye before the shown surface. Where the eye is
// outside the model's box it is outside the surface; from there each way is straight and crosses no
// triangle. So the eye stays outside, whatever the motions are. Zooming out alone goes through what
// is behind the eye, to a place that is outside again: it always leads away.
//
// Some of the shown surface is near enough to the focal point to be on the screen (KeepInSight).
#include "viewer/session/ViewerSession.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kdstream
{
namespace
{
constexpr double mostOfTheWay = 0.9;      // to what is ahead,
constexpr double leastInDiagonals = 1e-5; // so far before it: beyond what rounding does
constexpr double pointOfCloud = 2; // points of the screen that a cloud's point stops the eye by
}

// The first view.
void ViewerSession::FitModel()
{
  const ModelPose pose = this->Current->description.pose.value_or(ModelPose{});
  this->Eye.SetUp(pose.up);
  this->Eye.FitTo(this->Current->box, LookingFrom(pose.view, pose.up));
  this->EyeMoved = false;
  this->IsArriving = false;
  this->Turned.Stop();
}

// To the surface or, where none is shown, the box; infinite where neither is ahead.
double ViewerSession::DistanceToObstacle(const Ray& ray) const
{
  constexpr double none = std::numeric_limits<double>::infinity();
  if (!this->Shown.IsEmpty())
  {
    const double slack = pointOfCloud * this->Eye.GetViewport().pixelRatio /
                         (this->Eye.PixelsPerUnit() * this->Eye.Distance());
    const auto hit = this->Pick(ray, slack);
    return hit ? hit->distance : none;
  }
  const Box& box = this->Current->box;
  double enters = 0, leaves = none;
  for (std::size_t k = 0; k < 3; ++k)
  {
    const double a = (box.lo[k] - ray.origin[k]) / ray.direction[k];
    const double b = (box.hi[k] - ray.origin[k]) / ray.direction[k];
    if (ray.direction[k] != 0)
    {
      enters = std::max(enters, std::min(a, b));
      leaves = std::min(leaves, std::max(a, b));
    }
    else if (ray.origin[k] < box.lo[k] || ray.origin[k] > box.hi[k])
    {
      return none;
    }
  }
  return enters <= leaves ? enters : none;
}

// How much of the straight way between the two eyes may be gone: 0-1.
double ViewerSession::FreePart(const Camera& from, const Camera& to) const
{
  const Vec3 way = to.Eye() - from.Eye();
  const double length = Length(way);
  if (length == 0 || to.DistanceTo(this->Current->box) > 0)
  {
    return 1;
  }
  const double ahead = this->DistanceToObstacle({ from.Eye(), way * (1 / length) });
  const Box& box = this->Current->box;
  const double least = leastInDiagonals * Length(box.hi - box.lo);
  const double most = std::max(0.0, std::min(mostOfTheWay * ahead, ahead - least));
  return std::min(1.0, most / length);
}

// The surface, that is: the camera itself knows no more than a box, of which most may be empty.
void ViewerSession::KeepInSight(Camera& camera) const
{
  const std::optional<SectionPlane>& section = this->Section.Plane();
  if (const auto nearest = NearestOnSurface(
        *this->Shown.GetSurface(), camera.Focal(), camera.Reach(), section ? &*section : nullptr))
  {
    camera.KeepInSight(nearest->point);
  }
}

// As far as the eye may go. What turns goes all the way or not at all.
void ViewerSession::Move(Camera moved)
{
  this->IsArriving = false;
  this->KeepInSight(moved);
  const double part = this->FreePart(this->Eye, moved);
  if (part == 1)
  {
    this->Eye = moved;
  }
  else if (moved.Orientation() == this->Eye.Orientation())
  {
    this->Eye = this->Eye.PartOfTheWayTo(moved, part);
  }
}

// Straight back, whatever is behind the eye.
void ViewerSession::BackAway(double length)
{
  this->IsArriving = false;
  this->Eye.StepBack(length);
  this->StepOutside();
}

// A finer surface may lie before the coarser one by which the eye was stopped. Not on the way to a
// view of somebody else's: that was outside of the surface that comes.
void ViewerSession::StepOutside()
{
  constexpr int mostWalls = 8;
  constexpr double beyond = 1.1;
  const auto isInside = [this]
  {
    const std::optional<SectionPlane>& section = this->Section.Plane();
    return this->Eye.DistanceTo(this->Current->box) == 0 &&
           !(section && section->CutsAway(this->Eye.Eye())) &&
           IsAround(*this->Shown.GetSurface(), this->Eye.Eye());
  };
  const bool mayBeInside =
    this->Current && this->Current->isClosed && !this->IsArriving && !this->IsLed;
  for (int i = 0; i < mostWalls && mayBeInside && isInside(); ++i)
  {
    const Ray back{ this->Eye.Eye(), this->Eye.Forward() * -1 };
    const auto wall = this->Pick(back);
    if (!wall || i + 1 == mostWalls)
    {
      this->FitModel();
      return;
    }
    this->Eye.StepBack(beyond * wall->distance);
  }
}

// The same view in another window. Who has zoomed has chosen the eye's place, which stays; else
// what was seen of the model fits that window. If the model would be lost in it, and only a way
// through the surface led back, the first one.
void ViewerSession::TakeView(const Camera& view, const Viewport& viewport)
{
  this->Eye = view;
  this->Eye.SetViewport(viewport);
  if (!(this->Eye.GetViewport() == view.GetViewport()))
  {
    if (!this->EyeMoved)
    {
      this->Eye = view;
      this->Eye.MoveTo(viewport);
    }
    if (this->EyeMoved || !view.IsFitted())
    {
      this->KeepInSight(this->Eye);
    }
  }
  if (this->Current && this->FreePart(view, this->Eye) < 1)
  {
    this->FitModel();
  }
}

// In the window as it is nothing changes. As long as nobody moves, each window shows what was seen
// in the first one: a phone that is turned and turned back shows the same.
void ViewerSession::TakeWindow(const Viewport& viewport)
{
  Camera here = this->Eye;
  here.SetViewport(viewport);
  if (here.GetViewport() == this->Eye.GetViewport() ||
      (this->Told && this->TakeToldPlace(viewport)))
  {
    return;
  }
  if (!this->Left || !(this->Left->eye == this->Eye))
  {
    this->Left = LeftView{ { this->Eye, this->EyeMoved }, {} };
  }
  const EarlierView view = this->Left->view;
  this->EyeMoved = view.moved;
  this->TakeView(view.eye, viewport);
  this->Left->eye = this->Eye;
}

void ViewerSession::Turn(const Momentum::Drag& drag)
{
  Camera moved = this->Eye;
  moved.Rotate(drag.x - drag.dx, drag.y - drag.dy, drag.x, drag.y);
  this->Move(moved);
}

// ---- jumps

void ViewerSession::JumpHome()
{
  const EarlierView before{ this->Eye, this->EyeMoved };
  this->FitModel();
  this->NoteJump(before);
}

void ViewerSession::GoHome()
{
  if (this->Current)
  {
    this->JumpHome();
    this->FollowZoom();
  }
  this->Update();
  this->Trace("home");
}

void ViewerSession::UndoView()
{
  this->Turned.Stop();
  if (this->Current && !this->EarlierViews.empty())
  {
    const EarlierView view = this->EarlierViews.back();
    this->EarlierViews.pop_back();
    this->EyeMoved = view.moved;
    this->TakeView(view.eye, this->Eye.GetViewport());
    this->Eye.SetTurning(this->Options.turning);
    this->StepOutside();
    this->Mode = this->EyeMoved ? ViewerMode::FullScreen : this->Mode;
    this->FollowZoom();
  }
  this->Update();
  this->Trace("undo");
}

void ViewerSession::SetTurning(Turning turning)
{
  this->Options.turning = turning;
  this->Eye.SetTurning(turning);
  this->Update();
  this->Trace("turning");
}

// ---- motions

void ViewerSession::CancelTouches()
{
  this->Gestures.Reset();
  this->Turned.Forget();
  this->Trace("cancel touches");
}

void ViewerSession::Zoom(double factor, double x, double y)
{
  if (this->Current && factor > 0 && std::isfinite(factor) && std::isfinite(x) && std::isfinite(y))
  {
    this->Turned.Stop();
    this->SetSpinning(false);
    this->FocusUnder(x, y);
    this->ZoomBy(factor, x, y);
  }
  this->Update();
  this->Trace("zoom");
}

// When zooming, the point of the surface under the pixel stays there; if there is none, the point
// at the depth of the focal point.
void ViewerSession::FocusUnder(double x, double y)
{
  this->Retry();
  if (const auto hit = this->PickUnder(x, y))
  {
    Camera focused = this->Eye;
    focused.FocusAtDepthOf(hit->point);
    const Camera there = focused;
    this->KeepInSight(focused);
    if (focused == there) // there is enough of the surface at that depth to turn about
    {
      this->Eye = focused;
    }
  }
}

void ViewerSession::ZoomBy(double factor, double x, double y)
{
  this->EyeMoved = true;
  this->Mode = ViewerMode::FullScreen;
  Camera moved = this->Eye;
  moved.Zoom(factor, x, y);
  this->KeepInSight(moved);
  if (factor < 1 && this->FreePart(this->Eye, moved) < 1)
  {
    this->BackAway(moved.Distance() - this->Eye.Distance());
  }
  else
  {
    this->Move(moved);
  }
  this->FollowZoom();
}

void ViewerSession::HandleTouches(const TouchFrame& frame)
{
  if (!frame.touches.empty())
  {
    this->SetSpinning(false);
    this->Turned.Stop();
  }
  if (frame.touches.size() == 1)
  {
    this->Turned.Touch(frame.time);
  }
  for (const Gesture& gesture : this->Gestures.HandleTouches(frame))
  {
    this->Handle(gesture, frame.time);
  }
  if (frame.touches.empty())
  {
    this->Turned.Forget();
  }
  this->Update();
  this->Trace("touches");
}

void ViewerSession::PanAndRoll(const Gesture& gesture)
{
  Camera moved = this->Eye;
  moved.Pan(gesture.dx, gesture.dy);
  this->Move(moved);
  moved = this->Eye;
  moved.Roll(gesture.twistCosine, gesture.twistSine, gesture.x, gesture.y);
  this->Move(moved);
}

// Of one finger, or a tap: whether the tool in hand has a use for it.
bool ViewerSession::TakeDrag(const Gesture& gesture)
{
  if (this->Mode != ViewerMode::FullScreen)
  {
    return false;
  }
  if (this->InHand == Tool::Section && this->Section.Plane())
  {
    this->DragSection(gesture.dx, gesture.dy);
    return true;
  }
  if (this->InHand == Tool::Light || this->InHand == Tool::SecondLight)
  {
    this->ShineFrom(gesture.x, gesture.y);
    return true;
  }
  return false;
}

void ViewerSession::Handle(const Gesture& gesture, double time)
{
  if (!this->Current)
  {
    return;
  }
  switch (gesture.kind)
  {
    case Gesture::Kind::Rotate:
      if (this->TakeDrag(gesture))
      {
        break;
      }
      this->Turn({ gesture.x, gesture.y, gesture.dx, gesture.dy });
      this->Turned.Follow(time, gesture.dx, gesture.dy);
      break;
    case Gesture::Kind::RotateEnd:
      if (this->Options.coasts)
      {
        this->Turned.LetGo(time, gesture.x, gesture.y, this->Eye.GetViewport().pixelRatio);
      }
      break;
    case Gesture::Kind::PinchBegin:
      this->Turned.Forget();
      this->FocusUnder(gesture.x, gesture.y);
      break;
    case Gesture::Kind::Pinch:
      if (this->InHand == Tool::Section && this->Section.Plane())
      {
        this->TurnSection(gesture.dx, gesture.dy);
      }
      else
      {
        this->PanAndRoll(gesture);
      }
      this->ZoomBy(gesture.scale, gesture.x, gesture.y);
      break;
    case Gesture::Kind::PinchEnd:
      break;
    case Gesture::Kind::Tap:
      if (this->Mode == ViewerMode::Browsing)
      {
        this->Mode = ViewerMode::FullScreen;
        this->FollowZoom();
      }
      else if (this->InHand == Tool::Measure)
      {
        this->MeasureAt(gesture.x, gesture.y);
      }
      else
      {
        this->TakeDrag(gesture);
      }
      break;
    case Gesture::Kind::DoubleTap:
      if (this->InHand == Tool::Measure && this->MeasureAt(gesture.x, gesture.y))
      {
        break; // two ends in quick succession
      }
      if (this->InHand != Tool::Measure && this->TakeDrag(gesture))
      {
        break;
      }
      this->DoubleTap(gesture.x, gesture.y);
      break;
  }
}

// ---- what is let go turns on

void ViewerSession::SetCoasting(bool coasts)
{
  this->Options.coasts = coasts;
  if (!coasts)
  {
    this->Turned.Stop();
  }
}

void ViewerSession::SetSpinning(bool spins)
{
  this->Turned.SetSpinning(spins);
}

void ViewerSession::Advance(double time)
{
  if (this->Turned.IsSpinning() && this->Current && std::isfinite(time))
  {
    this->Turn(this->Turned.Spin(time, this->Eye.GetViewport()));
    this->Update();
  }
  const auto drags = this->Turned.Advance(time, this->Eye.GetViewport().pixelRatio);
  for (const Momentum::Drag& drag : drags)
  {
    this->Turn(drag);
  }
  if (!drags.empty())
  {
    this->Update();
    this->Trace("advance");
  }
}

}
