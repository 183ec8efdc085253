// SPDX-License-Identifier: BSD-3-Clause
// The camera: where one looks from. Step "look" of the pipeline picture.
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
  Upright, // a turntable: about the model's up, and towards its top and bottom; the horizon is
           // level
  Free     // as a ball under the finger, and two fingers roll it
};

// Where a camera stands, whatever the model's size and place: lengths in radii of the sphere around
// the fitted box, from its middle.
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
// throughout. A viewer's vertical angle of view is fixed: its tangent is a literal, so that no
// library function has a say in what is drawn.
class Camera
{
public:
  static constexpr double viewAngle = 0.52359877559829887;          // radians, vertical
  static constexpr double tangentOfHalfAngle = 0.26794919243112270; // of viewAngle / 2

  void SetViewport(const Viewport& viewport);
  const Viewport& GetViewport() const { return this->View; }

  // The axis of the turntable, of length 1: y until it is set.
  void SetUp(const Vec3& up) { this->UpAxis = up; }
  // Free until it is set. Upright levels the horizon, with eye and line of sight unchanged.
  void SetTurning(Turning turning);
  Turning GetTurning() const { return this->Turns; }

  // Looks along -z of the model, y up, unless told otherwise, so that all of `box` just fits into
  // the window, portrait and landscape alike. Sets the limits of panning and zooming, in radii of
  // the sphere around the box. An empty box counts as the unit cube.
  void FitTo(const Box& box, const Quaternion& orientation = {});

  // The same view in another window, as large as it can be: all of the box is to be seen that was,
  // and as much is left around it, so that a fitted view fits again. The distance is within the
  // limits of FitTo.
  void MoveTo(const Viewport& window);
  // Whether it looks as FitTo has it.
  bool IsFitted() const;

  CameraPlace GetPlace() const;
  // A point of the model, in these lengths, and back.
  Vec3 PlaceOf(const Vec3& point) const;
  Vec3 PointAt(const Vec3& place) const;
  // In a window of another shape the whole of the largest square in the middle is seen still.
  // Within the limits of panning and zooming. REQUIRES: finite numbers, an orientation of length 1.
  void SetPlace(const CameraPlace& place);

  // As a camera of somebody else's looks, whatever it looks at. tangent: of half the vertical angle
  // of view, above 0. REQUIRES: an eye that is not at the focal point, and up not along the line of
  // sight.
  void LookFrom(const Vec3& eye, const Vec3& focal, const Vec3& up, double tangent);

  // A finger went from one pixel to the other: turns about the focal point. Free: as if a ball
  // under the window followed it (Bell's trackball: a sphere in the middle, a hyperbola around it,
  // so it never jumps). Upright: across about the up axis, up and down about the screen's
  // horizontal as far as straight above and below; in the middle as fast as the ball.
  void Rotate(double fromX, double fromY, double toX, double toY);
  // The picture turns clockwise about pixel (x, y), by an angle with this cosine and sine; where
  // turning is upright nothing does.
  void Roll(double cosine, double sine, double x, double y);
  // What lies in the focal plane follows a finger that moved by (dx, dy) pixels, as far as some of
  // the fitted box stays on the screen: a point of it within 0.8 of the way from the middle to the
  // nearest edge. That holds then however one turns.
  void Pan(double dx, double dy);
  // Enlarges by `factor` > 0 (below 1: makes smaller) so that the point of the focal plane under
  // pixel (x, y) stays there, as far as Pan goes. The distance stays between 1e-4 and 20 radii.
  void Zoom(double factor, double x, double y);
  // Moves the focal point along the view's axis to the depth of `point`, with eye and picture
  // unchanged. Points behind the eye, outside the limits of the distance, or where the box could
  // be turned off the screen then, change nothing.
  void FocusAtDepthOf(const Vec3& point);
  // How far a point may be from the focal point so that it is on the screen whichever way one
  // turns: 0.8 of the way to the nearest edge, there.
  double Reach() const { return this->Reach(this->EyeDistance); }
  // The focal point comes so near to `point`, on the straight way.
  void KeepInSight(const Vec3& point);
  // Away from the focal point, which stays, by a length of 0 or more; no farther than 20 radii.
  void StepBack(double length);
  // Between this camera (0) and one that only panned and zoomed away from it (1): eye, focal point
  // and distance on straight lines.
  Camera PartOfTheWayTo(const Camera& moved, double part) const;

  Ray RayOf(double x, double y) const;
  // Where a point is seen, pixels from the upper left corner, perhaps beside the window; nothing
  // behind the eye.
  std::optional<std::array<double, 2>> PixelOf(const Vec3& point) const;
  // Whether any of a box may be on the screen: true where it is, and at times where it is not. Of
  // an empty box false.
  bool MaySee(const Box& box) const;
  // Of the planes through the eye that bound what is on the screen: ahead, and the four sides; of
  // length 1.
  std::array<Vec3, 5> InwardNormals() const;
  // From the eye to the nearest point of a box that is not empty; 0 within it.
  double DistanceTo(const Box& box) const { return kdstream::DistanceTo(box, this->Eye()); }
  // Points of the screen (pixels / pixel ratio) that a length of 1 takes at most, `distance` > 0
  // away from the eye.
  double PointsPerUnit(double distance) const;
  // How far from the middle of the screen a point is seen: 0 there, 1 at the middle of its upper
  // edge; infinite behind the eye.
  double Eccentricity(const Vec3& point) const;
  // Pixels of one model unit in the focal plane; points of the screen.
  double PixelsPerUnit() const;
  double FocalPointsPerUnit() const { return this->PixelsPerUnit() / this->View.pixelRatio; }
  // The tangent of the angle that so many points of the screen take, in its middle.
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
