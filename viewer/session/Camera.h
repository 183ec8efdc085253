// SPDX-License-Identifier: BSD-3-Clause
// The camera: where the user looks from. Step "navigate" of the pipeline picture.
#pragma once

#include "viewer/session/Geometry.h"

#include <array>
#include <optional>

namespace kdstream
{

// The part of the screen that is drawn to.
struct Viewport
{
  int width = 1;  // pixels
  int height = 1; // pixels
  // Pixels for one point of the screen (2 or 3 on most phones).
  double pixelRatio = 1;
  bool operator==(const Viewport&) const = default;
};

struct Ray
{
  Vec3 origin;
  Vec3 direction; // of length 1
};

// How a finger turns the model.
enum class Turning
{
  Upright, // like a turntable: turns about the model's up axis, and tilts up and down; the
           // horizon stays level
  Free     // like a ball under the finger; two fingers roll it
};

// A camera's place, independent of the model's size and position: lengths are in radii of the
// sphere around the fitted box, and points are relative to the middle of the box.
struct CameraPlace
{
  Vec3 focal{};
  double distance = 1;
  Quaternion orientation;
  double aspect = 1; // of the window: width / height
  bool operator==(const CameraPlace&) const = default;
};

// A perspective camera that turns about a focal point.
//
// The state is the focal point, the distance to it, and an orientation; eye, up and rays follow
// from these. In the camera's frame x is right, y up, and the view goes along -z. Model units
// throughout. A viewer's vertical angle of view is fixed: its tangent is a literal, so the picture
// does not depend on the rounding of library functions.
class Camera
{
public:
  static constexpr double viewAngle = 0.52359877559829887;          // radians, vertical
  static constexpr double tangentOfHalfAngle = 0.26794919243112270; // of viewAngle / 2

  void SetViewport(const Viewport& viewport);
  const Viewport& GetViewport() const { return this->View; }

  // Sets the axis of the turntable, of length 1. Default: y.
  void SetUp(const Vec3& up) { this->UpAxis = up; }
  // Default: Free. Upright levels the horizon; the eye and the line of sight stay as they are.
  void SetTurning(Turning turning);
  Turning GetTurning() const { return this->Turns; }

  // Sets the view in which all of `box` just fits into the window, portrait and landscape alike:
  // along -z of the model with y up, or with the given orientation. Sets the limits of panning and
  // zooming, in radii of the sphere around the box. An empty box counts as the unit cube.
  void FitTo(const Box& box, const Quaternion& orientation = {});

  // Shows the same view in another window, as large as possible: all that was visible of the box
  // stays visible, with the same margin, so a fitted view fits again. The distance stays within the
  // limits of FitTo.
  void MoveTo(const Viewport& window);
  // Whether focal point and distance are still those that FitTo set.
  bool IsFitted() const;

  CameraPlace GetPlace() const;
  // Converts a point of the model to the units of CameraPlace, and back.
  Vec3 PlaceOf(const Vec3& point) const;
  Vec3 PointAt(const Vec3& place) const;
  // Takes a place of another camera, within the limits of panning and zooming. If that camera's
  // window has another shape, all of the largest square in its middle stays visible. REQUIRES:
  // finite numbers, an orientation of length 1.
  void SetPlace(const CameraPlace& place);

  // Sets the view of another camera, whatever it looks at. tangent: the tangent of half the
  // vertical angle of view, above 0. REQUIRES: an eye that is not at the focal point, and up not
  // along the line of sight.
  void LookFrom(const Vec3& eye, const Vec3& focal, const Vec3& up, double tangent);

  // Turns about the focal point, for a finger that went from one pixel to the other. Free: as if a
  // ball under the window followed the finger (Bell's trackball: a sphere in the middle, a
  // hyperbola around it, so it never jumps). Upright: horizontal moves turn about the up axis;
  // vertical moves turn about the screen's horizontal axis, until the eye is straight above or
  // below. In the middle of the window this is as fast as with the ball.
  void Rotate(double fromX, double fromY, double toX, double toY);
  // Turns the picture clockwise about pixel (x, y), by the angle that has this cosine and sine.
  // Does nothing if turning is upright.
  void Roll(double cosine, double sine, double x, double y);
  // Moves what lies in the focal plane by (dx, dy) pixels. Stops early enough for some of the
  // fitted box to stay on the screen, however the model is turned afterwards: a point of the box
  // stays within 0.8 of the way from the middle of the screen to its nearest edge.
  void Pan(double dx, double dy);
  // Enlarges by `factor` > 0 (below 1: makes smaller) so that the point of the focal plane under
  // pixel (x, y) stays there, within the limits of Pan. The distance stays between 1e-4 and 20
  // radii.
  void Zoom(double factor, double x, double y);
  // Moves the focal point along the view's axis to the depth of `point`, without changing eye and
  // picture. Does nothing if the point is behind the eye, if the distance would be out of its
  // limits, or if the box could then be turned off the screen.
  void FocusAtDepthOf(const Vec3& point);
  // The largest distance from the focal point at which a point is on the screen however the model
  // is turned: it then appears within 0.8 of the way from the middle to the nearest edge.
  double Reach() const { return this->Reach(this->EyeDistance); }
  // Moves the focal point straight towards `point`, until `point` is within Reach().
  void KeepInSight(const Vec3& point);
  // Moves the eye away from the focal point, which stays, by a length of 0 or more; to at most 20
  // radii.
  void StepBack(double length);
  // A camera between this one (part 0) and `moved` (part 1), which has only panned and zoomed away
  // from it: eye, focal point and distance change linearly.
  Camera PartOfTheWayTo(const Camera& moved, double part) const;

  Ray RayOf(double x, double y) const;
  // The pixel of a point, counted from the upper left corner; it may be outside the window. Nothing
  // if the point is behind the eye.
  std::optional<std::array<double, 2>> PixelOf(const Vec3& point) const;
  // Whether any of a box may be on the screen: always true if some of it is, sometimes also if none
  // of it is. False for an empty box.
  bool MaySee(const Box& box) const;
  // The inward normals, of length 1, of the five planes through the eye that bound what is visible:
  // ahead, and the four sides.
  std::array<Vec3, 5> InwardNormals() const;
  // The distance from the eye to the nearest point of a box that is not empty; 0 within it.
  double DistanceTo(const Box& box) const { return kdstream::DistanceTo(box, this->Eye()); }
  // The most points of the screen (pixels / pixel ratio) that a length of 1 can take at a distance
  // of `distance` > 0 from the eye.
  double PointsPerUnit(double distance) const;
  // How far from the middle of the screen a point appears: 0 there, 1 at the middle of the upper
  // edge; infinity if it is behind the eye.
  double Eccentricity(const Vec3& point) const;
  // The length of one model unit in the focal plane: in pixels, and in points of the screen.
  double PixelsPerUnit() const;
  double FocalPointsPerUnit() const { return this->PixelsPerUnit() / this->View.pixelRatio; }
  // The tangent of the angle that this number of points covers in the middle of the screen.
  double TangentOf(double points) const
  {
    return points * this->View.pixelRatio / (this->PixelsPerUnit() * this->EyeDistance);
  }

  const Vec3& Focal() const { return this->FocalPoint; }
  double Distance() const { return this->EyeDistance; }
  const Quaternion& Orientation() const { return this->Turn; }
  Vec3 Eye() const { return this->FocalPoint + this->Turn.Rotate({ 0, 0, this->EyeDistance }); }
  Vec3 Up() const { return this->Turn.Rotate({ 0, 1, 0 }); }
  Vec3 Right() const { return this->Turn.Rotate({ 1, 0, 0 }); }
  Vec3 Forward() const { return this->Turn.Rotate({ 0, 0, -1 }); }
  bool operator==(const Camera&) const = default;

private:
  double Aspect() const { return static_cast<double>(this->View.width) / this->View.height; }
  std::array<double, 2> FitDistances() const;
  double Bounded(double distance) const;
  double DistanceOfFit() const;
  Vec3 OnBall(double x, double y) const;
  void RotateUpright(double dx, double dy);
  double Reach(double distance) const;
  Vec3 Confined(const Vec3& focal) const;
  Vec3 Near(const Vec3& focal, const Vec3& point) const;

  Viewport View;
  Vec3 FocalPoint{};
  double EyeDistance = 1;
  double Tangent = tangentOfHalfAngle;
  Quaternion Turn;
  Turning Turns = Turning::Free;
  Vec3 UpAxis{ 0, 1, 0 };
  Box Fitted{ { -0.5, -0.5, -0.5 }, { 0.5, 0.5, 0.5 } };
  double Radius = 1; // of the sphere around it
};

}
