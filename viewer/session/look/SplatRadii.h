// SPDX-License-Identifier: BSD-3-Clause
// How large the points of a cloud are drawn. Step "draw" of the pipeline picture.
#pragma once

#include "filters/core/drawing/DrawnSurface.h"

#include <vector>

namespace kdstream
{

// The radii of the round splats that a cloud is drawn with, one a point, in the model's unit: large
// enough to close up with their neighbours' at the resolution that is shown there.
//
// A drawn surface has its points in the order of the k-d tree, so a run of them lies together: the
// spacing of a run of 64 points of one resolution is the mean distance from a point to the fourth
// nearest of the run, its largest quarter left out (about that of neighbours on a square grid, and
// a little more than it where points are scattered), and a radius is 0.82 of it. Runs of
// fewer than 32 points, as where resolutions meet, are spaced as the run before them. Runs that are
// spaced far more or less than half of the others of their resolution (stray points, points on top
// of each other) are held to between a quarter and four times the others' spacing. No radius is
// negative or not finite. O(points). REQUIRES: finite coordinates.
std::vector<float> SplatRadii(const Surface& cloud);
// Of all parts, one after the other.
std::vector<float> SplatRadii(const DrawnSurface& cloud);

// What is drawn has at least and at most so many pixels across, however near or far it is.
inline constexpr double smallestSplat = 3.0;
inline constexpr double largestSplat = 64.0;

}
