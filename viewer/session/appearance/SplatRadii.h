// SPDX-License-Identifier: BSD-3-Clause
// How large the points of a cloud are drawn. Step "draw" of the pipeline picture.
#pragma once

#include "filters/core/drawing/DrawnSurface.h"

#include <vector>

namespace kdstream
{

// The radii of a cloud's round splats, one for each point, in model units. Splats are large enough
// to leave no gaps between neighbours, at the resolution that is shown there.
//
// The points of a drawn surface are in the order of the k-d tree, so consecutive points (a run) are
// near each other. The spacing of a run of 64 points of one resolution is the mean distance from a
// point to its fourth nearest in the run, without the largest quarter of these distances. (On a
// square grid that is about the distance of neighbours, and a little more for scattered points.) A
// radius is 0.82 of the spacing.
// - A run of fewer than 32 points, as where resolutions meet, has the spacing of the run before it.
// - The spacing of a run is kept between a quarter and four times the median spacing of its
//   resolution, because of stray points and points on top of each other.
//
// All radii are finite, and none is negative. O(points). REQUIRES: finite coordinates.
std::vector<float> SplatRadii(const Surface& cloud);
// The radii of all parts, one after the other.
std::vector<float> SplatRadii(const DrawnSurface& cloud);

// The least and the most pixels across a splat, at any distance.
inline constexpr double smallestSplat = 3.0;
inline constexpr double largestSplat = 64.0;

}
