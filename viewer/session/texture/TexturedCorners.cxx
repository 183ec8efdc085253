// SPDX-License-Identifier: BSD-3-Clause
// A textured part as renderers draw it: see TexturedCorners.h.
#include "viewer/session/texture/TexturedCorners.h"

#include <algorithm>

namespace kdstream
{
namespace
{

// How many texture places of a point are compared; if it has more, vertices may be repeated.
constexpr unsigned mostPlaces = 64;

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

}
