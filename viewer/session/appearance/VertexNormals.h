// SPDX-License-Identifier: BSD-3-Clause
// Normals of a drawn surface, for shading. Step "draw" of the pipeline picture.
#pragma once

#include "filters/core/Types.h"

#include <array>
#include <span>
#include <vector>

namespace kdstream
{

// `v` scaled to length 1; (0, 0, 0) if `v` has no direction, or is not finite.
std::array<float, 3> UnitNormal(const Vec3& v);

using UnitNormals = std::vector<std::array<float, 3>>; // one for each point

// UnitNormal of each vector.
UnitNormals UnitNormalsOf(std::span<const Vec3> vectors);

// The unit normal of every point: the sum of its triangles' normals, weighted by their areas.
// Input: n points, triangles over them. Output: n normals; (0, 0, 0) for a point without triangles,
// or whose triangles have no area or cancel out. Depends on the differences of points only, so
// far-away origins are harmless. O(points + triangles). REQUIRES: indices below n.
UnitNormals ComputeVertexNormals(std::span<const Vec3> points, std::span<const Triangle> triangles);

}
