// SPDX-License-Identifier: BSD-3-Clause
// Charts of a level's piece, which has no texture coordinates of its own. Part of step "encode" of
// the pipeline picture: texture tiles.
#pragma once

#include "filters/core/Types.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace kdstream
{

// Triangles that lie beside each other on a plane, none over another.
struct LevelChart
{
  std::vector<std::uint32_t> triangles; // numbers
  Vec3 u{}, v{};                        // axes of the plane, of length 1
  std::array<double, 2> lo{}, hi{};     // of the corners along the axes
};

// Steps: 1. From the first triangle that has no chart a chart grows over edges, to triangles whose
// normals are within 53 degrees of the chart's mean normal. 2. They are projected on the plane of
// this normal. What is too steep there, or lies over another triangle in the middle of a square of
// `spacing`, is left for charts to come. 3. The axes are turned so that the box is small.
//
// Each triangle is in one chart. Triangles without area are in the chart of a neighbour. O(n log n)
// where charts are flat; deterministic. REQUIRES: finite points; spacing > 0.
std::vector<LevelChart> GrowLevelCharts(
  std::span<const Vec3> points, std::span<const Triangle> triangles, double spacing);

}
