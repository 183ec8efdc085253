// SPDX-License-Identifier: BSD-3-Clause
// Makes charts for a level's piece, which has no texture coordinates of its own. Part of step
// "encode" of the pipeline picture: texture tiles.
#pragma once

#include "filters/core/Types.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace kdstream
{

// Neighbouring triangles, projected to a plane so that none lies over another.
struct LevelChart
{
  std::vector<std::uint32_t> triangles; // numbers of triangles
  Vec3 u{}, v{};                        // axes of the plane, of length 1
  std::array<double, 2> lo{}, hi{};     // the range of the corners along the axes
};

// Steps:
// 1. From the first triangle without a chart, a chart grows over edges, to triangles with normals
//    within 53 degrees of the chart's mean normal.
// 2. They are projected to the plane of this normal. A triangle is left for later charts if it is
//    too steep, or if it lies over another triangle at the centre of a square of size `spacing`.
// 3. The axes are turned so that the box is small.
//
// Each triangle is in one chart. Triangles without area are in the chart of a neighbour. O(n log n)
// if charts are flat; deterministic. REQUIRES: finite points; spacing > 0.
std::vector<LevelChart> GrowLevelCharts(
  std::span<const Vec3> points, std::span<const Triangle> triangles, double spacing);

}
