// SPDX-License-Identifier: BSD-3-Clause
// The camera: where one looks from. Step "look" of the README's picture.
#include "viewer/session/Camera.h"

#include <algorithm>
#include <array>
#include <limits>

namespace kdstream
{
namespace
{
constexpr double nearestInRadii = 1e-4, farthestInRadii = 20, focalInRadii = 1.5;
// The fitted box takes 1 / fitMargin of the window.
constexpr double fitMargin = 1.08;
}

void Camera::SetViewport(const Viewport& viewport)
{
  this->View.width = std::max(1, viewport.width);
  this->View.height = std::max(1, viewport.height);
  this->View.pixelRatio = viewport.pixelRatio > 0 ? viewport.pixelRatio : 1;
}

void Camera::FitTo(const Box& box, const Quaternion& orientation)
{
  Box fitted = box;
  if (fitted.Empty())
  {
    fitted.Add(Vec3{ -0.5, -0.5, -0.5 });
    fitted.Add(Vec3{ 0.5, 0.5, 0.5 });
  }
  this->Centre = fitted.lo * 0.5 + fitted.hi * 0.5;
  const double radius = Length(fitted.hi * 0.5 - fitted.lo * 0.5);
  this->Radius = radius > 0 && std::isfinite(radius) ? radius : 1;
  this->FocalPoint = this->Centre;
  this->Turn = orientation;
  // Half the box's extents along the camera's axes.
  const Vec3 sides = fitted.hi * 0.5 - fitted.lo * 0.5;
  const std::array<Vec3, 3> axes{ this->Right(), this->Up(), this->Forward() };
  Vec3 half{};
  for (std::size_t k = 0; k < 3; ++k)
  {
    for (std::size_t i = 0; i < 3; ++i)
    {
      half[k] += std::abs(axes[k][i]) * sides[i];
    }
  }
  const double aspect = static_cast<double>(this->View.width) / this->View.height;
  const double size = std::max(half[1], half[0] / aspect) / tangentOfHalfAngle;
  // The face of the box that is nearest to the eye fits; a flat or tiny box keeps its distance.
  this->EyeDistance =
    std::clamp(fitMargin * size + half[2], this->Radius, farthestInRadii * this->Radius);
}

// Where pixel (x, y) lies on the ball under the window, in the camera's frame.
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
  const Quaternion ball = Quaternion::Between(this->OnBall(fromX, fromY), this->OnBall(toX, toY));
  // The model turns with the finger, so the camera turns the other way, in its own frame.
  this->Turn = this->Turn.After(ball.Inverse());
}

void Camera::Pan(double dx, double dy)
{
  const double unit = 1 / this->PixelsPerUnit();
  Vec3 focal = this->FocalPoint + this->Right() * (-dx * unit) + this->Up() * (dy * unit);
  const Vec3 away = focal - this->Centre;
  const double length = Length(away), limit = focalInRadii * this->Radius;
  if (length > limit)
  {
    focal = this->Centre + away * (limit / length);
  }
  this->FocalPoint = focal;
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
  // In pixels of the new distance, the point under (x, y) has moved away from the middle by this
  // much.
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
  if (Length(focal - this->Centre) <= focalInRadii * this->Radius)
  {
    this->FocalPoint = focal;
    this->EyeDistance = depth;
  }
}

Ray Camera::RayOf(double x, double y) const
{
  const double unit = 2 * tangentOfHalfAngle / this->View.height;
  const Vec3 direction{ (x - this->View.width * 0.5) * unit, (this->View.height * 0.5 - y) * unit,
    -1 };
  return { this->Eye(), Normalized(this->Turn.Rotate(direction)) };
}

std::array<Vec3, 5> Camera::InwardNormals() const
{
  const double aspect = double(this->View.width) / this->View.height;
  const Vec3 ahead = this->Forward();
  const Vec3 up = ahead * tangentOfHalfAngle, right = ahead * (tangentOfHalfAngle * aspect);
  return { ahead, Normalized(up - this->Up()), Normalized(up + this->Up()),
    Normalized(right - this->Right()), Normalized(right + this->Right()) };
}

// A box is not seen if all of it is beyond one of the planes through the eye.
bool Camera::MaySee(const Box& box) const
{
  const Vec3 eye = this->Eye();
  const auto reaches = [&](const Vec3& inward) // the corner of the box that is farthest within
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

double Camera::DistanceTo(const Box& box) const
{
  const Vec3 eye = this->Eye();
  Vec3 away{};
  for (std::size_t k = 0; k < 3; ++k)
  {
    away[k] = std::max({ box.lo[k] - eye[k], eye[k] - box.hi[k], 0.0 });
  }
  return Length(away);
}

double Camera::PointsPerUnit(double distance) const
{
  return this->View.height / (2 * tangentOfHalfAngle * distance * this->View.pixelRatio);
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
  return std::sqrt(aside) / (depth * tangentOfHalfAngle);
}

double Camera::PixelsPerUnit() const
{
  return this->View.height / (2 * tangentOfHalfAngle * this->EyeDistance);
}

}
