// SPDX-License-Identifier: BSD-3-Clause
// Measuring: see MeasureTool.h.
#include "viewer/session/tools/MeasureTool.h"

#include "filters/core/tree/Region.h"

#include <algorithm>
#include <cmath>

namespace kdstream
{
namespace
{

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

void MeasureTool::Reset()
{
  this->Measured.clear();
  this->Ends.clear();
  this->Made = 0;
}

void MeasureTool::DropHalf()
{
  if (!this->Measured.empty() && !this->Measured.back().to)
  {
    this->Remove(this->Measured.size() - 1);
  }
}

void MeasureTool::Remove(std::size_t index)
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
}

void MeasureTool::Name(std::size_t index, const std::string& name)
{
  if (index < this->Measured.size())
  {
    this->Measured[index].name = name;
  }
}

bool MeasureTool::MeasureAt(const Ray& ray, double slack)
{
  const auto hit = this->EndOn(ray, slack);
  const bool begins = this->Measured.empty() || this->Measured.back().to.has_value();
  if (!hit || (begins && this->Measured.size() >= mostMeasurements))
  {
    return false;
  }
  if (begins)
  {
    this->Measured.push_back({ std::to_string(++this->Made), {}, {} });
  }
  else
  {
    this->Measured.back().to.emplace();
  }
  this->Ends.push_back({ this->Measured.size() - 1, !begins, false, ray, {}, {} });
  if (!this->Settle(this->Ends.back(), *hit))
  {
    this->Ends.pop_back();
  }
  return true;
}

// The end of a distance that a ray hits.
std::optional<SurfaceHit> MeasureTool::EndOn(const Ray& ray, double slack) const
{
  constexpr double near = 0.5; // of a finger's width: a hit this near means the outline
  auto hit = this->Model.Pick(ray, slack);
  if (hit && hit->part == ShownSection::capPart)
  {
    const auto edge =
      this->Model.section.NearestOnOutline(hit->point, near * slack * hit->distance);
    hit = edge ? edge : hit;
  }
  return hit;
}

// The place of an end in another user's measurement.
std::optional<SurfaceHit> MeasureTool::EndAt(const Vec3& point, double error) const
{
  constexpr double rounding = 1e-7; // of the model's size
  const SectionPlane* section = this->Model.Plane();
  const Box& box = this->Model.open->description.box;
  if (!section || std::abs(section->Above(point)) > rounding * Length(box.hi - box.lo))
  {
    return NearestOnSurface(this->Model.Drawn(), point);
  }
  const auto edge = this->Model.section.NearestOnOutline(point, error);
  return edge ? edge : SurfaceHit{ point, 0, 0, ShownSection::capPart };
}

void MeasureTool::Take(const std::vector<std::array<Vec3, 2>>& measured)
{
  this->Measured.clear();
  this->Ends.clear();
  for (const std::array<Vec3, 2>& points : measured)
  {
    this->Add(points);
  }
}

void MeasureTool::Add(const std::array<Vec3, 2>& points)
{
  if (this->Measured.size() >= mostMeasurements)
  {
    return;
  }
  const double unknown = ErrorOf(this->Model.Preview().resolution, this->Model.open->description);
  const auto reported = [&](std::size_t i) {
    return MeasuredPoint{ points[i], Resolution::Level(0), unknown, true };
  };
  this->Measured.push_back({ std::to_string(++this->Made), reported(0), reported(1) });
  for (const bool isSecond : { false, true })
  {
    const Vec3& point = points[isSecond ? 1 : 0];
    this->Ends.push_back(
      { this->Measured.size() - 1, isSecond, true, { point, {} }, {}, { point } });
  }
}

MeasuredPoint& MeasureTool::PointOf(const End& end)
{
  Measurement& measurement = this->Measured[end.measurement];
  return end.isSecond ? *measurement.to : measurement.from;
}

// Records what was hit. Returns whether the end waits for the original there.
bool MeasureTool::Settle(End& end, const SurfaceHit& hit)
{
  const ModelDescription& model = this->Model.open->description;
  if (hit.part == ShownSection::capPart)
  {
    this->PointOf(end) = { hit.point, Resolution::Original(), 0, false };
    return false;
  }
  const Surface& surface = this->Model.Drawn().Parts()[hit.part].part->surface;
  MeasuredPoint& point = this->PointOf(end);
  point = { hit.point, Resolution::Original(), 0, false };
  std::vector<Vec3> coarse;
  for (const VertexId corner : CornersOf(surface, hit.triangle))
  {
    const Resolution resolution = surface.sources[corner].resolution;
    point.error = std::max(point.error, ErrorOf(resolution, model));
    point.resolution = std::min(point.resolution, resolution);
    if (!resolution.IsOriginal())
    {
      coarse.push_back(surface.points[corner]);
    }
  }
  const auto isShown = [this](std::uint32_t partition)
  { return this->Model.surface.IsRefined(partition); };
  const bool isAllShown = std::all_of(end.partitions.begin(), end.partitions.end(), isShown);
  if (isAllShown) // also if no partition is known yet: the first is that around the hit
  {
    end.around = end.partitions.empty() ? std::vector<Vec3>{ hit.point } : coarse;
  }
  point.waits = !coarse.empty() && model.HasLevels() && model.detail == ModelDetail::Regions &&
                end.partitions.size() < mostPartitionsOfEnd;
  return point.waits;
}

void MeasureTool::FollowTree()
{
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
        const NearestAnswer nearest =
          NearestKnownPartition(this->Model.open->tree, this->Model.Depths(), place);
        if (nearest.known && nearest.partition)
        {
          end.partitions.insert(*nearest.partition);
        }
        return nearest.known;
      });
  }
}

void MeasureTool::FollowSurface(double slack)
{
  std::erase_if(this->Ends,
    [&](End& end)
    {
      const MeasuredPoint before = this->PointOf(end);
      auto hit =
        end.isOfLink ? this->EndAt(end.ray.origin, before.error) : this->EndOn(end.ray, slack);
      // The surface that the user tapped may now be behind another one, or beside the ray.
      const double tolerance = 2 * before.error + 1e-3 * Length(before.point - end.ray.origin);
      if (!end.isOfLink && (!hit || Length(hit->point - before.point) > tolerance))
      {
        hit = NearestOnSurface(this->Model.Drawn(), before.point);
      }
      if (!hit)
      {
        return false; // no change until more is loaded
      }
      return !this->Settle(end, *hit);
    });
}

// Whether what the end waits for has failed.
bool MeasureTool::IsGivenUp(const End& end) const
{
  const FailedBlobs& failed = this->Model.failed;
  return (!end.around.empty() && !failed.Tree().empty()) ||
         std::any_of(end.partitions.begin(), end.partitions.end(),
           [&](std::uint32_t partition) { return failed.Has(this->Model.Partition(partition)); });
}

void MeasureTool::AddTo(std::vector<PieceId>& pieces) const
{
  for (const End& end : this->Ends)
  {
    for (const std::uint32_t partition : end.partitions)
    {
      pieces.push_back(this->Model.Partition(partition));
    }
  }
}

}
