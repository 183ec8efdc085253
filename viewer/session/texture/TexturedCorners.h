// SPDX-License-Identifier: BSD-3-Clause
// A textured part as renderers draw it: a point with several places in the texture has a vertex for
// each. Step "render" of the pipeline picture.
#pragma once

#include "filters/codec/TextureTile.h"
#include "filters/core/drawing/Surface.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace kdstream
{

struct TexturedCorners
{
  std::vector<VertexId> points;             // for each vertex, its point of the surface
  std::vector<std::array<float, 2>> places; // for each vertex, 0-1 down from the first row
  std::vector<Triangle> triangles; // indices of vertices, in the order of the surface's triangles
};

// Whether the tile has all texture corners of a surface's triangles (SurfacePart::corners).
// O(triangles).
bool CanTexture(
  const Surface& surface, std::span<const std::uint32_t> corners, const TextureTile& tile);

// Points in no triangle are left out. REQUIRES: CanTexture. O(points + triangles).
TexturedCorners TexturedCornersOf(
  const Surface& surface, std::span<const std::uint32_t> corners, const TextureTile& tile);

}
