// SPDX-License-Identifier: BSD-3-Clause
// A textured part as renderers draw it: see TexturedCorners.h.
#include "viewer/session/texture/TexturedCorners.h"

#include "filters/core/VectorMath.h"

#include <algorithm>

namespace kdstream
{
namespace
{

// How many texture places of a point are compared; if it has more, vertices may be repeated.
constexpr unsigned mostPlaces = 64;

constexpr float smooth = 0.94f; // cosine, to a point's normal

}

bool CanTexture(
  const Surface& surface, std::span<const std::uint32_t> corners, const TextureTile& tile)
{
  return !corners.empty() && corners.size() == surface.triangles.size() &&
         std::all_of(corners.begin(), corners.end(),
           [&tile](std::uint32_t corner) { return corner / 3 < tile.corners.size(); });
}

TexturedCorners TexturedCornersOf(
  const Surface& surface, std::span<const std::uint32_t> corners, const TextureTile& tile)
{
  const float width = static_cast<float>(tile.width), height = static_cast<float>(tile.height);
  TexturedCorners textured;
  textured.triangles.reserve(surface.triangles.size());
  // The vertices of a point form a linked list: `last` has its latest vertex, and `before` the one
  // before each vertex.
  std::vector<VertexId> last(surface.points.size(), noVertex), before;
  const auto vertexAt = [&](VertexId point, const std::array<float, 2>& place)
  {
    VertexId vertex = last[point];
    for (unsigned i = 0; vertex != noVertex && textured.places[vertex] != place; ++i)
    {
      vertex = i < mostPlaces ? before[vertex] : noVertex;
    }
    if (vertex == noVertex)
    {
      vertex = static_cast<VertexId>(textured.points.size());
      textured.points.push_back(point);
      textured.places.push_back(place);
      before.push_back(last[point]);
      last[point] = vertex;
    }
    return vertex;
  };
  for (std::size_t i = 0; i < surface.triangles.size(); ++i)
  {
    const auto& coordinates = tile.corners[corners[i] / 3];
    Triangle triangle{};
    for (std::size_t k = 0; k < 3; ++k)
    {
      const TileCoordinate& at = coordinates[(corners[i] + k) % 3];
      triangle[k] = vertexAt(surface.triangles[i][k], { at[0] / width, at[1] / height });
    }
    textured.triangles.push_back(triangle);
  }
  return textured;
}

UnitNormals NormalsOf(
  const TexturedCorners& textured, const Surface& surface, const UnitNormals& normals)
{
  if (normals.empty())
  {
    return {};
  }
  UnitNormals split(textured.points.size());
  // As ComputeVertexNormals, but without a copy of the points: that would be more code in the page.
  std::vector<Vec3> sums(split.size());
  std::vector<VertexId> vertices(surface.points.size());
  for (const VertexId point : textured.points)
  {
    ++vertices[point];
  }
  for (std::size_t i = 0; i < textured.triangles.size(); ++i)
  {
    const Triangle& corners = surface.triangles[i];
    const Vec3 a = surface.points[corners[0]];
    const Vec3 area = Cross(surface.points[corners[1]] - a, surface.points[corners[2]] - a);
    for (const VertexId vertex : textured.triangles[i])
    {
      sums[vertex] = Plus(sums[vertex], area);
    }
  }
  for (std::size_t i = 0; i < split.size(); ++i)
  {
    const VertexId point = textured.points[i];
    const auto own = UnitNormal(sums[i]), shared = normals[point];
    const float cosine = own[0] * shared[0] + own[1] * shared[1] + own[2] * shared[2];
    split[i] = vertices[point] == 1 || cosine > smooth || own == std::array<float, 3>{} ||
                   surface.sources[point].resolution.IsOriginal()
                 ? shared
                 : own;
  }
  return split;
}

}
