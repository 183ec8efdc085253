// SPDX-License-Identifier: BSD-3-Clause
// How large the points of a cloud are drawn. Step "draw" of the pipeline picture.
#pragma once

#include "filters/core/drawing/DrawnSurface.h"

#include <vector>

namespace kdstream
{

// The radii of a cloud's round splats, one a point, in the model's unit. Splats are large enough to
// leave no gaps between neighbours, at the resolution that is shown there.
//
// The points of a drawn surface are in the order of the k-d tree, so points of a run are near each
// other. The spacing of a run of 64 points of one resolution is the mean distance from a point to
// its fourth nearest in the run, without the largest quarter. (On a square grid that is about the
// distance of neighbours, and a little more for scattered points.) A radius is 0.82 of the spacing.
// - A run of fewer than 32 points, as where resolutions meet, has the spacing of the run before it.
// - The spacing of a run (stray points, points on top of each other) is kept between a quarter and
//   four times that of the middle run of its resolution.
//
// No radius is negative or not finite. O(points). REQUIRES: finite coordinates.
std::vector<float> SplatRadii(const Surface& cloud);
// The radii of all parts, one after the other.
std::vector<float> SplatRadii(const DrawnSurface& cloud);

// Splats have at least and at most this number of pixels across, at any distance.
inline constexpr double smallestSplat = 3.0;
inline constexpr double largestSplat = 64.0;

}
