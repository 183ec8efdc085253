// SPDX-License-Identifier: BSD-3-Clause
// Where a plane meets a surface: see SurfaceSection.h.
#include "viewer/session/section/SurfaceSection.h"

#include <algorithm>
#include <map>
#include <optional>
#include <utility>

namespace kdstream
{
namespace
{

// Where an edge crosses the plane. Always computed from the kept end to the end that is cut away,
// so that all triangles at the edge get the same point.
Vec3 CrossingOf(const Vec3& kept, double below, const Vec3& away, double above)
{
  const double share = below / (below - above);
  return kept + (away - kept) * share;
}

std::optional<SectionSegment> CutTriangle(
  const std::array<Vec3, 3>& corners, const SectionPlane& plane)
{
  std::array<double, 3> heights{};
  std::transform(corners.begin(), corners.end(), heights.begin(),
    [&plane](const Vec3& corner) { return plane.Above(corner); });
  SectionSegment segment;
  int crossings = 0;
  for (std::size_t i = 0; i < 3; ++i)
  {
    const std::size_t j = (i + 1) % 3;
    const bool isAway = heights[i] > 0, willBeAway = heights[j] > 0;
    if (isAway && !willBeAway)
    {
      segment.from = CrossingOf(corners[j], heights[j], corners[i], heights[i]);
      ++crossings;
    }
    else if (!isAway && willBeAway)
    {
      segment.to = CrossingOf(corners[i], heights[i], corners[j], heights[j]);
      ++crossings;
    }
  }
  return crossings == 2 && segment.from != segment.to ? std::optional(segment) : std::nullopt;
}

}

std::vector<SectionSegment> CutSurface(const DrawnSurface& surface, const SectionPlane& plane)
{
  std::vector<SectionSegment> segments;
  for (std::size_t p = 0; p < surface.Parts().size(); ++p)
  {
    const SurfacePart& part = *surface.Parts()[p].part;
    const std::vector<Triangle>& triangles = part.surface.triangles;
    if (triangles.empty() || !plane.Meets(part.Bounds()))
    {
      continue;
    }
    for (std::size_t i = 0; i < triangles.size(); ++i)
    {
      const auto corner = [&](std::size_t k) { return part.surface.points[triangles[i][k]]; };
      if (auto segment = CutTriangle({ corner(0), corner(1), corner(2) }, plane))
      {
        segment->part = static_cast<std::uint32_t>(p);
        segment->triangle = static_cast<std::uint32_t>(i);
        segments.push_back(*segment);
      }
    }
  }
  return segments;
}

std::vector<SectionLine> LinesOf(const std::vector<SectionSegment>& segments)
{
  std::multimap<Vec3, std::size_t> beginning; // by first point: segments that are in no line yet
  std::map<Vec3, int> ends; // at each place: segments that end there minus those that begin
  for (std::size_t i = 0; i < segments.size(); ++i)
  {
    beginning.emplace(segments[i].from, i);
    ++ends[segments[i].to];
    --ends[segments[i].from];
  }
  std::vector<SectionLine> lines;
  const auto follow = [&](std::multimap<Vec3, std::size_t>::iterator first)
  {
    SectionLine line{ { first->first }, false };
    for (auto next = first; next != beginning.end(); next = beginning.find(line.points.back()))
    {
      line.points.push_back(segments[next->second].to);
      beginning.erase(next);
    }
    line.closed = line.points.front() == line.points.back();
    if (line.closed)
    {
      line.points.pop_back();
    }
    lines.push_back(std::move(line));
  };
  // Open lines come first, from where they begin: from the middle they would be split.
  for (const auto& [place, surplus] : ends)
  {
    for (int i = surplus; i < 0; ++i)
    {
      follow(beginning.find(place));
    }
  }
  while (!beginning.empty())
  {
    follow(beginning.begin());
  }
  return lines;
}

}
