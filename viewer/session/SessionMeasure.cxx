// SPDX-License-Identifier: BSD-3-Clause
// Measuring: where a tap puts an end of a distance, and how it comes to lie on the original. Step
// "pick" of the pipeline picture.
//
// An end is picked on what is shown, with the error of that. The partition around it is fetched as
// the original, before all else; where a triangle there reaches into others, these too. After each
// new surface the end is picked anew, by the same ray, until all corners there are the original's.
//
// In a section an end near the outline is on that, and so on the surface; one within the cap is a
// point of the plane, which is exact.
#include "viewer/session/ViewerSession.h"

#include "filters/core/tree/Region.h"

#include <algorithm>
#include <cmath>

namespace kdstream
{
namespace
{

constexpr std::size_t mostMeasurements = 64;
constexpr std::size_t mostPartitionsOfEnd = 12;

std::vector<VertexId> CornersOf(const Surface& surface, std::size_t hit)
{
  if (surface.triangles.empty())
  {
    return { static_cast<VertexId>(hit) };
  }
  const Triangle& t = surface.triangles[hit];
  return { t.begin(), t.end() };
}

}

void ViewerSession::SetTool(Tool tool)
{
  this->InHand = tool;
  if (!this->Measured.empty() && !this->Measured.back().to)
  {
    this->RemoveMeasurement(this->Measured.size() - 1); // half of one
  }
  this->Trace("tool");
}

void ViewerSession::RemoveMeasurement(std::size_t index)
{
  if (index >= this->Measured.size())
  {
    return;
  }
  this->Measured.erase(this->Measured.begin() + static_cast<std::ptrdiff_t>(index));
  std::erase_if(this->Ends, [index](const End& end) { return end.measurement == index; });
  for (End& end : this->Ends)
  {
    end.measurement -= end.measurement > index ? 1 : 0;
  }
  this->Update();
}

void ViewerSession::NameMeasurement(std::size_t index, const std::string& name)
{
  if (index < this->Measured.size())
  {
    this->Measured[index].name = name;
  }
}

bool ViewerSession::MeasureAt(double x, double y)
{
  this->Retry();
  const auto hit = this->EndOn(this->Eye.RayOf(x, y));
  const bool begins = this->Measured.empty() || this->Measured.back().to.has_value();
  if (!hit || (begins && this->Measured.size() >= mostMeasurements))
  {
    return false;
  }
  if (begins)
  {
    this->Measured.push_back({ std::to_string(++this->MeasurementsMade), {}, {} });
  }
  else
  {
    this->Measured.back().to.emplace();
  }
  this->Ends.push_back(
    { this->Measured.size() - 1, !begins, false, this->Eye.RayOf(x, y), {}, {} });
  if (!this->Settle(this->Ends.back(), *hit))
  {
    this->Ends.pop_back();
  }
  return true;
}

// Where a ray puts an end.
std::optional<SurfaceHit> ViewerSession::EndOn(const Ray& ray) const
{
  constexpr double near = 0.5; // of a finger: on the outline is meant
  auto hit = this->Pick(ray, this->FingerSlack());
  if (hit && hit->part == ShownSection::capPart)
  {
    const auto edge =
      this->Section.NearestOnOutline(hit->point, near * this->FingerSlack() * hit->distance);
    hit = edge ? edge : hit;
  }
  return hit;
}

// Where an end is that somebody else tells of.
std::optional<SurfaceHit> ViewerSession::EndAt(const Vec3& point, double error) const
{
  constexpr double rounding = 1e-7; // of the model's size
  const DrawnSurface& surface = *this->Shown.GetSurface();
  const std::optional<SectionPlane>& section = this->Section.Plane();
  const Box& box = this->Current->box;
  if (!section || std::abs(section->Above(point)) > rounding * Length(box.hi - box.lo))
  {
    return NearestOnSurface(surface, point);
  }
  const auto edge = this->Section.NearestOnOutline(point, error);
  return edge ? edge : SurfaceHit{ point, 0, 0, ShownSection::capPart };
}

// As somebody else measured: both points are on the original, to which they come when it is there.
void ViewerSession::AddTold(const std::array<Vec3, 2>& points)
{
  if (this->Measured.size() >= mostMeasurements)
  {
    return;
  }
  const double unknown = ErrorBoundOf(
    Resolution::Level(PreviewLevel(this->Current->description)), this->Current->description);
  const auto told = [&](std::size_t i) {
    return MeasuredPoint{ points[i], Resolution::Level(0), unknown, true };
  };
  this->Measured.push_back({ std::to_string(++this->MeasurementsMade), told(0), told(1) });
  for (const bool isSecond : { false, true })
  {
    const Vec3& point = points[isSecond ? 1 : 0];
    this->Ends.push_back(
      { this->Measured.size() - 1, isSecond, true, { point, {} }, {}, { point } });
  }
}

MeasuredPoint& ViewerSession::PointOf(const End& end)
{
  Measurement& measurement = this->Measured[end.measurement];
  return end.isSecond ? *measurement.to : measurement.from;
}

// Notes what was hit; whether the end waits for the original there.
bool ViewerSession::Settle(End& end, const SurfaceHit& hit)
{
  const ModelDescription& model = this->Current->description;
  if (hit.part == ShownSection::capPart)
  {
    this->PointOf(end) = { hit.point, Resolution::Original(), 0, false };
    return false;
  }
  const Surface& surface = this->Shown.GetSurface()->Parts()[hit.part].part->surface;
  MeasuredPoint& point = this->PointOf(end);
  point = { hit.point, Resolution::Original(), 0, false };
  std::vector<Vec3> coarse;
  for (const VertexId corner : CornersOf(surface, hit.triangle))
  {
    const Resolution resolution = surface.sources[corner].resolution;
    point.error = std::max(point.error, ErrorBoundOf(resolution, model));
    point.resolution = std::min(point.resolution, resolution);
    if (!resolution.IsOriginal())
    {
      coarse.push_back(surface.points[corner]);
    }
  }
  const auto isShown = [this](std::uint32_t partition) { return this->Shown.IsRefined(partition); };
  const bool isAllShown = std::all_of(end.partitions.begin(), end.partitions.end(), isShown);
  if (isAllShown) // or none are known yet: the first is that around the hit
  {
    end.around = end.partitions.empty() ? std::vector<Vec3>{ hit.point } : coarse;
  }
  point.waits = !coarse.empty() && model.HasLevels() && model.detail == ModelDetail::Regions &&
                end.partitions.size() < mostPartitionsOfEnd;
  return point.waits;
}

// Which partitions are around the ends that wait, as far as the tree is known.
void ViewerSession::FollowEnds()
{
  Model& model = *this->Current;
  std::erase_if(this->Ends,
    [this](const End& end)
    {
      const bool isGivenUp = this->IsGivenUp(end);
      this->PointOf(end).waits = !isGivenUp;
      return isGivenUp;
    });
  for (End& end : this->Ends)
  {
    std::erase_if(end.around,
      [&](const Vec3& place)
      {
        const NearestAnswer nearest = NearestKnownPartition(model.tree, model.codec.depths, place);
        if (nearest.known && nearest.partition)
        {
          end.partitions.insert(*nearest.partition);
        }
        return nearest.known;
      });
  }
}

// On the surface that has just been drawn.
void ViewerSession::PickEndsAnew()
{
  std::erase_if(this->Ends,
    [this](End& end)
    {
      const MeasuredPoint before = this->PointOf(end);
      const DrawnSurface& surface = *this->Shown.GetSurface();
      auto hit = end.isTold ? this->EndAt(end.ray.origin, before.error) : this->EndOn(end.ray);
      // The surface that was meant may lie behind another one by now, or beside the ray.
      const double tolerance = 2 * before.error + 1e-3 * Length(before.point - end.ray.origin);
      if (!end.isTold && (!hit || Length(hit->point - before.point) > tolerance))
      {
        hit = NearestOnSurface(surface, before.point);
      }
      if (!hit)
      {
        return false; // as it was, until there is more
      }
      return !this->Settle(end, *hit);
    });
}

// Where what it waits for cannot be had, it stays on the level.
bool ViewerSession::IsGivenUp(const End& end) const
{
  const bool treeIsMissing = !end.around.empty() && !this->FailedTree.empty();
  return treeIsMissing ||
         std::any_of(end.partitions.begin(), end.partitions.end(),
           [this](std::uint32_t partition)
           {
             return this->FailedPieces.count({ Resolution::Original(),
                      NodeOfPartition(partition, this->Current->codec.depths) }) > 0;
           });
}

}
