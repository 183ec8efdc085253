// SPDX-License-Identifier: BSD-3-Clause
// What fingers, wheel and keys do to the camera: see CameraControl.h.
#include "viewer/session/camera/CameraControl.h"

#include "viewer/session/camera/FreeWay.h"

#include <algorithm>
#include <cmath>

namespace kdstream
{
namespace
{
constexpr double pointOfCloud = 2; // screen points: a cloud's point this near stops the eye

// The direction from the model towards an eye that looks at this side. Nothing for an unknown side.
std::optional<Vec3> DirectionOfSide(std::string_view side, const Vec3& up, const Vec3& front)
{
  const Vec3 right = Cross(up, front);
  return side == "front"    ? std::optional(front)
         : side == "back"   ? std::optional(front * -1)
         : side == "right"  ? std::optional(right)
         : side == "left"   ? std::optional(right * -1)
         : side == "top"    ? std::optional(up)
         : side == "bottom" ? std::optional(up * -1)
                            : std::nullopt;
}

// The horizontal direction from the model towards the eye of the first view.
Vec3 LevelFront(const HomeView& homeView)
{
  constexpr double least = 0.1; // a first view from nearly above does not show where the front is
  const auto level = [&homeView](const Vec3& v) { return v - homeView.up * Dot(v, homeView.up); };
  const Vec3 front = level(homeView.view);
  return Normalized(Length(front) > least ? front : level(FrontOf(homeView.up)));
}

}

CameraControl::CameraControl(const ShownModel& model, Turning turning, bool coasts)
  : Model(model)
  , Turns(turning)
  , CoastsOn(coasts)
{
  this->Eye.SetTurning(turning);
}

void CameraControl::Reset()
{
  this->EyeMoved = this->IsLed = false;
  this->Earlier.clear();
  this->Turned = {};
  this->Linked.reset();
  this->Left.reset();
}

void CameraControl::Fit()
{
  const ModelDescription& model = this->Model.open->description;
  const HomeView homeView = model.homeView.value_or(HomeView{});
  this->Eye.SetUp(homeView.up);
  this->Eye.FitTo(model.box, LookingFrom(homeView.view, homeView.up));
  this->EyeMoved = false;
  this->IsArriving = false;
  this->Turned.Stop();
}

// ---- motions

double CameraControl::FreePartTo(const Camera& moved) const
{
  return FreePart(this->Model, this->Eye, moved, this->Eye.TangentOf(pointOfCloud));
}

// Moves as far as the eye may go. A turn goes all the way or not at all.
void CameraControl::Move(Camera moved)
{
  this->IsArriving = false;
  KeepInSight(this->Model, moved);
  const double part = this->FreePartTo(moved);
  if (part == 1)
  {
    this->Eye = moved;
  }
  else if (moved.Orientation() == this->Eye.Orientation())
  {
    this->Eye = this->Eye.PartOfTheWayTo(moved, part);
  }
}

// If the eye is inside the surface, steps back out of it: a finer surface may lie in front of the
// coarser one that stopped the eye. Not while the view of a link is loading: that view was outside
// the surface that will arrive.
void CameraControl::StepOutside()
{
  constexpr int mostWalls = 8;
  constexpr double beyond = 1.1;
  const bool mayBeInside =
    this->Model.open && this->Model.open->isClosed && !this->IsArriving && !this->IsLed;
  for (int i = 0; i < mostWalls && mayBeInside && IsInside(this->Model, this->Eye); ++i)
  {
    const auto wall = this->Model.Pick({ this->Eye.Eye(), this->Eye.Forward() * -1 });
    if (!wall || i + 1 == mostWalls)
    {
      this->Fit();
      return;
    }
    this->Eye.StepBack(beyond * wall->distance);
  }
}

// The same view in another window. After a zoom the eye stays where the user has put it; otherwise
// what was visible of the model fits the new window. If the model would then be out of sight, and
// the way back would go through the surface: goes to the first view.
void CameraControl::Take(const Camera& view, const Viewport& viewport)
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
      KeepInSight(this->Model, this->Eye);
    }
  }
  if (this->Model.open &&
      FreePart(this->Model, view, this->Eye, this->Eye.TangentOf(pointOfCloud)) < 1)
  {
    this->Fit();
  }
}

// In a window of the same size nothing changes. Until the user moves, each window shows what was
// visible in the first one: a phone that is rotated and rotated back shows the same.
void CameraControl::Refit(const Viewport& viewport)
{
  Camera here = this->Eye;
  here.SetViewport(viewport);
  if (here.GetViewport() == this->Eye.GetViewport() ||
      (this->Linked && this->GoToLinkedPlace(viewport)))
  {
    return;
  }
  if (!this->Left || !(this->Left->eye == this->Eye))
  {
    this->Left = LeftView{ this->Now(), {} };
  }
  const View view = this->Left->view;
  this->EyeMoved = view.moved;
  this->Take(view.eye, viewport);
  this->Left->eye = this->Eye;
}

void CameraControl::Resize(const Viewport& viewport)
{
  this->Refit(viewport);
  this->Gestures.SetPixelRatio(this->Eye.GetViewport().pixelRatio);
}

void CameraControl::SetTurning(Turning turning)
{
  this->Turns = turning;
  this->Eye.SetTurning(turning);
}

// ---- jumps

void CameraControl::NoteJump(const View& before)
{
  constexpr std::size_t mostEarlier = 32;
  if (before.eye != this->Eye)
  {
    this->Earlier.push_back(before);
  }
  if (this->Earlier.size() > mostEarlier)
  {
    this->Earlier.pop_front();
  }
}

void CameraControl::JumpHome()
{
  if (this->Model.open)
  {
    const View before = this->Now();
    this->Fit();
    this->NoteJump(before);
  }
}

std::optional<Vec3> CameraControl::TowardsSide(std::string_view side) const
{
  if (!this->Model.open)
  {
    return std::nullopt;
  }
  const HomeView homeView = this->Model.open->description.homeView.value_or(HomeView{});
  return DirectionOfSide(side, homeView.up, LevelFront(homeView));
}

bool CameraControl::JumpToSide(std::string_view side)
{
  const HomeView homeView =
    this->Model.open ? this->Model.open->description.homeView.value_or(HomeView{}) : HomeView{};
  const Vec3 front = LevelFront(homeView);
  const auto direction = DirectionOfSide(side, homeView.up, front);
  if (this->Model.open && direction)
  {
    const View before = this->Now();
    this->Fit();
    // Seen from above, the front is at the lower edge of the screen; seen from below, at the upper
    // edge.
    const bool isLevel = std::abs(Dot(*direction, homeView.up)) < 0.5;
    const Vec3 right = Cross(homeView.up, front);
    this->Eye.FitTo(this->Model.open->description.box,
      isLevel ? LookingFrom(*direction, homeView.up)
              : Quaternion::OfAxes(right, Cross(*direction, right), *direction));
    this->NoteJump(before);
  }
  return direction.has_value();
}

void CameraControl::TakePlace(const std::optional<CameraPlace>& place, bool isJump)
{
  const View before = this->Now();
  this->Turned.Stop();
  if (place)
  {
    this->GoTo(*place);
  }
  if (isJump)
  {
    this->NoteJump(before);
  }
}

// Goes to a place of the camera, in the current window.
void CameraControl::GoTo(const CameraPlace& place)
{
  Camera there = this->Eye;
  there.SetPlace(place);
  there.SetTurning(this->Turns);
  this->Take(there, there.GetViewport());
  this->EyeMoved = this->IsArriving = true;
  this->Linked = LinkedView{ place, this->Eye };
}

// A window may still change its shape while it opens. So if the user has not moved since a link was
// followed, the link is followed again. False if the user has moved.
bool CameraControl::GoToLinkedPlace(const Viewport& viewport)
{
  if (!(this->Linked->eye == this->Eye))
  {
    return false;
  }
  this->Eye.SetViewport(viewport);
  this->GoTo(CameraPlace(this->Linked->place));
  return true;
}

bool CameraControl::Undo()
{
  this->Turned.Stop();
  if (this->Earlier.empty())
  {
    return false;
  }
  const View view = this->Earlier.back();
  this->Earlier.pop_back();
  this->EyeMoved = view.moved;
  this->Take(view.eye, this->Eye.GetViewport());
  this->Eye.SetTurning(this->Turns);
  this->StepOutside();
  return true;
}

bool CameraControl::LookFrom(
  const Vec3& eye, const Vec3& focal, const Vec3& up, double tangent, bool begins)
{
  const Camera before = this->Eye;
  this->Eye.LookFrom(eye, focal, up, tangent);
  this->IsLed = true;
  const bool moves = begins || this->Eye != before;
  this->EyeMoved = this->EyeMoved || moves;
  return moves;
}

// ---- fingers

std::vector<Gesture> CameraControl::BeginTouches(const TouchFrame& frame)
{
  if (!frame.touches.empty())
  {
    this->Turned.SetSpinning(false);
    this->Turned.Stop();
  }
  if (frame.touches.size() == 1)
  {
    this->Turned.Touch(frame.time);
  }
  return this->Gestures.HandleTouches(frame);
}

void CameraControl::EndTouches(const TouchFrame& frame)
{
  if (frame.touches.empty())
  {
    this->Turned.Forget();
  }
}

void CameraControl::CancelTouches()
{
  this->Gestures.Reset();
  this->Turned.Forget();
}

void CameraControl::Drag(const Momentum::Drag& drag)
{
  Camera moved = this->Eye;
  moved.Rotate(drag.x - drag.dx, drag.y - drag.dy, drag.x, drag.y);
  this->Move(moved);
}

void CameraControl::Handle(const Gesture& gesture, double time, bool isTaken)
{
  switch (gesture.kind)
  {
    case Gesture::Kind::Rotate:
      if (!isTaken)
      {
        this->Drag({ gesture.x, gesture.y, gesture.dx, gesture.dy });
        this->Turned.Follow(time, gesture.dx, gesture.dy);
      }
      break;
    case Gesture::Kind::RotateEnd:
      if (this->CoastsOn)
      {
        this->Turned.LetGo(time, gesture.x, gesture.y, this->Eye.GetViewport().pixelRatio);
      }
      break;
    case Gesture::Kind::PinchBegin:
      this->Turned.Forget();
      this->FocusUnder(gesture.x, gesture.y);
      break;
    case Gesture::Kind::Pinch:
      if (!isTaken)
      {
        this->PanAndRoll(gesture);
      }
      this->Zoom(gesture.scale, gesture.x, gesture.y);
      break;
    default:
      break;
  }
}

std::optional<SurfaceHit> CameraControl::PickUnder(double x, double y) const
{
  return this->Model.Pick(this->Eye.RayOf(x, y), this->Eye.TangentOf(fingerPoints));
}

void CameraControl::FocusUnder(double x, double y)
{
  if (const auto hit = this->PickUnder(x, y))
  {
    Camera focused = this->Eye;
    focused.FocusAtDepthOf(hit->point);
    const Camera there = focused;
    KeepInSight(this->Model, focused);
    if (focused == there) // there is enough of the surface at that depth to turn about
    {
      this->Eye = focused;
    }
  }
}

void CameraControl::PanAndRoll(const Gesture& pinch)
{
  Camera moved = this->Eye;
  moved.Pan(pinch.dx, pinch.dy);
  this->Move(moved);
  moved = this->Eye;
  moved.Roll(pinch.twistCosine, pinch.twistSine, pinch.x, pinch.y);
  this->Move(moved);
}

// Zooms, and stops before the surface. When zooming out, the eye goes straight back through
// whatever is behind it.
void CameraControl::Zoom(double factor, double x, double y)
{
  this->EyeMoved = true;
  Camera moved = this->Eye;
  moved.Zoom(factor, x, y);
  KeepInSight(this->Model, moved);
  if (factor < 1 && this->FreePartTo(moved) < 1)
  {
    this->IsArriving = false;
    this->Eye.StepBack(moved.Distance() - this->Eye.Distance());
    this->StepOutside();
  }
  else
  {
    this->Move(moved);
  }
}

bool CameraControl::ZoomAbout(double factor, double x, double y)
{
  const bool isFinite = std::isfinite(factor) && std::isfinite(x) && std::isfinite(y);
  if (!this->Model.open || !(factor > 0) || !isFinite)
  {
    return false;
  }
  this->Turned.Stop();
  this->Turned.SetSpinning(false);
  this->FocusUnder(x, y);
  this->Zoom(factor, x, y);
  return true;
}

// ---- turning by itself

void CameraControl::SetCoasting(bool coasts)
{
  this->CoastsOn = coasts;
  if (!coasts)
  {
    this->Turned.Stop();
  }
}

CameraControl::Advanced CameraControl::Advance(double time)
{
  Advanced done;
  if (this->Turned.IsSpinning() && this->Model.open && std::isfinite(time))
  {
    this->Drag(this->Turned.Spin(time, this->Eye.GetViewport()));
    done.spun = true;
  }
  for (const Momentum::Drag& drag : this->Turned.Advance(time, this->Eye.GetViewport().pixelRatio))
  {
    this->Drag(drag);
    done.coasted = true;
  }
  return done;
}

void CameraControl::Arrive()
{
  if (this->IsArriving)
  {
    this->IsArriving = false;
    this->StepOutside();
  }
}

}
