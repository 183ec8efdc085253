// SPDX-License-Identifier: BSD-3-Clause
// The tools that the user may choose: see Tools.h.
#include "viewer/session/tools/Tools.h"

#include "filters/model/JsonWriter.h"
#include "viewer/session/section/SurfaceSection.h"

#include <algorithm>
#include <cmath>

namespace kdstream
{

void Tools::Reset()
{
  this->Measures.Reset();
  this->Raking.reset();
}

void Tools::TakeInHand(Tool tool)
{
  this->Hand = tool;
  this->Measures.DropHalf();
}

bool Tools::Take(const Gesture& gesture, const Camera& camera)
{
  using Kind = Gesture::Kind;
  const bool isTap = gesture.kind == Kind::Tap || gesture.kind == Kind::DoubleTap;
  const bool isDrag = isTap || gesture.kind == Kind::Rotate;
  if (this->Hand == Tool::Measure && isTap)
  {
    this->Model.Retry();
    return this->Measures.MeasureAt(
      camera.RayOf(gesture.x, gesture.y), camera.TangentOf(fingerPoints));
  }
  if (this->Hand == Tool::Section && this->Model.Plane() && gesture.kind == Kind::Pinch)
  {
    this->TurnSection(gesture.dx, gesture.dy, camera);
    return true;
  }
  if (this->Hand == Tool::Section && this->Model.Plane() && isDrag)
  {
    this->DragSection(gesture.dx, gesture.dy, camera);
    return true;
  }
  if ((this->Hand == Tool::Light || this->Hand == Tool::SecondLight) && isDrag)
  {
    this->ShineFrom(gesture.x, gesture.y, camera.GetViewport());
    return true;
  }
  return false;
}

// One finger moves the plane along its normal as the normal appears on the screen. If that is too
// short, because the normal is nearly along the line of sight, dragging down brings the plane
// nearer.
void Tools::DragSection(double dx, double dy, const Camera& camera)
{
  constexpr double leastSeen = 0.3; // of the normal's length, on the screen
  const Vec3& normal = this->Model.Plane()->normal;
  const double right = Dot(normal, camera.Right()), up = Dot(normal, camera.Up());
  const double seen = std::sqrt(right * right + up * up);
  const bool isAcross = Dot(normal, camera.Forward()) > 0;
  const double pixels = seen > leastSeen ? (dx * right - dy * up) / seen : dy * (isAcross ? -1 : 1);
  this->Model.section.Move(pixels / camera.PixelsPerUnit());
}

// Two fingers turn the plane like a ball under them: by about a radian for half the window's
// shorter side.
void Tools::TurnSection(double dx, double dy, const Camera& camera)
{
  const Viewport& window = camera.GetViewport();
  const double unit = 1.0 / std::max(std::min(window.width, window.height), 1);
  const Vec3 axis = camera.Up() * (dx * unit) + camera.Right() * (dy * unit);
  this->Model.section.Turn(Quaternion{ 1, axis[0], axis[1], axis[2] }.After({})); // half the angle
}

// ---- light

void Tools::SetLight(const std::optional<RakingLight>& light)
{
  this->Raking = light ? std::optional(Confined(*light)) : std::nullopt;
}

// The chosen light moves to the finger, on a disc that covers most of the window.
void Tools::ShineFrom(double x, double y, const Viewport& window)
{
  constexpr double share = 0.45; // of the window's shorter side: the disc's radius
  const double radius = share * std::max(std::min(window.width, window.height), 1);
  RakingLight light = this->Raking.value_or(RakingLight{});
  const bool isSecond = this->Hand == Tool::SecondLight;
  LightSource lightSource = isSecond ? light.second.value_or(LightSource{}) : light.lightSource;
  lightSource.x = (x - 0.5 * window.width) / radius;
  lightSource.y = (0.5 * window.height - y) / radius;
  (isSecond ? light.second.emplace() : light.lightSource) = lightSource;
  this->Raking = Confined(light);
}

// ---- links

void Tools::PutInto(ViewLink& link, const Camera& camera) const
{
  for (const Measurement& each : this->Measures.All())
  {
    if (each.to && link.measurements.size() < ViewLink::mostMeasurements)
    {
      link.measurements.push_back(
        { camera.PlaceOf(each.from.point), camera.PlaceOf(each.to->point) });
    }
  }
  link.lights = this->Raking;
  if (const SectionPlane* section = this->Model.Plane())
  {
    const Vec3 place = camera.PlaceOf(section->NearestTo(camera.PointAt({})));
    link.section = SectionPlane{ section->normal, Dot(place, section->normal) };
  }
}

void Tools::TakeFrom(const ViewLink& link, const Camera& camera)
{
  this->Raking = link.lights;
  this->Model.section.Set({});
  if (link.section)
  {
    const Vec3& normal = link.section->normal;
    this->Model.section.Set(
      SectionPlane{ normal, Dot(camera.PointAt(normal * link.section->offset), normal) });
  }
  std::vector<std::array<Vec3, 2>> measured = link.measurements;
  for (std::array<Vec3, 2>& points : measured)
  {
    points = { camera.PointAt(points[0]), camera.PointAt(points[1]) };
  }
  this->Measures.Take(measured);
}

std::string SectionOutline(const ShownModel& model)
{
  if (!model.open || !model.Plane())
  {
    return {};
  }
  const ModelDescription& description = model.open->description;
  Resolution coarsest = Resolution::Original();
  for (const SectionSegment& segment : model.section.Outline())
  {
    const Surface& surface = model.Drawn().Parts()[segment.part].part->surface;
    for (const VertexId corner : surface.triangles[segment.triangle])
    {
      coarsest = std::min(coarsest, surface.sources[corner].resolution);
    }
  }
  const std::string error = JsonNumber(ErrorOf(coarsest, description)) +
                            (description.unit.empty() ? "" : " " + description.unit);
  return SectionDrawing(LinesOf(model.section.Outline()), *model.Plane(), description.unit,
    description.title.empty() ? model.id : description.title,
    coarsest.IsOriginal() ? "Within " + error + " of the scan."
                          : "Of a coarser level: about " + error + " from the scan (an estimate).");
}

}
