// SPDX-License-Identifier: BSD-3-Clause
// A textured part as renderers draw it: a point with several places in the texture has a vertex for
// each. Step "render" of the pipeline picture.
#pragma once

#include "filters/codec/TextureTile.h"
#include "filters/core/drawing/Surface.h"
#include "viewer/session/appearance/VertexNormals.h"

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

// A normal for each vertex. `normals`: one for each point of the surface, or none, then the result
// is empty too. A vertex has its point's normal. At a sharp edge of a level that normal lies
// between both sides, and would darken triangles several pixels deep. Charts of levels part at such
// edges: where the triangles of one chart turn away from the point's normal by more than 20
// degrees, the vertex has the normal of these triangles. Vertices of the original keep their
// points' normals, and so do points with one vertex: the triangles of other parts count at the
// border of a part. O(points + triangles).
UnitNormals NormalsOf(
  const TexturedCorners& textured, const Surface& surface, const UnitNormals& normals);

}
