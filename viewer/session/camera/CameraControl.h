// SPDX-License-Identifier: BSD-3-Clause
// Moves the camera by fingers, wheel and keys, and keeps the user from getting lost: step
// "navigate" of the pipeline picture.
#pragma once

#include "viewer/session/Camera.h"
#include "viewer/session/GestureRecognizer.h"
#include "viewer/session/camera/Momentum.h"
#include "viewer/session/model/ShownModel.h"

#include <deque>
#include <optional>
#include <string_view>
#include <vector>

namespace kdstream
{

// Every motion goes through Move, which stops the eye before the shown surface. An eye outside the
// model's box is outside the surface; from there it moves on straight lines that cross no triangle.
// So the eye stays outside, whatever the motions are. Only zooming out may go through a surface
// that is behind the eye, to a place that is outside again.
//
// Some of the shown surface stays near enough to the focal point to be on the screen
// (Camera::KeepInSight).
//
// Without an open model nothing moves.
class CameraControl
{
public:
  // coasts: as SetCoasting.
  CameraControl(const ShownModel& model, Turning turning, bool coasts);
  CameraControl(const CameraControl&) = delete;

  const Camera& Get() const { return this->Eye; }
  // Whether a pinch, a wheel or a link has moved the eye since the model was fitted.
  bool HasMoved() const { return this->EyeMoved; }

  // Call for another model: forgets the views of the last one.
  void Reset();
  // Goes to the first view, which the model's description has (HomeView).
  void Fit();
  // As ViewerSession::Resize.
  void Resize(const Viewport& viewport);
  void SetTurning(Turning turning);

  // ---- jumps, each of which Undo takes back
  void JumpHome();
  // False for words other than those of ViewerSession::LookFromSide.
  bool JumpToSide(std::string_view side);
  // The direction from the open model towards a side. Nothing for other words, or without a model.
  std::optional<Vec3> TowardsSide(std::string_view side) const;
  // Goes to the place that a link has, if it has one. isJump: Undo takes it back; otherwise this is
  // the first view of the model.
  void TakePlace(const std::optional<CameraPlace>& place, bool isJump);
  bool CanUndo() const { return !this->Earlier.empty(); }
  bool Undo(); // false if there was no jump
  // Sets the view of a host's own camera, which may be inside the surface. False, and no change, if
  // the view is the same. begins: the host's first call, which always counts as a motion.
  bool LookFrom(const Vec3& eye, const Vec3& focal, const Vec3& up, double tangent, bool begins);

  // ---- fingers. Returns the gestures; call EndTouches after they have been used.
  std::vector<Gesture> BeginTouches(const TouchFrame& frame);
  void EndTouches(const TouchFrame& frame);
  void CancelTouches();
  // One finger turns the model, two pan, roll and zoom. When two zoom, the point of the surface
  // under them stays there; if there is none, the point at the depth of the focal point. isTaken: a
  // tool has used the gesture, so that only its zoom counts here.
  void Handle(const Gesture& gesture, double time, bool isTaken);
  // Zooms about pixel (x, y) like a pinch, at once; the model stops turning by itself. False if
  // nothing is open, or if the factor is not finite or not above 0.
  bool ZoomAbout(double factor, double x, double y);
  // The point of the surface under a finger at pixel (x, y).
  std::optional<SurfaceHit> PickUnder(double x, double y) const;

  // ---- turning by itself. Whether the model continues to turn after it is released.
  void SetCoasting(bool coasts);
  void SetSpinning(bool spins) { this->Turned.SetSpinning(spins); }
  bool Coasts() const { return this->Turned.TurnsOn(); }
  bool Spins() const { return this->Turned.IsSpinning(); }
  struct Advanced
  {
    bool spun = false, coasted = false;
  };
  Advanced Advance(double time);

  // ---- the surface. Call when another surface is shown: if it surrounds the eye, the eye steps
  // back.
  void FollowSurface() { this->StepOutside(); }
  // Call when everything wanted has arrived. Until then, an eye at the view of a link may stay
  // inside the surface.
  void Arrive();

private:
  struct View
  {
    Camera eye;
    bool moved = false;
  };
  struct LinkedView
  {
    CameraPlace place;
    Camera eye; // the camera at that place
  };
  // The view when the window began to change its shape.
  struct LeftView
  {
    View view;
    Camera eye; // for the current window
  };

  View Now() const { return { this->Eye, this->EyeMoved }; }
  void NoteJump(const View& before);
  void GoTo(const CameraPlace& place);
  bool GoToLinkedPlace(const Viewport& viewport);
  void Take(const Camera& view, const Viewport& viewport);
  double FreePartTo(const Camera& moved) const;
  void Move(Camera moved);
  void Drag(const Momentum::Drag& drag);
  void Refit(const Viewport& viewport);
  void FocusUnder(double x, double y);
  void PanAndRoll(const Gesture& pinch);
  void Zoom(double factor, double x, double y);
  void StepOutside();

  const ShownModel& Model;
  GestureRecognizer Gestures;
  Camera Eye;
  bool EyeMoved = false;
  Turning Turns;
  bool CoastsOn;
  std::deque<View> Earlier;         // the views before the jumps, the latest last
  std::optional<LinkedView> Linked; // the view of the last link
  std::optional<LeftView> Left;     // the view from which changes of the window are computed
  bool IsArriving = false;          // at a link's view, until its surface is loaded
  bool IsLed = false;               // the host's own camera sets the view
  Momentum Turned;                  // turning by itself
};

}
