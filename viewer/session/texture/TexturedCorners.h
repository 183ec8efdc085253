// SPDX-License-Identifier: BSD-3-Clause
// A textured part as renderers draw it: a vertex for each place in the texture that a point has.
// Step "render" of the pipeline picture.
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
  std::vector<VertexId> points;             // of each vertex, its point of the surface
  std::vector<std::array<float, 2>> places; // of each vertex, 0-1 from the picture's first row down
  std::vector<Triangle> triangles;          // of vertices, in the order of the surface's
};

// Whether the tile has all texture corners of a surface's triangles (SurfacePart::corners).
// O(triangles).
bool CanTexture(
  const Surface& surface, std::span<const std::uint32_t> corners, const TextureTile& tile);

// Points in no triangle are left out. REQUIRES: CanTexture. O(points + triangles).
TexturedCorners TexturedCornersOf(
  const Surface& surface, std::span<const std::uint32_t> corners, const TextureTile& tile);

}
