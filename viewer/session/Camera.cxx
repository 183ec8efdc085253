// SPDX-License-Identifier: BSD-3-Clause
// The camera: where the user looks from. Step "navigate" of the pipeline picture.
#include "viewer/session/Camera.h"

#include <algorithm>
#include <array>
#include <limits>

namespace kdstream
{
namespace
{
constexpr double nearestInRadii = 1e-4, farthestInRadii = 20;
// The fitted box takes 1 / fitMargin of the window.
constexpr double fitMargin = 1.08;
constexpr double partOnScreen = 0.8; // of the way from the middle of the screen to an edge
constexpr double mostElevation = 3;  // radians in one call: less than half a turn

// An angle as a point of the unit circle, by arithmetic that every platform rounds the same: starts
// with a small part of the angle and squares repeatedly. The error is less than 1e-9 up to half a
// turn.
struct Direction2
{
  double cosine = 1, sine = 0;
};
Direction2 PointOfAngle(double radians)
{
  constexpr int squarings = 8;
  const double half = radians / (2 << squarings);
  const double t = half + half * half * half / 3; // the tangent of `half`
  const double scale = 1 / (1 + t * t);
  Direction2 point{ (1 - t * t) * scale, 2 * t * scale };
  for (int i = 0; i < squarings; ++i)
  {
    point = { point.cosine * point.cosine - point.sine * point.sine,
      2 * point.sine * point.cosine };
  }
  return point;
}

Vec3 NearestIn(const Box& box, const Vec3& point)
{
  Vec3 nearest{};
  for (std::size_t k = 0; k < 3; ++k)
  {
    nearest[k] = std::clamp(point[k], box.lo[k], box.hi[k]);
  }
  return nearest;
}
}

void Camera::SetViewport(const Viewport& viewport)
{
  this->View.width = std::max(1, viewport.width);
  this->View.height = std::max(1, viewport.height);
  this->View.pixelRatio = viewport.pixelRatio > 0 ? viewport.pixelRatio : 1;
  this->FocalPoint = this->Confined(this->FocalPoint);
}

void Camera::SetTurning(Turning turning)
{
  this->Turns = turning;
  const bool isLevel =
    std::abs(Dot(this->Right(), this->UpAxis)) <= 1e-12 && Dot(this->Up(), this->UpAxis) >= -1e-12;
  if (turning == Turning::Upright && !isLevel)
  {
    this->Turn = LookingFrom(this->Forward() * -1, this->UpAxis);
  }
}

void Camera::FitTo(const Box& box, const Quaternion& orientation)
{
  Box fitted = box;
  if (fitted.Empty())
  {
    fitted.Add(Vec3{ -0.5, -0.5, -0.5 });
    fitted.Add(Vec3{ 0.5, 0.5, 0.5 });
  }
  this->Fitted = fitted;
  const double radius = Length(fitted.hi * 0.5 - fitted.lo * 0.5);
  this->Radius = radius > 0 && std::isfinite(radius) ? radius : 1;
  this->FocalPoint = fitted.lo * 0.5 + fitted.hi * 0.5;
  this->Turn = orientation;
  this->EyeDistance = this->DistanceOfFit();
}

// The two distances from the middle of the turned box at which the face nearest to the eye fills
// the width and the height of the window.
std::array<double, 2> Camera::FitDistances() const
{
  // Half the box's extents along the camera's axes.
  const Vec3 sides = this->Fitted.hi * 0.5 - this->Fitted.lo * 0.5;
  const std::array<Vec3, 3> axes{ this->Right(), this->Up(), this->Forward() };
  Vec3 half{};
  for (std::size_t k = 0; k < 3; ++k)
  {
    for (std::size_t i = 0; i < 3; ++i)
    {
      half[k] += std::abs(axes[k][i]) * sides[i];
    }
  }
  return { fitMargin * (half[0] / this->Aspect() / this->Tangent) + half[2],
    fitMargin * (half[1] / this->Tangent) + half[2] };
}

// Limits a distance to 1 to 20 radii, so that the eye keeps its distance from a flat or tiny box.
double Camera::Bounded(double distance) const
{
  return std::clamp(distance, this->Radius, farthestInRadii * this->Radius);
}

double Camera::DistanceOfFit() const
{
  const auto [across, up] = this->FitDistances();
  return this->Bounded(std::max(across, up));
}

bool Camera::IsFitted() const
{
  return this->FocalPoint == this->PointAt({}) && this->EyeDistance == this->DistanceOfFit();
}

void Camera::MoveTo(const Viewport& window)
{
  const Vec3 focal = this->FocalPoint;
  const double before = this->EyeDistance, aspect = this->Aspect();
  const double spare = std::max(1.0, before / this->DistanceOfFit());
  const auto [across, up] = this->FitDistances();
  this->SetViewport(window);
  const auto [newAcross, newUp] = this->FitDistances();
  const double wide = before < across ? before * aspect / this->Aspect() : newAcross;
  const double high = before < up ? before : newUp;
  this->EyeDistance = this->Bounded(spare * std::max(wide, high));
  this->FocalPoint = this->Confined(focal);
}

Vec3 Camera::PlaceOf(const Vec3& point) const
{
  return (point - (this->Fitted.lo * 0.5 + this->Fitted.hi * 0.5)) * (1 / this->Radius);
}

Vec3 Camera::PointAt(const Vec3& place) const
{
  return this->Fitted.lo * 0.5 + this->Fitted.hi * 0.5 + place * this->Radius;
}

CameraPlace Camera::GetPlace() const
{
  return { this->PlaceOf(this->FocalPoint), this->EyeDistance / this->Radius, this->Turn,
    this->Aspect() };
}

void Camera::SetPlace(const CameraPlace& place)
{
  const double aspect = this->Aspect();
  const double farther = std::max(1.0, std::min(place.aspect, 1.0) / std::min(aspect, 1.0));
  this->Turn = place.orientation;
  this->EyeDistance =
    std::clamp(place.distance * farther, nearestInRadii, farthestInRadii) * this->Radius;
  this->FocalPoint = this->Confined(this->PointAt(place.focal));
}

void Camera::LookFrom(const Vec3& eye, const Vec3& focal, const Vec3& up, double tangent)
{
  this->FocalPoint = focal;
  this->EyeDistance = Length(eye - focal);
  this->Turn = LookingFrom(Normalized(eye - focal), up);
  this->Tangent = tangent;
}

// The point of the trackball under pixel (x, y), in the camera's frame.
Vec3 Camera::OnBall(double x, double y) const
{
  const double size = std::min(this->View.width, this->View.height) * 0.5;
  const double bx = (x - this->View.width * 0.5) / size;
  const double by = (this->View.height * 0.5 - y) / size;
  const double square = bx * bx + by * by;
  const double bz = square <= 0.5 ? std::sqrt(1 - square) : 0.5 / std::sqrt(square);
  return Normalized({ bx, by, bz });
}

void Camera::Rotate(double fromX, double fromY, double toX, double toY)
{
  if (this->Turns == Turning::Upright)
  {
    this->RotateUpright(toX - fromX, toY - fromY);
    return;
  }
  const Quaternion ball = Quaternion::Between(this->OnBall(fromX, fromY), this->OnBall(toX, toY));
  // The model turns with the finger, so the camera turns the other way, in its own frame.
  this->Turn = this->Turn.After(ball.Inverse());
}

// Computes the new orientation only from the direction to the right, which is horizontal, and from
// the elevation. So rounding errors never add up to a tilted horizon.
void Camera::RotateUpright(double dx, double dy)
{
  const double radians = 2.0 / std::min(this->View.width, this->View.height); // of one pixel
  const Vec3& up = this->UpAxis;
  const Vec3 before = Normalized(this->Right() - up * Dot(this->Right(), up));
  const Direction2 heading = PointOfAngle(std::clamp(-dx * radians, -100.0, 100.0));
  const Vec3 right =
    Normalized(before * heading.cosine + Cross(up, before) * heading.sine); // turned about up
  const double turn = std::clamp(dy * radians, -mostElevation, mostElevation);
  const Direction2 by = PointOfAngle(turn);
  const double level = Dot(this->Up(), up), height = -Dot(this->Forward(), up);
  double cosine = level * by.cosine - height * by.sine;
  double sine = level * by.sine + height * by.cosine;
  if (cosine < 0) // the eye would go beyond straight above or below
  {
    cosine = 0;
    sine = turn > 0 ? 1 : -1;
  }
  const Vec3 ahead = Cross(right, up); // level, towards the eye
  const Vec3 back = Normalized(ahead * cosine + up * sine);
  this->Turn = Quaternion::OfAxes(right, Cross(back, right), back);
}

void Camera::Roll(double cosine, double sine, double x, double y)
{
  if (this->Turns == Turning::Upright)
  {
    return;
  }
  const double unit = 1 / this->PixelsPerUnit();
  const double right = (x - this->View.width * 0.5) * unit;
  const double up = (this->View.height * 0.5 - y) * unit;
  const Vec3 pivot = this->FocalPoint + this->Right() * right + this->Up() * up;
  const Quaternion turned = Quaternion::Between({ 1, 0, 0 }, { cosine, -sine, 0 });
  this->Turn = this->Turn.After(turned.Inverse());
  this->FocalPoint = this->Confined(pivot - this->Right() * right - this->Up() * up);
}

// How far the focal point may be from the box. A sphere of this radius around the focal point is on
// the screen, with a margin (partOnScreen). So the nearest point of the box is, too.
double Camera::Reach(double distance) const
{
  return partOnScreen * this->Tangent * std::min(1.0, this->Aspect()) * distance;
}

Vec3 Camera::Confined(const Vec3& focal) const
{
  return this->Near(focal, NearestIn(this->Fitted, focal));
}

// Moves a focal point within reach of `point`, if it is not.
Vec3 Camera::Near(const Vec3& focal, const Vec3& point) const
{
  constexpr double rounding = 1 + 1e-9; // a point moved within reach is not moved again
  const double away = Length(focal - point), most = this->Reach();
  return away > most * rounding ? point + (focal - point) * (most / away) : focal;
}

void Camera::KeepInSight(const Vec3& point)
{
  this->FocalPoint = this->Near(this->FocalPoint, point);
}

void Camera::Pan(double dx, double dy)
{
  const double unit = 1 / this->PixelsPerUnit();
  this->FocalPoint =
    this->Confined(this->FocalPoint + this->Right() * (-dx * unit) + this->Up() * (dy * unit));
}

void Camera::StepBack(double length)
{
  this->EyeDistance = std::min(this->EyeDistance + length, farthestInRadii * this->Radius);
}

Camera Camera::PartOfTheWayTo(const Camera& moved, double part) const
{
  Camera camera = *this;
  camera.FocalPoint = this->FocalPoint + (moved.FocalPoint - this->FocalPoint) * part;
  camera.EyeDistance = this->EyeDistance + (moved.EyeDistance - this->EyeDistance) * part;
  return camera;
}

void Camera::Zoom(double factor, double x, double y)
{
  if (!(factor > 0) || !std::isfinite(factor))
  {
    return;
  }
  const double before = this->EyeDistance;
  this->EyeDistance =
    std::clamp(before / factor, nearestInRadii * this->Radius, farthestInRadii * this->Radius);
  // In pixels at the new distance: how far the point under (x, y) has moved away from the middle.
  const double moved = before / this->EyeDistance - 1;
  this->Pan((this->View.width * 0.5 - x) * moved, (this->View.height * 0.5 - y) * moved);
}

void Camera::FocusAtDepthOf(const Vec3& point)
{
  const Vec3 eye = this->Eye();
  const double depth = Dot(point - eye, this->Forward());
  if (!(depth >= nearestInRadii * this->Radius) || !(depth <= farthestInRadii * this->Radius))
  {
    return;
  }
  const Vec3 focal = eye + this->Forward() * depth;
  if (Length(focal - NearestIn(this->Fitted, focal)) <= this->Reach(depth))
  {
    this->FocalPoint = focal;
    this->EyeDistance = depth;
  }
}

Ray Camera::RayOf(double x, double y) const
{
  const double unit = 2 * this->Tangent / this->View.height;
  const Vec3 direction{ (x - this->View.width * 0.5) * unit, (this->View.height * 0.5 - y) * unit,
    -1 };
  return { this->Eye(), Normalized(this->Turn.Rotate(direction)) };
}

std::optional<std::array<double, 2>> Camera::PixelOf(const Vec3& point) const
{
  const Vec3 sight = point - this->Eye();
  const double depth = Dot(sight, this->Forward());
  if (!(depth > 0))
  {
    return {};
  }
  const double unit = this->View.height / (2 * this->Tangent * depth);
  return std::array<double, 2>{ this->View.width * 0.5 + Dot(sight, this->Right()) * unit,
    this->View.height * 0.5 - Dot(sight, this->Up()) * unit };
}

std::array<Vec3, 5> Camera::InwardNormals() const
{
  const Vec3 ahead = this->Forward();
  const Vec3 up = ahead * this->Tangent, right = ahead * (this->Tangent * this->Aspect());
  return { ahead, Normalized(up - this->Up()), Normalized(up + this->Up()),
    Normalized(right - this->Right()), Normalized(right + this->Right()) };
}

// A box is not seen if all of it is beyond one of the planes through the eye.
bool Camera::MaySee(const Box& box) const
{
  const Vec3 eye = this->Eye();
  const auto reaches = [&](const Vec3& inward) // how far the box reaches in this direction
  {
    double farthest = 0;
    for (std::size_t k = 0; k < 3; ++k)
    {
      farthest += std::max(inward[k] * (box.lo[k] - eye[k]), inward[k] * (box.hi[k] - eye[k]));
    }
    return farthest >= 0;
  };
  const auto planes = this->InwardNormals();
  return !box.Empty() && std::all_of(planes.begin(), planes.end(), reaches);
}

double Camera::PointsPerUnit(double distance) const
{
  return this->View.height / (2 * this->Tangent * distance * this->View.pixelRatio);
}

double Camera::Eccentricity(const Vec3& point) const
{
  const Vec3 sight = point - this->Eye();
  const double depth = Dot(sight, this->Forward());
  if (!(depth > 0))
  {
    return std::numeric_limits<double>::infinity();
  }
  const double aside = std::max(0.0, Dot(sight, sight) - depth * depth);
  return std::sqrt(aside) / (depth * this->Tangent);
}

double Camera::PixelsPerUnit() const
{
  return this->View.height / (2 * this->Tangent * this->EyeDistance);
}

}
