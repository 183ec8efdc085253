// SPDX-License-Identifier: BSD-3-Clause
// What every renderer decides in the same way about a scene: see SceneRules.h.
#include "viewer/session/appearance/SceneRules.h"

#include "filters/model/JsonWriter.h"
#include "viewer/session/Geometry.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

namespace kdstream
{

Status CheckSurface(const Surface& surface, const Vec3& center)
{
  constexpr std::size_t limit = std::numeric_limits<std::int32_t>::max();
  if (surface.points.size() > limit || surface.triangles.size() > limit / 3)
  {
    return Error{ ErrorCode::LimitExceeded,
      "a surface of " + std::to_string(surface.points.size()) + " points and " +
        std::to_string(surface.triangles.size()) + " triangles is too large to draw" };
  }
  if (surface.sources.size() != surface.points.size())
  {
    return Error{ ErrorCode::InvalidInput, std::to_string(surface.sources.size()) +
                                             " sources for " +
                                             std::to_string(surface.points.size()) + " points" };
  }
  for (const Attribute& array : surface.attributes)
  {
    if (array.TupleCount() != surface.points.size())
    {
      return Error{ ErrorCode::InvalidInput, std::to_string(array.TupleCount()) + " values of " +
                                               array.name + " for " +
                                               std::to_string(surface.points.size()) + " points" };
    }
  }
  for (std::size_t i = 0; i < surface.points.size(); ++i)
  {
    for (const double difference : surface.points[i] - center)
    {
      if (!(std::abs(difference) <= static_cast<double>(std::numeric_limits<float>::max())))
      {
        return Error{ ErrorCode::InvalidInput,
          "point " + std::to_string(i) + " cannot be drawn: a coordinate is not finite" };
      }
    }
  }
  for (std::size_t i = 0; i < surface.triangles.size(); ++i)
  {
    const Triangle& t = surface.triangles[i];
    if (std::max({ t[0], t[1], t[2] }) >= surface.points.size())
    {
      return Error{ ErrorCode::InvalidInput,
        "triangle " + std::to_string(i) + " has a vertex that does not exist" };
    }
  }
  return {};
}

Status CheckCamera(const SceneCamera& camera)
{
  const Vec3 sight = camera.focal - camera.eye;
  if (!IsFinite(camera.eye) || !IsFinite(camera.focal) || !IsFinite(camera.up) || !IsFinite(sight))
  {
    return Error{ ErrorCode::InvalidArgument, "camera: a coordinate is not finite" };
  }
  if (Dot(sight, sight) == 0.0)
  {
    return Error{ ErrorCode::InvalidArgument, "camera: the eye is at the focal point" };
  }
  const double along = Dot(sight, camera.up);
  constexpr double parallel = 1.0 - 1e-12; // squared cosine of 1 µrad
  if (!(along * along < parallel * Dot(sight, sight) * Dot(camera.up, camera.up)))
  {
    return Error{ ErrorCode::InvalidArgument, "camera: up is zero or along the line of sight" };
  }
  if (!(camera.verticalFieldOfView > 0.0 && camera.verticalFieldOfView < std::numbers::pi))
  {
    const double degrees = camera.verticalFieldOfView * (180 / std::numbers::pi);
    return Error{ ErrorCode::InvalidArgument, "camera: a field of view of " +
                                                JsonNumber(std::round(degrees * 1e6) / 1e6) +
                                                " degrees is not between 0 and 180" };
  }
  return {};
}

Box BoundsAround(const Surface& surface, const Vec3& center)
{
  Box bounds;
  for (const Vec3& point : surface.points)
  {
    bounds.Add(point - center);
  }
  return bounds;
}

Box Enlarged(const Box& bounds, double margin)
{
  Box larger = bounds;
  for (std::size_t k = 0; k < 3 && !bounds.Empty(); ++k)
  {
    larger.lo[k] -= margin;
    larger.hi[k] += margin;
  }
  return larger;
}

double FacetLength(const DrawnSurface& surface)
{
  double least = 0.0;
  for (const DrawnSurface::Part& part : surface.Parts())
  {
    const double length = FacetLength(part.part->surface);
    least = least == 0.0 || (length > 0.0 && length < least) ? length : least;
  }
  return least;
}

double FacetLength(const Surface& surface)
{
  constexpr std::size_t looks = 64;
  const std::size_t triangles = surface.triangles.size();
  const std::size_t step = std::max<std::size_t>(triangles / looks, 1);
  double sum = 0.0;
  std::size_t edges = 0;
  for (std::size_t i = 0; i < triangles; i += step)
  {
    const Triangle& t = surface.triangles[i];
    for (std::size_t k = 0; k < 3; ++k, ++edges)
    {
      sum += Length(surface.points[t[k]] - surface.points[t[(k + 1) % 3]]);
    }
  }
  return edges > 0 ? sum / static_cast<double>(edges) : 0.0;
}

ClippingPlanes PlanesAround(const Box& bounds, const Vec3& eye, const Vec3& focal)
{
  // The box's extent along the line of sight: that of its center, plus and minus its projected half
  // sides.
  const Vec3 sight = focal - eye;
  const double distance = std::sqrt(Dot(sight, sight));
  double nearest = distance;
  double farthest = distance;
  if (!bounds.Empty())
  {
    double middle = 0.0;
    double reach = 0.0;
    for (std::size_t k = 0; k < 3; ++k)
    {
      const double half = 0.5 * (bounds.hi[k] - bounds.lo[k]);
      middle += (bounds.lo[k] + half - eye[k]) * sight[k] / distance;
      reach += half * std::abs(sight[k]) / distance;
    }
    nearest = middle - reach;
    farthest = middle + reach;
  }
  // A margin for rounding; and if the eye is inside the box, a near plane that leaves a 24-bit
  // depth buffer enough precision to separate surfaces.
  const double margin = 0.01 * (farthest - nearest) + 1e-6 * distance;
  const double farPlane = std::max(farthest + margin, distance * 1e-3);
  const double nearPlane = std::max(nearest - margin, farPlane * 1e-4);
  return { nearPlane, farPlane };
}

const Attribute* OwnColors(const Surface& surface)
{
  return FindRole(surface.attributes, AttributeRole::Colors);
}

bool HasOwnColors(const DrawnSurface& surface)
{
  return std::any_of(surface.Parts().begin(), surface.Parts().end(),
    [](const DrawnSurface::Part& part) { return OwnColors(part.part->surface) != nullptr; });
}

Color OwnColor(const Attribute& colors, std::size_t point)
{
  const std::uint8_t* bytes = colors.values.data() + point * colors.components;
  return { bytes[0], bytes[1], bytes[2] };
}

UnitNormals NormalsOf(const Surface& surface)
{
  if (!surface.triangles.empty())
  {
    return ComputeVertexNormals(surface.points, surface.triangles);
  }
  UnitNormals normals;
  if (const Attribute* own = FindRole(surface.attributes, AttributeRole::Normals))
  {
    normals.reserve(surface.points.size());
    for (std::size_t i = 0; i < surface.points.size(); ++i)
    {
      normals.push_back(UnitNormal({ own->Get(i, 0), own->Get(i, 1), own->Get(i, 2) }));
    }
  }
  return normals;
}

ColorSource ColorSourceOf(const Surface::Source& vertex, const TreeDepths& depths)
{
  const bool inOne = vertex.resolution.IsOriginal() || vertex.resolution.Depth() >= depths.stitch;
  return { inOne ? std::optional(PartitionOfKey(vertex.key)) : std::nullopt, vertex.resolution };
}

ColorSource Together(const ColorSource& a, const ColorSource& b)
{
  ColorSource together;
  together.partition = a.partition && b.partition ? std::min(*a.partition, *b.partition)
                       : a.partition              ? a.partition
                                                  : b.partition;
  together.resolution = std::max(a.resolution, b.resolution);
  return together;
}

Color ColorOf(const ColorSource& source, SurfaceColoring coloring)
{
  if (coloring == SurfaceColoring::Resolution)
  {
    return ResolutionColor(source.resolution);
  }
  return coloring == SurfaceColoring::Partition && source.partition
           ? PartitionColor(*source.partition)
           : stoneColor;
}

}
