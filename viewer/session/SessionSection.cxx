// SPDX-License-Identifier: BSD-3-Clause
// A plane that cuts part of the model away, raking light, and what fingers do to them: steps "look"
// and "draw" of the pipeline picture.
#include "viewer/session/ViewerSession.h"

#include "filters/model/JsonWriter.h"
#include "viewer/session/section/SectionDrawing.h"

#include <algorithm>
#include <cmath>

namespace kdstream
{

std::optional<SurfaceHit> ViewerSession::Pick(const Ray& ray, double slack) const
{
  return this->Section.Pick(*this->Shown.GetSurface(), ray, slack);
}

// Outline and cap of what is shown now.
void ViewerSession::FollowSection()
{
  this->Section.Follow(
    *this->Shown.GetSurface(), this->Shown.Version(), this->Current && this->Current->isClosed);
}

void ViewerSession::SectionMoved()
{
  this->Update(); // what is cut away is not wanted any more
  this->Trace("section");
}

void ViewerSession::SetSection(const std::optional<SectionPlane>& plane)
{
  if (this->Current)
  {
    this->Section.Set(plane);
    this->SectionMoved();
  }
}

bool ViewerSession::SetSectionAlong(std::string_view word)
{
  const bool known = this->Section.SetAlong(word, this->Eye.Forward() * -1);
  if (known && !this->Current)
  {
    this->Section.Set({});
  }
  this->SectionMoved();
  return known;
}

void ViewerSession::SetSectionDepth(double depth)
{
  this->Section.SetDepth(depth);
  this->SectionMoved();
}

// One finger moves the plane along its normal, as that is seen on the screen; where it points at
// the eye, downwards is nearer.
void ViewerSession::DragSection(double dx, double dy)
{
  if (!this->Section.Plane())
  {
    return;
  }
  constexpr double leastSeen = 0.3; // of the normal's length
  const Vec3& normal = this->Section.Plane()->normal;
  const double right = Dot(normal, this->Eye.Right()), up = Dot(normal, this->Eye.Up());
  const double seen = std::sqrt(right * right + up * up);
  const bool isAcross = Dot(normal, this->Eye.Forward()) > 0;
  const double pixels = seen > leastSeen ? (dx * right - dy * up) / seen : dy * (isAcross ? -1 : 1);
  this->Section.Move(pixels / this->Eye.PixelsPerUnit());
}

// Two fingers turn it, as a ball under them: by a radian for half the window's shorter side.
void ViewerSession::TurnSection(double dx, double dy)
{
  const Viewport& window = this->Eye.GetViewport();
  const double unit = 1.0 / std::max(std::min(window.width, window.height), 1);
  const Vec3 axis = this->Eye.Up() * (dx * unit) + this->Eye.Right() * (dy * unit);
  this->Section.Turn(Quaternion{ 1, axis[0], axis[1], axis[2] }.After({})); // half the angle
}

std::string ViewerSession::SectionOutline() const
{
  if (!this->Current || !this->Section.Plane())
  {
    return {};
  }
  const ModelDescription& model = this->Current->description;
  Resolution coarsest = Resolution::Original();
  for (const SectionSegment& segment : this->Section.Outline())
  {
    const Surface& surface = this->Shown.GetSurface()->Parts()[segment.part].part->surface;
    for (const VertexId corner : surface.triangles[segment.triangle])
    {
      coarsest = std::min(coarsest, surface.sources[corner].resolution);
    }
  }
  const std::string unit = model.unit.empty() ? "" : " " + model.unit;
  return SectionDrawing(LinesOf(this->Section.Outline()), *this->Section.Plane(), model.unit,
    model.title.empty() ? this->ModelId : model.title,
    "Within " + JsonNumber(ErrorBoundOf(coarsest, model)) + unit + " of the scan.");
}

// ---- light

void ViewerSession::SetLight(const std::optional<RakingLight>& light)
{
  this->Lamps = light ? std::optional(Confined(*light)) : std::nullopt;
  this->Trace("light");
}

// The lamp in hand stands where the finger is: on a disc as wide as most of the window.
void ViewerSession::ShineFrom(double x, double y)
{
  constexpr double share = 0.45; // of the window's shorter side: the disc's radius
  const Viewport& window = this->Eye.GetViewport();
  const double radius = share * std::max(std::min(window.width, window.height), 1);
  RakingLight light = this->Lamps.value_or(RakingLight{});
  const bool isSecond = this->InHand == Tool::SecondLight;
  RakingLamp lamp = isSecond ? light.second.value_or(RakingLamp{}) : light.lamp;
  lamp.x = (x - 0.5 * window.width) / radius;
  lamp.y = (0.5 * window.height - y) / radius;
  (isSecond ? light.second.emplace() : light.lamp) = lamp;
  this->Lamps = Confined(light);
}

}
