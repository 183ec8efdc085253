// SPDX-License-Identifier: BSD-3-Clause
// The camera: where one looks from. Step "look" of the README's picture.
#pragma once

#include "viewer/session/Geometry.h"

#include <array>

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

// A perspective camera that turns about a focal point.
//
// The state is the focal point, the distance to it, and an orientation; eye, up and rays follow
// from these. In the camera's frame x is right, y up, and the view goes along -z. Model units
// throughout. The vertical angle of view is fixed: its tangent is a literal, so that no library
// function has a say in what is drawn.
class Camera
{
public:
  static constexpr double viewAngle = 0.52359877559829887;          // radians, vertical
  static constexpr double tangentOfHalfAngle = 0.26794919243112270; // of viewAngle / 2

  void SetViewport(const Viewport& viewport);
  const Viewport& GetViewport() const { return this->View; }

  // Looks along -z of the model, y up, unless told otherwise, so that all of `box` just fits into
  // the window, portrait and landscape alike. Sets the limits of panning and zooming, in radii of
  // the sphere around the box. An empty box counts as the unit cube.
  void FitTo(const Box& box, const Quaternion& orientation = {});

  // A finger went from one pixel to the other: turns about the focal point as if a ball under the
  // window followed it (Bell's trackball: a sphere in the middle, a hyperbola around it, so it
  // never jumps).
  void Rotate(double fromX, double fromY, double toX, double toY);
  // What lies in the focal plane follows a finger that moved by (dx, dy) pixels. The focal point
  // stays within 1.5 radii of the fitted box's sphere.
  void Pan(double dx, double dy);
  // Enlarges by `factor` > 0 (below 1: makes smaller) so that the point of the focal plane under
  // pixel (x, y) stays there. The distance stays between 1e-4 and 20 radii.
  void Zoom(double factor, double x, double y);
  // Moves the focal point along the view's axis to the depth of `point`, with eye and picture
  // unchanged. Points behind the eye or outside the limits of the distance change nothing.
  void FocusAtDepthOf(const Vec3& point);

  Ray RayOf(double x, double y) const;
  // Whether any of a box may be on the screen: true where it is, and at times where it is not. Of
  // an empty box false.
  bool MaySee(const Box& box) const;
  // Of the planes through the eye that bound what is on the screen: ahead, and the four sides; of
  // length 1.
  std::array<Vec3, 5> InwardNormals() const;
  // From the eye to the nearest point of a box that is not empty; 0 within it.
  double DistanceTo(const Box& box) const;
  // Points of the screen (pixels / pixel ratio) that a length of 1 takes at most, `distance` > 0
  // away from the eye.
  double PointsPerUnit(double distance) const;
  // How far from the middle of the screen a point is seen: 0 there, 1 at the middle of its upper
  // edge; infinite behind the eye.
  double Eccentricity(const Vec3& point) const;
  // Pixels of one model unit in the focal plane.
  double PixelsPerUnit() const;

  const Vec3& Focal() const { return this->FocalPoint; }
  double Distance() const { return this->EyeDistance; }
  const Quaternion& Orientation() const { return this->Turn; }
  Vec3 Eye() const { return this->FocalPoint + this->Turn.Rotate({ 0, 0, this->EyeDistance }); }
  Vec3 Up() const { return this->Turn.Rotate({ 0, 1, 0 }); }
  Vec3 Right() const { return this->Turn.Rotate({ 1, 0, 0 }); }
  Vec3 Forward() const { return this->Turn.Rotate({ 0, 0, -1 }); }

private:
  Vec3 OnBall(double x, double y) const;

  Viewport View;
  Vec3 FocalPoint{};
  double EyeDistance = 1;
  Quaternion Turn;
  Vec3 Centre{};     // of the fitted box
  double Radius = 1; // of the sphere around it
};

}
