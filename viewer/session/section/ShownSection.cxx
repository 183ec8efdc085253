// SPDX-License-Identifier: BSD-3-Clause
// The section that the user has put through the model: see ShownSection.h.
#include "viewer/session/section/ShownSection.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace kdstream
{
namespace
{

constexpr double nearAnAxis = 0.9962; // the cosine of 5 degrees

Vec3 Snapped(const Vec3& normal)
{
  for (std::size_t k = 0; k < 3; ++k)
  {
    if (std::abs(normal[k]) > nearAnAxis)
    {
      Vec3 axis{};
      axis[k] = normal[k] > 0 ? 1 : -1;
      return axis;
    }
  }
  return normal;
}

Vec3 NearestOnSegment(const SectionSegment& segment, const Vec3& point)
{
  const Vec3 way = segment.to - segment.from;
  const double square = Dot(way, way);
  const double share = square > 0 ? Dot(point - segment.from, way) / square : 0;
  return segment.from + way * std::clamp(share, 0.0, 1.0);
}

}

void ShownSection::Reset(const Box& box)
{
  this->Around = box;
  this->Set({});
}

void ShownSection::Take(const SectionPlane& plane)
{
  this->Cut = plane;
  if (!this->Around.Empty())
  {
    this->Cut->offset =
      std::clamp(plane.offset, plane.LeastOf(this->Around), plane.MostOf(this->Around));
  }
}

void ShownSection::Set(const std::optional<SectionPlane>& plane)
{
  if (!plane)
  {
    this->Cut.reset();
    this->Made.reset();
    this->Segments.clear();
    this->FillingVersion += this->Filling ? 1 : 0;
    this->Filling.reset();
    return;
  }
  const double length = Length(plane->normal);
  if (std::isfinite(length) && length > 0 && std::isfinite(plane->offset))
  {
    this->Turned = plane->normal * (1 / length);
    this->Take({ this->Turned, plane->offset / length });
  }
}

bool ShownSection::SetAlong(std::string_view word, const Vec3& toEye)
{
  constexpr std::array<std::string_view, 3> axes{ "x", "y", "z" };
  const auto axis = std::find(axes.begin(), axes.end(), word);
  if (word == "off")
  {
    this->Set({});
  }
  else if (word == "flip")
  {
    if (this->Cut)
    {
      this->Set(SectionPlane{ this->Cut->normal * -1, -this->Cut->offset });
    }
  }
  else if (word == "view" || axis != axes.end())
  {
    Vec3 direction = toEye;
    if (axis != axes.end())
    {
      direction = {};
      direction[static_cast<std::size_t>(axis - axes.begin())] = 1;
    }
    this->SetAcross(direction, toEye);
  }
  else
  {
    return false;
  }
  return true;
}

void ShownSection::SetAcross(const Vec3& direction, const Vec3& toEye)
{
  const Vec3 normal = Normalized(direction) * (Dot(direction, toEye) < 0 ? -1 : 1);
  const Vec3 middle = this->Around.Empty() ? Vec3{} : this->Around.lo * 0.5 + this->Around.hi * 0.5;
  this->Set(SectionPlane{ normal, Dot(normal, middle) });
}

double ShownSection::Depth() const
{
  if (!this->Cut || this->Around.Empty())
  {
    return 0;
  }
  const double least = this->Cut->LeastOf(this->Around), most = this->Cut->MostOf(this->Around);
  return most > least ? (most - this->Cut->offset) / (most - least) : 0;
}

void ShownSection::SetDepth(double depth)
{
  if (this->Cut && !this->Around.Empty() && std::isfinite(depth))
  {
    const double least = this->Cut->LeastOf(this->Around), most = this->Cut->MostOf(this->Around);
    this->Take({ this->Cut->normal, most - std::clamp(depth, 0.0, 1.0) * (most - least) });
  }
}

void ShownSection::Move(double length)
{
  if (this->Cut && std::isfinite(length))
  {
    this->Take({ this->Cut->normal, this->Cut->offset + length });
  }
}

void ShownSection::Turn(const Quaternion& turn)
{
  if (!this->Cut || this->Around.Empty())
  {
    return;
  }
  const Vec3 pivot = this->Cut->NearestTo(this->Around.lo * 0.5 + this->Around.hi * 0.5);
  this->Turned = Normalized(turn.Rotate(this->Turned));
  const Vec3 normal = Snapped(this->Turned);
  this->Take({ normal, Dot(normal, pivot) });
}

void ShownSection::Follow(const DrawnSurface& surface, std::uint64_t surfaceVersion, bool isClosed)
{
  if (!this->Cut)
  {
    return;
  }
  const Basis now{ *this->Cut, surfaceVersion, isClosed };
  if (this->Made == now)
  {
    return;
  }
  this->Made = now;
  this->Segments = CutSurface(surface, *this->Cut);
  this->Filling = isClosed ? std::make_shared<Surface>(CapOf(this->Segments, *this->Cut)) : nullptr;
  ++this->FillingVersion;
}

std::optional<SurfaceHit> ShownSection::Pick(
  const DrawnSurface& surface, const Ray& ray, double slack) const
{
  if (!this->Cut)
  {
    return PickSurface(surface, ray, slack);
  }
  const SectionPlane::Part kept = this->Cut->KeptOf(ray);
  if (kept.begin > kept.end)
  {
    return std::nullopt;
  }
  if (kept.begin > 0 && this->Filling)
  {
    if (auto filled = PickSurface(*this->Filling, ray))
    {
      filled->part = capPart;
      return filled;
    }
  }
  const auto hit = PickSurface(surface, ray, slack, nullptr, kept.begin);
  return hit && hit->distance <= kept.end ? hit : std::nullopt;
}

std::optional<SurfaceHit> ShownSection::NearestOnOutline(const Vec3& point, double most) const
{
  std::optional<SurfaceHit> nearest;
  for (const SectionSegment& segment : this->Segments)
  {
    const Vec3 place = NearestOnSegment(segment, point);
    const double distance = Length(place - point);
    if (distance <= (nearest ? nearest->distance : most))
    {
      nearest = SurfaceHit{ place, segment.triangle, distance, segment.part };
    }
  }
  return nearest;
}

}
